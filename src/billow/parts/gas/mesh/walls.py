"""Pressure of the gas on fragments of fabric, and the load on the fabric that follows."""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import inlined, kernel
from billow.geometry.lattice_clipping import NORMAL, PLACE, WEIGHT
from billow.parts.gas.mesh.riemann import wall_pressure
from billow.parts.gas.mesh.thermodynamics import RHO, C, P, U

LEAST, MOST = 0.5, 2.0
"""Bounds of the pressure that slopes extrapolate to a wall, relative to that of the cluster."""


@inlined
def fragment_velocity(rows, f, triangles, t, velocity):
    """Velocity [m/s] of the centroid of fragment f, of triangle t; velocity: of the nodes, (nodes, 3)."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    p, q, r = rows[f, WEIGHT], rows[f, WEIGHT + 1], rows[f, WEIGHT + 2]
    return (
        p * velocity[a, 0] + q * velocity[b, 0] + r * velocity[c, 0],
        p * velocity[a, 1] + q * velocity[b, 1] + r * velocity[c, 1],
        p * velocity[a, 2] + q * velocity[b, 2] + r * velocity[c, 2],
    )


@inlined
def pressure_on(state, centre, slope, place, c, rows, f, ux, uy, uz, through):
    """Pressure [Pa] of the gas of cluster c on fragment f that moves with (ux, uy, uz) and that it passes at the speed
    `through` [m/s].

    centre: (clusters, 5), the state rho, u, v, w, p that the slopes, (clusters, 3, 5) per cell, belong to. place: of
    the clusters' centroids, (clusters, 3), in lattice coordinates.
    """
    nx, ny, nz = rows[f, NORMAL], rows[f, NORMAL + 1], rows[f, NORMAL + 2]
    area = np.sqrt(nx * nx + ny * ny + nz * nz)
    dx, dy, dz = rows[f, PLACE] - place[c, 0], rows[f, PLACE + 1] - place[c, 1], rows[f, PLACE + 2] - place[c, 2]
    du = (centre[c, U] + slope[c, 0, U] * dx - ux) * nx
    du += (centre[c, U + 1] + slope[c, 1, U + 1] * dy - uy) * ny
    du += (centre[c, U + 2] + slope[c, 2, U + 2] * dz - uz) * nz
    p = centre[c, P]
    p = min(max(p + slope[c, 0, P] * dx + slope[c, 1, P] * dy + slope[c, 2, P] * dz, LEAST * p), MOST * p)
    speed_of_sound = state[c, C] * np.sqrt(centre[c, P] / state[c, P] * state[c, RHO] / centre[c, RHO])
    du /= area
    return wall_pressure(centre[c, RHO], p, speed_of_sound, du - min(max(du, 0.0), through))


@kernel
def press(n, first, cell, rows, of, triangles, velocity, is_link, through, state, slope, place, area, force_out):
    """Forces [N] of the gas on the corners of n triangles, (n, 3, 3), absolute. through: speed [m/s] at which gas
    leaves through each fragment. area: of a cell's face [m^2].

    The slopes are those of the last step, about the new state.
    """
    for t in prange(n):
        for k in range(3):
            for d in range(3):
                force_out[t, k, d] = 0.0
        if is_link[t]:
            continue
        for f in range(first[t], first[t + 1]):
            c = of[cell[f]]
            if not state[c, P] > 0.0:
                continue
            ux, uy, uz = fragment_velocity(rows, f, triangles, t, velocity)
            push = area * pressure_on(state, state, slope, place, c, rows, f, ux, uy, uz, through[f])
            for k in range(3):
                for d in range(3):
                    force_out[t, k, d] += push * rows[f, NORMAL + d] * rows[f, WEIGHT + k]
