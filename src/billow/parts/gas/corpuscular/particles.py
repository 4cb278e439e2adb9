"""The particles: what is known of each, and what they sum to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel


class ParticleArrays(NamedTuple):
    """Views of some particles, as kernels take them; fields as in `Particles`."""

    position: np.ndarray
    velocity: np.ndarray
    internal_energy: np.ndarray
    species: np.ndarray
    chamber: np.ndarray
    identity: np.ndarray
    overlap: np.ndarray
    group_overlap: np.ndarray


@dataclass
class Particles:
    """Arrays with room for `capacity` particles, of which the first `count` exist.

    position [m] (capacity, 3); velocity [m/s] (capacity, 3); internal_energy [J] (capacity,); species (capacity,)
    int32; chamber (capacity,) int32; identity (capacity,) int64, never used twice: it names a particle's random
    numbers; overlap (capacity,) int32: how many times more than once its chamber's surface winds around the particle
    (flight.py), 0 for new particles; group_overlap (capacity,) int32: the same of the surface around all chambers that
    openings join to it. 80 bytes a particle, and as many to reorder them.
    """

    count: int
    position: np.ndarray
    velocity: np.ndarray
    internal_energy: np.ndarray
    species: np.ndarray
    chamber: np.ndarray
    identity: np.ndarray
    overlap: np.ndarray
    group_overlap: np.ndarray
    next_identity: int = 0

    spare = None
    """Arrays of the same size to reorder into, kept because new memory costs as much as the work."""

    @classmethod
    def room_for(cls, capacity: int) -> Particles:
        """No particles yet."""
        return cls(
            0, np.zeros((capacity, 3)), np.zeros((capacity, 3)), np.zeros(capacity), np.zeros(capacity, np.int32),
            np.zeros(capacity, np.int32), np.zeros(capacity, np.int64), np.zeros(capacity, np.int32),
            np.zeros(capacity, np.int32),
        )  # fmt: skip

    @property
    def capacity(self) -> int:
        return len(self.species)

    def arrays(self, first: int = 0) -> ParticleArrays:
        """Views of the particles from `first` on."""
        return ParticleArrays(*(getattr(self, name)[first : self.count] for name in ParticleArrays._fields))

    def make_room(self, more: int) -> None:
        """Room for so many more particles; the arrays move when they have to grow."""
        needed = self.count + more
        if needed > self.capacity:
            grown = Particles.room_for(max(needed, self.capacity + self.capacity // 4))
            for name in ParticleArrays._fields:
                getattr(grown, name)[: self.count] = getattr(self, name)[: self.count]
                setattr(self, name, getattr(grown, name))
        self.overlap[self.count : needed] = 0
        self.group_overlap[self.count : needed] = 0

    def add(self, number: int) -> ParticleArrays:
        """New particles with new identities; returns their arrays, which the caller fills in."""
        self.make_room(number)
        first, self.count = self.count, self.count + number
        self.identity[first : self.count] = self.next_identity + np.arange(number)
        self.next_identity += number
        return self.arrays(first)

    def keep(self, wanted: np.ndarray) -> None:
        """Drop all others; the order of those that stay is kept. wanted: (count,) bool."""
        stay = np.flatnonzero(wanted).astype(np.int32)
        self.reorder(stay)
        self.count = len(stay)

    def reorder(self, order: np.ndarray) -> None:
        """Put particle order[i] at place i, for as many as there are in `order`; what follows is not defined."""
        names = ParticleArrays._fields
        if self.spare is None or len(self.spare.species) != self.capacity:
            self.spare = ParticleArrays(*(np.zeros_like(getattr(self, name)) for name in names))
        before = ParticleArrays(*(getattr(self, name) for name in names))
        _reorder(len(order), order, before, self.spare)
        for name in names:
            setattr(self, name, getattr(self.spare, name))
        self.spare = before


@dataclass(frozen=True)
class ParticleSums:
    """By chamber: particles (chambers, species) int64; momentum [N s] (chambers, 3); flight_energy, the kinetic energy
    including the mean motion, and internal_energy [J], (chambers,)."""

    particles: np.ndarray
    momentum: np.ndarray
    flight_energy: np.ndarray
    internal_energy: np.ndarray

    @property
    def energy(self) -> float:
        """Total energy [J]."""
        return float(self.flight_energy.sum() + self.internal_energy.sum())


def sum_particles(particles: Particles, mass: np.ndarray, chambers: int) -> ParticleSums:
    """Sums over all particles, the same bits for any number of threads; mass of a particle [kg] (species,)."""
    chunks = -(-particles.count // CHUNK)
    number = np.zeros((chunks, chambers, len(mass)), np.int64)
    amounts = np.zeros((chunks, chambers, 5))
    _sum(particles.count, particles.arrays(), mass, number, amounts)
    total = amounts.sum(axis=0)
    return ParticleSums(number.sum(axis=0), total[:, :3].copy(), total[:, 3].copy(), total[:, 4].copy())


@kernel
def _sum(n, particles, mass, number_out, amounts_out):
    velocity, species = particles.velocity, particles.species
    internal_energy, chamber = particles.internal_energy, particles.chamber
    chunks = (n + CHUNK - 1) // CHUNK
    for chunk in prange(chunks):
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            m, where = mass[species[i]], chamber[i]
            vx, vy, vz = velocity[i, 0], velocity[i, 1], velocity[i, 2]
            number_out[chunk, where, species[i]] += 1
            amounts_out[chunk, where, 0] += m * vx
            amounts_out[chunk, where, 1] += m * vy
            amounts_out[chunk, where, 2] += m * vz
            amounts_out[chunk, where, 3] += 0.5 * m * (vx * vx + vy * vy + vz * vz)
            amounts_out[chunk, where, 4] += internal_energy[i]


@kernel
def _reorder(n, order, particles, particles_out):
    position, velocity = particles.position, particles.velocity
    internal_energy, species = particles.internal_energy, particles.species
    chamber, identity = particles.chamber, particles.identity
    overlap, group_overlap = particles.overlap, particles.group_overlap
    position_out, velocity_out = particles_out.position, particles_out.velocity
    internal_energy_out, species_out = particles_out.internal_energy, particles_out.species
    chamber_out, identity_out = particles_out.chamber, particles_out.identity
    overlap_out, group_overlap_out = particles_out.overlap, particles_out.group_overlap
    for i in prange(n):
        p = order[i]
        for axis in range(3):
            position_out[i, axis], velocity_out[i, axis] = position[p, axis], velocity[p, axis]
        internal_energy_out[i], species_out[i] = internal_energy[p], species[p]
        chamber_out[i], identity_out[i] = chamber[p], identity[p]
        overlap_out[i], group_overlap_out[i] = overlap[p], group_overlap[p]
