"""Loops over the n nodes: gathering corner forces, moving, kinetic energy. mass [kg], inverse_mass [1/kg]: (n,);
velocities [m/s], positions [m], forces [N]: (n, 3)."""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar


@scalar
def in_order(partial):
    """Sum of what the chunks gave, always in the same order."""
    total = 0.0
    for chunk in range(len(partial)):
        total += partial[chunk]
    return total


@kernel
def gather(n, corner_start, corners, corner_force, mass, gravity, drag, velocities, force_out):
    """force_out = corner forces [N] (corners, 3) + mass (gravity - drag v); drag: 2 alpha [1/s]."""
    for i in prange(n):
        fx, fy, fz = mass[i] * gravity[0], mass[i] * gravity[1], mass[i] * gravity[2]
        if drag > 0.0:
            fx -= drag * mass[i] * velocities[i, 0]
            fy -= drag * mass[i] * velocities[i, 1]
            fz -= drag * mass[i] * velocities[i, 2]
        for k in range(corner_start[i], corner_start[i + 1]):
            c = corners[k]
            fx += corner_force[c, 0]
            fy += corner_force[c, 1]
            fz += corner_force[c, 2]
        force_out[i, 0], force_out[i, 1], force_out[i, 2] = fx, fy, fz


@kernel
def half_kick(n, inverse_mass, force, half_dt, velocities):
    """velocities += half_dt force / mass."""
    for i in prange(n):
        s = half_dt * inverse_mass[i]
        velocities[i, 0] += s * force[i, 0]
        velocities[i, 1] += s * force[i, 1]
        velocities[i, 2] += s * force[i, 2]


@kernel
def last_kick(n, mass, inverse_mass, force, touching, contact_force, half_dt, velocities):
    """The half kick that ends a step: `force`, and the second half of the contact impulses.

    touching: (obstacles, n) bool; contact_force: [N], (obstacles, n, 3). Returns twice the kinetic energy after it [J].
    """
    partial = np.empty((n + CHUNK - 1) // CHUNK)
    for chunk in prange(len(partial)):
        total = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            fx, fy, fz = force[i, 0], force[i, 1], force[i, 2]
            for o in range(len(touching)):
                if touching[o, i]:
                    fx += contact_force[o, i, 0]
                    fy += contact_force[o, i, 1]
                    fz += contact_force[o, i, 2]
            s = half_dt * inverse_mass[i]
            vx, vy, vz = velocities[i, 0] + s * fx, velocities[i, 1] + s * fy, velocities[i, 2] + s * fz
            velocities[i, 0], velocities[i, 1], velocities[i, 2] = vx, vy, vz
            total += mass[i] * (vx * vx + vy * vy + vz * vz)
        partial[chunk] = total
    return in_order(partial)


@kernel
def drift(n, dt, velocities, positions, before_out):
    """positions += dt velocities; before_out: receives the old ones."""
    for i in prange(n):
        for k in range(3):
            before_out[i, k] = positions[i, k]
            positions[i, k] += dt * velocities[i, k]


@kernel
def twice_kinetic(n, mass, velocities):
    """Twice the kinetic energy [J]."""
    partial = np.empty((n + CHUNK - 1) // CHUNK)
    for chunk in prange(len(partial)):
        total = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            vx, vy, vz = velocities[i, 0], velocities[i, 1], velocities[i, 2]
            total += mass[i] * (vx * vx + vy * vy + vz * vz)
        partial[chunk] = total
    return in_order(partial)
