"""A gas of particles in a box, with the simplest flight there is: what tests of collisions need, and no more."""

from __future__ import annotations

import numpy as np

from billow.parts.gas.corpuscular.cells import Cells, sort_into_cells
from billow.parts.gas.corpuscular.collisions import collide
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, degrees_of_freedom
from billow.parts.gas.corpuscular.particles import Particles, sum_particles
from billow.parts.gas.supply.mixture import mixture_temperature
from billow.parts.gas.supply.species import Species, find_species, thermo_table

SIDE = 0.4  # m
MOLECULES = 1e18  # per particle


class Box:
    """Particles of several species in a cube (0, SIDE)^3 whose upper wall in x may move."""

    def __init__(self, species, counts, temperatures, *, stored=True, molecules=MOLECULES, seed=0):
        known = [gas if isinstance(gas, Species) else find_species(gas, "test") for gas in species]
        self.kinds = ParticleKinds(thermo_table(known), molecules)
        self.seed, self.step, self.length = seed, 0, SIDE
        n = sum(counts)
        self.particles = particles = Particles.room_for(n)
        rng = np.random.default_rng(seed)
        particles.count, particles.identity[:] = n, np.arange(n)
        particles.species[:] = rng.permutation(np.repeat(np.arange(len(counts)), counts))
        particles.position[:] = SIDE * rng.random((n, 3))
        warmth = self.kinds.heat * np.array(temperatures, dtype=float)[particles.species]
        particles.velocity[:] = rng.normal(size=(n, 3)) * np.sqrt(warmth / self.mass)[:, None]
        if stored:
            dof = np.array([degrees_of_freedom(row, t) for row, t in zip(self.kinds.table, temperatures, strict=True)])
            particles.internal_energy[:] = warmth * rng.gamma(np.maximum(0.5 * dof, 1e-300)[particles.species])
        self.cells = Cells.of(1)

    @property
    def mass(self):
        """Of each particle [kg]."""
        return self.kinds.mass[self.particles.species]

    def sums(self):
        return sum_particles(self.particles, self.kinds.mass, 1)

    def fly(self, dt, piston=0.0):
        """Specular walls; the upper wall in x moves at -piston [m/s]."""
        particles = self.particles
        self.length -= piston * dt
        particles.position += particles.velocity * dt
        for axis in range(3):
            x, v = particles.position[:, axis], particles.velocity[:, axis]
            low = x < 0.0
            x[low], v[low] = -x[low], -v[low]
            wall, speed = (self.length, piston) if axis == 0 else (SIDE, 0.0)
            high = x > wall  # mirrored in the frame of the wall
            x[high], v[high] = 2.0 * wall - x[high], -2.0 * speed - v[high]

    def collide(self, dt):
        sort_into_cells(self.cells, self.particles, self.seed, self.step)
        collided = collide(self.cells, self.particles, self.kinds, dt, self.seed, self.step)
        self.step += 1
        return collided

    def temperature(self):
        """Of the gas as a whole, from all its energy [K]."""
        sums = self.sums()
        masses = sums.particles.sum(axis=0) * self.kinds.mass
        return mixture_temperature(self.kinds.table, masses, sums.energy, 300.0)

    def flight_temperatures(self):
        """Of each species' flight alone [K]."""
        energy = self.mass * np.sum(self.particles.velocity**2, axis=1) / 3.0
        return np.array([energy[self.particles.species == k].mean() for k in range(len(self.kinds.mass))]) / (
            self.kinds.heat
        )
