"""Collisions bring a gas of particles into local equilibrium (docs/theory.md, Collisions)."""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.parts.gas.corpuscular.cells import Cells
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, cell_degrees_of_freedom, cell_temperature
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.random_numbers import next_gamma, next_uniform, stream
from billow.parts.gas.supply.mixture import mixture_gas_constant

FREE_PATH = 0.75
"""Mean free path in cell edges."""

MOST_COLLISIONS = 2
"""Of a particle in one call, at most, on average: for those that fly further than a free path between two calls."""

EXCHANGE = 0.5
"""Share of collisions that exchange internal energy."""

CELLS_PER_CHUNK = 128
"""Cells one thread works on at a time."""

COLLISIONS = 0x434F4C4C
"""Names the random numbers of collisions."""


def collide(cells: Cells, particles: Particles, kinds: ParticleKinds, dt: float, seed: int, step: int) -> int:
    """Collisions within each cell for the dt [s] since the last call; returns their number.

    Changes velocity and internal_energy, and the order within cells. `step` names the random numbers: each call of a
    run must use another one.
    """
    collided = np.zeros(-(-cells.count // CELLS_PER_CHUNK), np.int64)
    _collide(
        particles.count, cells.count, cells.first, cells.start, cells.order, cells.size, particles.arrays(),
        kinds.table, kinds.mass, kinds.heat, dt, seed, step, collided,
    )  # fmt: skip
    return int(collided.sum())


@kernel
def _collide(n, cells, first, start, order, size, particles, table, mass, heat, dt, seed, step, collided_out):
    """n: particles, which decide whether it runs in parallel; cells: number of cells."""
    velocity, internal_energy, species = particles.velocity, particles.internal_energy, particles.species
    chunks = (cells + CELLS_PER_CHUNK - 1) // CELLS_PER_CHUNK
    for chunk in prange(chunks):
        masses, dof = np.empty(len(mass)), np.empty(len(mass))
        temperature, chamber = 300.0, 0
        for cell in range(chunk * CELLS_PER_CHUNK, min(cells, (chunk + 1) * CELLS_PER_CHUNK)):
            begin, end = np.int64(start[cell]), np.int64(start[cell + 1])
            if end - begin < 2:
                continue
            while cell >= first[chamber + 1]:
                chamber += 1
            thermal = cell_content(order, begin, end, velocity, internal_energy, species, mass, masses)
            found = cell_temperature(table, masses, heat, thermal, temperature)
            if not found > 0.0:  # equal velocities and no internal energy
                continue
            temperature = found  # a good guess for the next cell
            constant = mixture_gas_constant(table, masses) / masses.sum()
            speed = math.sqrt(8.0 / math.pi * constant * temperature)
            each = min(float(MOST_COLLISIONS), dt * speed / (FREE_PATH * size[chamber]))
            u, state = next_uniform(stream(seed + COLLISIONS, step, cell))
            half = (end - begin) // 2
            pairs = min(int(0.5 * (end - begin) * each + u), MOST_COLLISIONS * half)
            if pairs == 0:
                continue
            cell_degrees_of_freedom(table, masses, heat, thermal, temperature, dof)
            for pair in range(pairs):
                at = begin + 2 * (pair % half)  # once all have met, they are drawn anew
                u, state = next_uniform(state)
                i = _draw(order, at, end, u)
                u, state = next_uniform(state)
                j = _draw(order, at + 1, end, u)
                state = _scatter(velocity, internal_energy, species, mass, dof, i, j, state)
            collided_out[chunk] += pairs


@scalar
def cell_content(order, begin, end, velocity, internal_energy, species, mass, masses_out):
    """Thermal energy [J] of particles order[begin:end], and their masses [kg] by species."""
    total, px, py, pz, flight, stored = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    masses_out[:] = 0.0
    for at in range(begin, end):
        i = order[at]
        m = mass[species[i]]
        vx, vy, vz = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        masses_out[species[i]] += m
        total += m
        px += m * vx
        py += m * vy
        pz += m * vz
        flight += 0.5 * m * (vx * vx + vy * vy + vz * vz)
        stored += internal_energy[i]
    flight -= 0.5 * (px * px + py * py + pz * pz) / total
    return flight + stored


@scalar
def _draw(order, at, end, u):
    """Swap a random one of order[at:end] to the front, and return it."""
    chosen = min(at + int(u * (end - at)), end - 1)
    i = order[chosen]
    order[chosen] = order[at]
    order[at] = i
    return i


@scalar
def _scatter(velocity, internal_energy, species, mass, dof, i, j, state):
    """Collide particles i and j; returns the next state of the random numbers."""
    m1, m2 = mass[species[i]], mass[species[j]]
    share = m1 / (m1 + m2)
    gx, gy, gz = (
        velocity[i, 0] - velocity[j, 0], velocity[i, 1] - velocity[j, 1], velocity[i, 2] - velocity[j, 2],
    )  # fmt: skip
    cx, cy, cz = velocity[j, 0] + share * gx, velocity[j, 1] + share * gy, velocity[j, 2] + share * gz
    square = gx * gx + gy * gy + gz * gz
    dof1, dof2 = dof[species[i]], dof[species[j]]
    u, state = next_uniform(state)
    if dof1 + dof2 > 0.0 and u < EXCHANGE:
        half_mass = 0.5 * share * m2
        total = half_mass * square + internal_energy[i] + internal_energy[j]
        flight, state = next_gamma(state, 1.5)
        one, state = next_gamma(state, 0.5 * dof1)
        two, state = next_gamma(state, 0.5 * dof2)
        total /= flight + one + two
        internal_energy[i], internal_energy[j] = total * one, total * two
        square = total * flight / half_mass
    # A point even on the sphere from one even in the disc: Marsaglia, Ann. Math. Stat. 43 (1972).
    disc = 1.0
    while disc >= 1.0:
        a, state = next_uniform(state)
        b, state = next_uniform(state)
        a, b = 2.0 * a - 1.0, 2.0 * b - 1.0
        disc = a * a + b * b
    speed = math.sqrt(square)
    across = 2.0 * speed * math.sqrt(1.0 - disc)
    gx, gy, gz = across * a, across * b, speed * (1.0 - 2.0 * disc)
    velocity[i, 0], velocity[i, 1], velocity[i, 2] = (
        cx + (1.0 - share) * gx, cy + (1.0 - share) * gy, cz + (1.0 - share) * gz,
    )  # fmt: skip
    velocity[j, 0], velocity[j, 1], velocity[j, 2] = cx - share * gx, cy - share * gy, cz - share * gz
    return state


def collision_time(cells: Cells, kinds: ParticleKinds, mass_fractions: np.ndarray, temperature: float) -> float:
    """Shortest time [s] in which particles of any chamber fly their mean free path, at a mean temperature [K].

    Calls of `collide` further apart than MOST_COLLISIONS times this leave collisions out. mass_fractions: (species,).
    Infinite before the first sort.
    """
    constant = mixture_gas_constant(kinds.table, mass_fractions)
    size = cells.size[cells.size > 0.0].min(initial=np.inf)
    return FREE_PATH * size / math.sqrt(8.0 / math.pi * constant * temperature)
