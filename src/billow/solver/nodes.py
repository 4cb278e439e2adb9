"""Loops over the n nodes: gathering corner forces and the kick that ends a step; kinetic energy. mass [kg],
inverse_mass [1/kg]: (n,); velocities [m/s], positions [m], forces [N]: (n, 3)."""

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
def gather_and_kick(
    n, assembly, loads, gauge, node_force, corners, corner_force, mass, inverse_mass, gravity, drag, touching,
    contact_force, half_dt, velocities, force_out,
):  # fmt: skip
    """force_out = loads + node_force + corner_force + mass (gravity - drag v); then the half kick that ends a step, by
    this and by the second half of the contact impulses. Returns twice the kinetic energy after it [J]. node_force is
    zero again afterwards.

    assembly: start, entry, sides and pair of an `Assembly`; loads to corner_force: of `Loads`. corners: corner_start
    and corners of a `Surface`. drag: 2 alpha [1/s]. touching: (obstacles, n) bool; contact_force: [N], (obstacles, n,
    3).
    """
    start, entries, sides, pair = assembly
    corner_start, corner = corners
    on_corners = len(corner_force) > 0
    partial, pressure = np.empty((n + CHUNK - 1) // CHUNK), np.empty(len(sides))
    for k in range(len(sides)):
        pressure[k] = gauge[sides[k, 0]] - gauge[sides[k, 1]]  # OUTSIDE, -1, is the last
    for chunk in prange(len(partial)):
        total = 0.0
        for item in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            i = np.uint64(item)
            m = mass[i]
            vx, vy, vz = velocities[i, 0], velocities[i, 1], velocities[i, 2]
            fx, fy, fz = m * gravity[0], m * gravity[1], m * gravity[2]
            if drag > 0.0:
                fx, fy, fz = fx - drag * m * vx, fy - drag * m * vy, fz - drag * m * vz
            fx, fy, fz = fx + node_force[i, 0], fy + node_force[i, 1], fz + node_force[i, 2]
            node_force[i, 0], node_force[i, 1], node_force[i, 2] = 0.0, 0.0, 0.0
            for k in range(start[i], start[i + np.uint64(1)]):
                e = np.uint64(entries[k])
                p = pressure[np.uint64(pair[e])]
                fx += loads[e, 0] + p * loads[e, 3]
                fy += loads[e, 1] + p * loads[e, 4]
                fz += loads[e, 2] + p * loads[e, 5]
            if on_corners:
                for k in range(corner_start[i], corner_start[i + np.uint64(1)]):
                    c = np.uint64(corner[k])
                    fx += corner_force[c, 0]
                    fy += corner_force[c, 1]
                    fz += corner_force[c, 2]
            force_out[i, 0], force_out[i, 1], force_out[i, 2] = fx, fy, fz
            for o in range(len(touching)):
                if touching[o, i]:
                    fx += contact_force[o, i, 0]
                    fy += contact_force[o, i, 1]
                    fz += contact_force[o, i, 2]
            s = half_dt * inverse_mass[i]
            vx, vy, vz = vx + s * fx, vy + s * fy, vz + s * fz
            velocities[i, 0], velocities[i, 1], velocities[i, 2] = vx, vy, vz
            total += m * (vx * vx + vy * vy + vz * vz)
        partial[chunk] = total
    return in_order(partial)


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
