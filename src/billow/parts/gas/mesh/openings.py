"""Openings between chambers: gas flows freely through virtual triangles, which may move."""

from __future__ import annotations

import numpy as np

from billow.base.compiled import inlined, scalar
from billow.geometry.lattice_clipping import NORMAL, WEIGHT
from billow.parts.gas.mesh.riemann import hllc
from billow.parts.gas.mesh.thermodynamics import RHO, C, G, P, U, Y


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


@scalar
def link(
    state_a, state_b, gained_a, gained_b, cluster_a, cluster_b, rows, fragments, triangle, triangles, velocity, area,
    dt, species,
):  # fmt: skip
    """Exchange between two chambers through fragments whose normals point out of chamber a; returns the mass [kg] that
    went from a to b, and back.

    The flux is that between gases at rest relative to the fragment, turned back to the frame of the lattice. The push
    of walls at the pressure of the cluster, which closes every cell, is taken out again.
    """
    forth, back = 0.0, 0.0
    for m in range(len(fragments)):
        f, a, b = fragments[m], cluster_a[m], cluster_b[m]
        if not (state_a[a, P] > 0.0 and state_b[b, P] > 0.0):
            continue
        v = fragment_velocity(rows, f, triangles, triangle[f], velocity)
        size = np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)
        normal = (rows[f, NORMAL] / size, rows[f, NORMAL + 1] / size, rows[f, NORMAL + 2] / size)
        along_a, along_b, all_a, all_b = 0.0, 0.0, 0.0, 0.0
        for d in range(3):
            ua, ub = state_a[a, U + d] - v[d], state_b[b, U + d] - v[d]
            along_a, along_b = along_a + ua * normal[d], along_b + ub * normal[d]
            all_a, all_b = all_a + ua * ua, all_b + ub * ub
        across_a = np.sqrt(max(all_a - along_a * along_a, 0.0))
        across_b = np.sqrt(max(all_b - along_b * along_b, 0.0))
        mass, push, _, _, energy = hllc(
            state_a[a, RHO], along_a, across_a, 0.0, state_a[a, P], 1.0 / (state_a[a, G] - 1.0), state_a[a, C],
            state_b[b, RHO], along_b, across_b, 0.0, state_b[b, P], 1.0 / (state_b[b, G] - 1.0), state_b[b, C],
        )  # fmt: skip
        up, c, along = (state_a, a, along_a) if mass > 0.0 else (state_b, b, along_b)
        k, speed = size * area * dt, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
        energy += 0.5 * mass * speed
        for d in range(3):
            across = up[c, U + d] - v[d] - along * normal[d]
            momentum = push * normal[d] + mass * across
            energy += momentum * v[d]
            momentum += mass * v[d]
            gained_a[a, species + d] -= k * momentum - area * dt * state_a[a, P] * rows[f, NORMAL + d]
            gained_b[b, species + d] += k * momentum - area * dt * state_b[b, P] * rows[f, NORMAL + d]
        for s in range(species):
            gained_a[a, s] -= k * mass * up[c, Y + s]
            gained_b[b, s] += k * mass * up[c, Y + s]
        gained_a[a, species + 3] -= k * energy
        gained_b[b, species + 3] += k * energy
        forth, back = forth + max(k * mass, 0.0), back + max(-k * mass, 0.0)
    return forth, back
