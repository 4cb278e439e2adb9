"""Ambient air that comes in through a passage where the pressure outside is higher."""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, degrees_of_freedom
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.random_numbers import gamma, normal, stream, uniform

DRAWN_IN = 0x4452_4157
"""Names the random numbers of air drawn in."""

INSET = 1e-6
"""Height [m] of newborns over the triangle they come through."""


def draw_in(
    particles: Particles, kinds: ParticleKinds, number: np.ndarray, temperature: float, chamber: int,
    triangles: np.ndarray, positions: np.ndarray, inward: float, seed: int,
) -> tuple[float, np.ndarray]:  # fmt: skip
    """Add particles, number (species,) int64, of air at temperature [K] through triangles (n, 3).

    positions [m] (nodes, 3). inward: -1 if the chamber lies behind the triangles, +1 if ahead. They have the velocities
    of molecules that cross a plane. Returns their energy [J] and momentum [N s] (3,).
    """
    count = int(number.sum())
    particles.make_room(count)
    first, last = particles.count, particles.count + count
    particles.species[first:last] = np.repeat(np.arange(len(number)), number)
    particles.chamber[first:last] = chamber
    particles.identity[first:last] = particles.next_identity + np.arange(count)
    corners = positions[triangles]
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    _place(
        corners, np.cumsum(area) / area.sum(), inward * normals / area[:, None], kinds.table, kinds.mass, kinds.heat,
        temperature, particles.identity[first:last], particles.species[first:last], seed,
        particles.position[first:last], particles.velocity[first:last], particles.internal_energy[first:last],
    )  # fmt: skip
    particles.count, particles.next_identity = last, particles.next_identity + count
    each, velocity = kinds.mass[particles.species[first:last]], particles.velocity[first:last]
    energy = 0.5 * each @ np.sum(velocity**2, axis=1) + particles.internal_energy[first:last].sum()
    return float(energy), each @ velocity


@scalar
def _place(
    corners, share, normals, table, mass, heat, temperature, identity, species, seed, position_out, velocity_out,
    energy_out,
):  # fmt: skip
    for p in range(len(identity)):
        key = stream(seed + DRAWN_IN, 0, identity[p])
        t = min(np.searchsorted(share, uniform(key, 0)), len(share) - 1)
        u, v = uniform(key, 1), uniform(key, 2)
        if u + v > 1.0:
            u, v = 1.0 - u, 1.0 - v
        sigma = math.sqrt(heat * temperature / mass[species[p]])
        across = sigma * math.sqrt(-2.0 * math.log(uniform(key, 3)))  # speeds of molecules that cross a plane
        n = normals[t]
        sway = np.array([sigma * normal(key, 4), sigma * normal(key, 5), sigma * normal(key, 6)])
        along = sway[0] * n[0] + sway[1] * n[1] + sway[2] * n[2]
        for k in range(3):
            side = u * (corners[t, 1, k] - corners[t, 0, k]) + v * (corners[t, 2, k] - corners[t, 0, k])
            position_out[p, k] = corners[t, 0, k] + side + INSET * n[k]
            velocity_out[p, k] = sway[k] + (across - along) * n[k]
        dof = degrees_of_freedom(table[species[p]], temperature)
        energy_out[p] = heat * temperature * gamma(key, 7, 0.5 * dof)
