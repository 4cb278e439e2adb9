"""Openings between chambers: gas flows freely through virtual triangles, which may move."""

from __future__ import annotations

import numpy as np

from billow.base.compiled import scalar, spliced
from billow.geometry.lattice_clipping import NORMAL, WEIGHT
from billow.parts.gas.mesh.riemann import hllc
from billow.parts.gas.mesh.thermodynamics import RHO, C, G, P, U, Y

LARGEST_SHARE = 0.25
"""Of a cluster's mass and internal energy that may leave through an opening in a part of a step."""


@spliced
def fragment_velocity(rows, f, triangles, t, velocity):
    """Velocity [m/s] of the centroid of fragment f, of triangle t; velocity: of the nodes, (nodes, 3)."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    q, r = rows[f, WEIGHT], rows[f, WEIGHT + 1]
    p = 1.0 - q - r
    return (
        p * velocity[a, 0] + q * velocity[b, 0] + r * velocity[c, 0],
        p * velocity[a, 1] + q * velocity[b, 1] + r * velocity[c, 1],
        p * velocity[a, 2] + q * velocity[b, 2] + r * velocity[c, 2],
    )


@scalar
def link(
    state_a, state_b, total_a, total_b, gained_a, gained_b, cluster_a, cluster_b, doors_a, doors_b, rows, fragments,
    triangle, triangles, velocity, area, dt, weight, species,
):  # fmt: skip
    """Exchange between two rooms for a share `weight` of dt [s] through fragments whose normals point out of room a;
    returns the mass [kg] that went from a to b, and back. total_a, total_b: what their clusters hold; doors_a, doors_b:
    area of all openings of each [faces].

    The flux is that between gases at rest relative to the fragment, turned back to the frame of the lattice. The push
    of walls at the pressure of the cluster, which closes every cell, is taken out again. At most a part of what a
    cluster holds leaves it; through the rest of its openings nothing passes.
    """
    n, k = len(fragments), area * dt * weight
    flux = np.zeros((n, 5))  # mass, momentum, energy
    gone_a, gone_b = np.zeros((len(state_a), 4)), np.zeros((len(state_b), 4))
    for m in range(n):
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
        speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
        energy += 0.5 * mass * speed
        for d in range(3):
            across = up[c, U + d] - v[d] - along * normal[d]
            momentum = push * normal[d] + mass * across
            energy += momentum * v[d]
            flux[m, 1 + d] = size * k * (momentum + mass * v[d])
        flux[m, 0], flux[m, 4] = size * k * mass, size * k * energy
        gone_a[a, 0], gone_b[b, 0] = gone_a[a, 0] + max(flux[m, 0], 0.0), gone_b[b, 0] - min(flux[m, 0], 0.0)
        gone_a[a, 1], gone_b[b, 1] = gone_a[a, 1] + max(flux[m, 4], 0.0), gone_b[b, 1] - min(flux[m, 4], 0.0)
        gone_a[a, 2] += size * k * (state_a[a, C] + abs(along_a)) * state_a[a, RHO]
        gone_b[b, 2] += size * k * (state_b[b, C] + abs(along_b)) * state_b[b, RHO]
        gone_a[a, 3], gone_b[b, 3] = gone_a[a, 3] + size, gone_b[b, 3] + size
    forth, back = 0.0, 0.0
    for m in range(n):
        f, a, b = fragments[m], cluster_a[m], cluster_b[m]
        if not (state_a[a, P] > 0.0 and state_b[b, P] > 0.0):
            continue
        part = min(
            _allowed(total_a, gone_a, doors_a, a, weight, species),
            _allowed(total_b, gone_b, doors_b, b, weight, species),
        )
        up, c = (state_a, a) if flux[m, 0] > 0.0 else (state_b, b)
        for d in range(3):
            momentum = part * flux[m, 1 + d]
            gained_a[a, species + d] -= momentum - part * k * state_a[a, P] * rows[f, NORMAL + d]
            gained_b[b, species + d] += momentum - part * k * state_b[b, P] * rows[f, NORMAL + d]
        mass = part * flux[m, 0]
        for s in range(species):
            gained_a[a, s] -= mass * up[c, Y + s]
            gained_b[b, s] += mass * up[c, Y + s]
        gained_a[a, species + 3] -= part * flux[m, 4]
        gained_b[b, species + 3] += part * flux[m, 4]
        forth, back = forth + max(mass, 0.0), back + max(-mass, 0.0)
    return forth, back


@scalar
def _allowed(total, gone, doors, c, weight, species):
    """Share of what would leave cluster c that may; gone: mass and energy, the mass that waves from these openings of
    it come to, and their area [faces], (clusters, 4); doors: area of all its openings. If waves from all of them come
    to more than there is, they would send more than makes pressures equal."""
    mass, flow = 0.0, 0.0
    for s in range(species):
        mass += total[c, s]
    for d in range(3):
        flow += total[c, species + d] * total[c, species + d]
    thermal, share = total[c, species + 3] - 0.5 * flow / mass, 1.0
    if gone[c, 0] > 0.0:
        share = min(share, weight * LARGEST_SHARE * mass / gone[c, 0])
    if gone[c, 1] > 0.0:
        share = min(share, weight * LARGEST_SHARE * thermal / gone[c, 1])
    if gone[c, 2] > 0.0:
        share = min(share, weight * mass / (gone[c, 2] * max(1.0, doors[c] / gone[c, 3])))
    return max(share, 0.0)
