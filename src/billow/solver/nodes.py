"""Loops over nodes: gathering corner forces, moving, kinetic energy."""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar


def gather(corner_start, corners, corner_force, mass, gravity, drag, velocities, nodal_force) -> None:
    """nodal_force [N] (nodes, 3) = corner forces + mass (gravity - drag v); drag: 2 alpha [1/s]."""
    _gather(len(mass), corner_start, corners, corner_force.reshape(-1, 3), mass, gravity, drag, velocities, nodal_force)


def half_kick(inverse_mass, nodal_force, dt, velocities) -> None:
    """velocities [m/s] (nodes, 3) += dt/2 force / mass."""
    _half_kick(len(inverse_mass), inverse_mass, nodal_force, 0.5 * dt, velocities)


def last_kick(mass, inverse_mass, nodal_force, touching, contact_force, dt, velocities) -> float:
    """The half kick that ends a step: `nodal_force` and the second half of the contact impulses.

    touching: (obstacles, nodes) bool; contact_force: [N], (obstacles, nodes, 3). Returns the kinetic energy after it
    [J].
    """
    return 0.5 * _last_kick(
        len(mass), mass, inverse_mass, nodal_force, touching, contact_force, 0.5 * dt, velocities
    )  # fmt: skip


def drift(dt, velocities, positions, before) -> None:
    """positions [m] (nodes, 3) += dt velocities; before: receives the old ones."""
    _drift(len(positions), dt, velocities, positions, before)


def kinetic_energy(mass, velocities) -> float:
    """Kinetic energy [J] of nodes with mass [kg] (nodes,) and velocities [m/s] (nodes, 3)."""
    return 0.5 * _twice_kinetic(len(mass), mass, velocities)


@scalar
def in_order(partial):
    """Sum of what the chunks gave, always in the same order."""
    total = 0.0
    for chunk in range(len(partial)):
        total += partial[chunk]
    return total


@kernel
def _gather(n, corner_start, corners, corner_force, mass, gravity, drag, velocities, force_out):
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
def _half_kick(n, inverse_mass, force, half_dt, velocities):
    for i in prange(n):
        s = half_dt * inverse_mass[i]
        velocities[i, 0] += s * force[i, 0]
        velocities[i, 1] += s * force[i, 1]
        velocities[i, 2] += s * force[i, 2]


@kernel
def _last_kick(n, mass, inverse_mass, force, touching, contact_force, half_dt, velocities):
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
def _drift(n, dt, velocities, positions, before_out):
    for i in prange(n):
        for k in range(3):
            before_out[i, k] = positions[i, k]
            positions[i, k] += dt * velocities[i, k]


@kernel
def _twice_kinetic(n, mass, velocities):
    partial = np.empty((n + CHUNK - 1) // CHUNK)
    for chunk in prange(len(partial)):
        total = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            vx, vy, vz = velocities[i, 0], velocities[i, 1], velocities[i, 2]
            total += mass[i] * (vx * vx + vy * vy + vz * vz)
        partial[chunk] = total
    return in_order(partial)
