"""Merging: of every two neighbours one is kept and represents the molecules of both (docs/theory.md, Merging)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.base.compiled import kernel
from billow.parts.gas.corpuscular.cells import Cells
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.random_numbers import stream, uniform

GROUP = 128
"""Fewest merged particles that share one correction, unless there are fewer of their kind. The factor on their
velocities is 1 to within about sqrt(2/(3 GROUP)): different flows within a group are hardly changed."""

MOST_MERGES = 10
"""Most merges of a run that draws in no air: a bag that starts almost empty does not get ever lighter particles."""

MERGING = 0x4D45_5247
"""Names the random numbers of merging."""


@dataclass
class Remainder:
    """Gas in the bag that merging left in no particle; negative where the particles hold too much.

    number: of present particles, between -1/2 and 1/2 (chambers, species), sums of powers of two and therefore exact;
    momentum [N s] (3,); energy [J].
    """

    number: np.ndarray
    momentum: np.ndarray
    energy: float = 0.0

    @classmethod
    def none(cls, chambers: int, species: int) -> Remainder:
        """Nothing left over yet."""
        return cls(np.zeros((chambers, species)), np.zeros(3))

    def mass(self, kinds: ParticleKinds) -> np.ndarray:
        """[kg], (species,)."""
        return self.number.sum(axis=0) * kinds.mass


def merges_ahead(table: np.ndarray, at_start: np.ndarray, in_all: np.ndarray) -> int:
    """Number of merges until all the gas has arrived, so that the run starts with at least half of the allowed
    particles.

    table: (species, 16), species.thermo_table. at_start, in_all: masses [kg] (species,) at the start, and of all gas.
    """
    growth = float(in_all @ table[:, 0]) / max(float(at_start @ table[:, 0]), 1e-300)  # m R counts molecules
    return min(MOST_MERGES, int(math.log2(max(growth, 1.0))))


def merge(
    particles: Particles, kinds: ParticleKinds, cells: Cells, remainder: Remainder, seed: int, merges: int
) -> np.ndarray:
    """Make one particle of every two; from then on each represents twice kinds.molecules.

    cells: just sorted. merges: how many were made before; names the random numbers. Returns the energy [J] (chambers,)
    that could not be placed: a single particle of its kind has no motion relative to itself.
    """
    n, (chambers, species) = particles.count, remainder.number.shape
    kind = particles.chamber[:n].astype(np.int64) * species + particles.species[:n]
    order = cells.order[:n]
    order = order[np.argsort(kind[order], kind="stable")]
    number = np.bincount(kind, minlength=chambers * species)
    owned = 0.5 * (number + remainder.number.ravel())
    after = np.floor(owned + 0.5).astype(np.int64)
    remainder.number[...] = (owned - after).reshape(chambers, species)
    one, other, start, home = [], [], [0], []
    for k, members in enumerate(np.split(order, np.cumsum(number)[:-1])):
        stay = int(after[k])
        if len(members) % 2:
            _book(remainder, particles, kinds.mass[k % species], members[-1], len(members) - 2 * stay)
        one.append(members[0 : 2 * stay : 2])
        other.append(members[1 : 2 * stay : 2])
        if len(other[-1]) < stay:  # the odd one twice
            other.append(members[-1:])
        groups = max(1, stay // GROUP)
        start.extend(start[-1] + np.arange(1, groups + 1) * stay // groups)
        home.extend([k] * groups)
    stays = int(after.sum())
    kept, velocity, internal_energy = np.empty(stays, np.int32), np.empty((stays, 3)), np.empty(stays)
    left = np.empty(len(home))
    _merge_groups(
        len(home), np.array(start), np.concatenate(one), np.concatenate(other), particles.arrays(), seed, merges, kept,
        velocity, internal_energy, left,
    )  # fmt: skip
    particles.reorder(kept)
    particles.count = stays
    particles.velocity[:stays], particles.internal_energy[:stays] = velocity, internal_energy
    cells.partners *= 0.5  # half as many are in a cell now, so the next sort makes it larger
    home = np.array(home)
    return np.bincount(home // species, left * kinds.mass[home % species], chambers)


def _book(remainder: Remainder, particles: Particles, mass: float, who: int, sign: int) -> None:
    """Add momentum and energy of one particle of a mass [kg] to the remainder (sign 1), or subtract them (-1)."""
    velocity = particles.velocity[who]
    remainder.momentum += sign * mass * velocity
    remainder.energy += sign * float(0.5 * mass * velocity @ velocity + particles.internal_energy[who])


@kernel
def _merge_groups(n, start, one, other, particles, seed, merges, kept_out, velocity_out, energy_out, left_out):
    """Keep one[p] or other[p] of each pair p; n groups of pairs, start[g] to start[g + 1]. left_out: per mass
    [J/kg]."""
    velocity, internal_energy, identity = particles.velocity, particles.internal_energy, particles.identity
    for group in prange(n):
        begin, end = start[group], start[group + 1]
        vx, vy, vz, wx, wy, wz, store, drawn = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for p in range(begin, end):
            a, b = one[p], other[p]
            who = a if uniform(stream(seed + MERGING, merges, identity[a]), 0) < 0.5 else b
            kept_out[p] = who
            vx += 0.5 * (velocity[a, 0] + velocity[b, 0])
            vy += 0.5 * (velocity[a, 1] + velocity[b, 1])
            vz += 0.5 * (velocity[a, 2] + velocity[b, 2])
            wx += velocity[who, 0]
            wy += velocity[who, 1]
            wz += velocity[who, 2]
            store += internal_energy[a] + internal_energy[b]
            drawn += internal_energy[who]
        pairs = max(end - begin, 1)
        vx, vy, vz, wx, wy, wz = vx / pairs, vy / pairs, vz / pairs, wx / pairs, wy / pairs, wz / pairs
        flight, sample = 0.0, 0.0
        for p in range(begin, end):
            a, b, who = one[p], other[p], kept_out[p]
            flight += 0.5 * ((velocity[a, 0] - vx) ** 2 + (velocity[a, 1] - vy) ** 2 + (velocity[a, 2] - vz) ** 2)
            flight += 0.5 * ((velocity[b, 0] - vx) ** 2 + (velocity[b, 1] - vy) ** 2 + (velocity[b, 2] - vz) ** 2)
            sample += (velocity[who, 0] - wx) ** 2 + (velocity[who, 1] - wy) ** 2 + (velocity[who, 2] - wz) ** 2
        faster = math.sqrt(flight / sample) if sample > 0.0 else 0.0
        left_out[group] = flight if sample == 0.0 else 0.0
        for p in range(begin, end):
            who = kept_out[p]
            velocity_out[p, 0] = vx + faster * (velocity[who, 0] - wx)
            velocity_out[p, 1] = vy + faster * (velocity[who, 1] - wy)
            velocity_out[p, 2] = vz + faster * (velocity[who, 2] - wz)
            energy_out[p] = internal_energy[who] * store / drawn if drawn > 0.0 else store / pairs
