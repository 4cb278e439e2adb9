"""The initial gas in the start shape: even by volume, Maxwell velocities, no net momentum, exact energy."""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.corpuscular.inside_points import Enclosure, points_inside
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, degrees_of_freedom
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.random_numbers import gamma, normal, stream

INITIAL_AIR = 0x41495220
"""Names the random numbers of the air's motion."""


def fill_with_air(
    particles: Particles, kinds: ParticleKinds, mass_fractions: np.ndarray, pressure: float, temperature: float,
    volumes: np.ndarray, bag: Enclosure, seed: int,
) -> None:  # fmt: skip
    """Add the air of each chamber at rest: mass_fractions (species,), pressure [Pa], temperature [K].

    volumes [m^3] (chambers,). The air of a chamber has no momentum, and exactly the
    energy of its particles at that temperature; its mass is right to half a particle.
    """
    number = np.rint(pressure * volumes / (kinds.heat * temperature)).astype(np.int64)
    points, chamber, _ = points_inside(bag, number, seed)
    new = particles.add(len(points))
    new.position[:], new.chamber[:] = points, chamber
    share = mass_fractions / kinds.mass
    _stir(new, kinds.table, kinds.mass, kinds.heat, share / share.sum(), temperature, seed)


@scalar
def _stir(new, table, mass, heat, mole_fractions, temperature, seed):
    """Species, velocities and internal energies of new particles that are listed chamber by chamber."""
    species, velocity, energy, chamber = new.species, new.velocity, new.internal_energy, new.chamber
    begin, total = 0, len(chamber)
    while begin < total:
        end = begin
        while end < total and chamber[end] == chamber[begin]:
            end += 1
        given = np.zeros(len(mass))
        momentum = np.zeros(3)
        weight, flight, stored, owed = 0.0, 0.0, 0.0, 0.0
        for i in range(begin, end):
            kind = 0
            for k in range(len(mass)):  # the most overdue species
                due = (i + 1 - begin) * mole_fractions[k] - given[k]
                if due > (i + 1 - begin) * mole_fractions[kind] - given[kind]:
                    kind = k
            given[kind] += 1.0
            species[i] = kind
            key = stream(seed + INITIAL_AIR, 0, new.identity[i])
            dof = degrees_of_freedom(table[kind], temperature)
            energy[i] = gamma(key, 3, 0.5 * dof)
            stored += energy[i]
            owed += 0.5 * dof
            weight += mass[kind]
            for axis in range(3):
                velocity[i, axis] = math.sqrt(heat * temperature / mass[kind]) * normal(key, axis)
                momentum[axis] += mass[kind] * velocity[i, axis]
        for i in range(begin, end):
            for axis in range(3):
                velocity[i, axis] -= momentum[axis] / weight
                flight += 0.5 * mass[species[i]] * velocity[i, axis] ** 2
        # A single particle cannot fly without momentum: its energy of flight goes into its internal energy.
        faster = math.sqrt(1.5 * (end - begin) * heat * temperature / flight) if flight > 0.0 else 0.0
        if flight == 0.0:
            owed += 1.5 * (end - begin)
        for i in range(begin, end):
            velocity[i] *= faster
            energy[i] *= owed * heat * temperature / stored if stored > 0.0 else 0.0
        begin = end
