"""The filter: impulses between layers, after which no pair ends a step nearer than it may (docs/theory.md, Layers).

Between the half kick and the drift, the velocities of nodes are changed by inelastic impulses along the normals of
pairs, found by projected Gauss-Seidel sweeps. Whether a pair comes too near is decided by its true closest distance at
the end of the drift, not by one that is linear in the motion. Layers then never cross, so that the side on which one
lies of another is simply where it is.
"""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, inlined, kernel
from billow.parts.layers.distance import along, between, comes_near, nearest_after
from billow.parts.layers.sweeps import error_allowed

APPROACH = 0.5
"""Part of the way to its floor that a pair may go in a step."""

SCANS = 20
"""Most scans of all pairs in a step."""

WARM = 0.9
"""Part of its last impulse that a pair begins a step with."""

ENOUGH = 0.7
"""Of the distance that a pair has to keep at least; below it the true distance has fallen short."""


@inlined
def speed_wanted(distance, floor, dt):
    """Least speed [m/s] at which a pair has to part."""
    return -APPROACH * (distance - floor) / dt if distance > floor else 0.0


@inlined
def inverse_inertia(k, nodes, weight, inverse_mass):
    """Change of the speed of pair k by a unit impulse [1/kg]."""
    total = 0.0
    for i in range(4):
        total += weight[k, i] * weight[k, i] * inverse_mass[nodes[k, i]]
    return total


@inlined
def push(k, impulse, nodes, weight, normal, inverse_mass, velocities):
    """An impulse [N s] between the sides of pair k."""
    for i in range(4):
        j = nodes[k, i]
        change = impulse * weight[k, i] * inverse_mass[j]
        velocities[j, 0] += change * normal[k, 0]
        velocities[j, 1] += change * normal[k, 1]
        velocities[j, 2] += change * normal[k, 2]


@kernel
def warm_start(
    n, awake, edges_from, nodes, weight, normal, distance, gap, near, floor_of, impulse, inverse_mass, dt, velocities,
    slot_out, index_out, aim_out, per_out, total_out,
):  # fmt: skip
    """Begin with part of the last impulses of pairs that are near; returns the number of constraints."""
    share, highest, least = floor_of
    m = 0
    for i in range(n):
        k = awake[i]
        if impulse[k] <= 0.0 or distance[k] >= (near[1] if k >= edges_from else near[0]):
            continue
        inverse = inverse_inertia(k, nodes, weight, inverse_mass)
        if inverse <= 0.0:
            continue
        floor = max(least, min(highest, share * gap[k]))
        start = WARM * impulse[k]
        slot_out[k] = m
        index_out[m], aim_out[m] = k, speed_wanted(distance[k], floor, dt)
        per_out[m], total_out[m] = 1.0 / inverse, start
        push(k, start, nodes, weight, normal, inverse_mass, velocities)
        m += 1
    return m


@kernel
def scan(
    n, awake, edges_from, nodes, weight, normal, distance, gap, near, floor_of, tolerance, positions, velocities, dt,
    changed, slot, aim, goal_out, chunk_out,
):  # fmt: skip
    """The speed at which each pair awake has to part, NaN where it is fast enough, or where none of its nodes has
    changed since the last scan: (nodes,) bool. chunk_out, (chunks, 3): pairs that are too slow, the largest lack [m]
    beyond the tolerance, and the number whose true distance falls short."""
    share, highest, least = floor_of
    on_triangle, across = near
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        slow, worst, short = 0.0, 0.0, 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            k = np.uint64(awake[i])
            goal_out[i] = np.nan
            a, b, c, e = np.uint64(nodes[k, 0]), np.uint64(nodes[k, 1]), np.uint64(nodes[k, 2]), np.uint64(nodes[k, 3])
            if not (changed[a] | changed[b] | changed[c] | changed[e]):
                continue
            d = distance[k]
            floor = max(least, min(highest, share * gap[k]))
            x, y, z = normal[k, 0], normal[k, 1], normal[k, 2]
            of_a, of_b = along(velocities, a, x, y, z), along(velocities, b, x, y, z)
            of_c, of_e = along(velocities, c, x, y, z), along(velocities, e, x, y, z)
            speed = weight[k, 0] * of_a + weight[k, 1] * of_b + weight[k, 2] * of_c + weight[k, 3] * of_e
            goal = aim[slot[k]] if slot[k] >= 0 else speed_wanted(d, floor, dt)
            lack, wanted, reach = goal - speed, min(d, 0.5 * floor), across if k >= edges_from else on_triangle
            after = between(
                k < edges_from, along(positions, a, x, y, z) + dt * of_a, along(positions, b, x, y, z) + dt * of_b,
                along(positions, c, x, y, z) + dt * of_c, along(positions, e, x, y, z) + dt * of_e,
            )  # fmt: skip
            if after < ENOUGH * wanted:  # a lower bound
                after = nearest_after(k, edges_from, nodes, normal, positions, velocities, dt)
                if after < ENOUGH * wanted:
                    short += 1.0
                    goal = max(goal, speed + (wanted - after) / dt)
                    lack = goal - speed
            if lack > 0.0 and (
                slot[k] >= 0 or comes_near(k, edges_from, nodes, normal, d, positions, velocities, dt / APPROACH, reach)
            ):
                goal_out[i] = goal
                slow += 1.0
                if lack * dt > error_allowed(d, floor, least, tolerance):
                    worst = max(worst, lack * dt)
        chunk_out[chunk, 0], chunk_out[chunk, 1], chunk_out[chunk, 2] = slow, worst, short


@kernel
def admit(n, awake, goal, chunks, nodes, weight, inverse_mass, m, slot_out, index_out, aim_out, per_out, total_out):
    """Pairs that are too slow become constraints, in the order of their keys; returns how many there are now."""
    for chunk in range((n + CHUNK - 1) // CHUNK):
        if chunks[chunk, 0] == 0.0:
            continue
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            if math.isnan(goal[i]):
                continue
            k = awake[i]
            if slot_out[k] >= 0:
                aim_out[slot_out[k]] = goal[i]
                continue
            inverse = inverse_inertia(k, nodes, weight, inverse_mass)
            if inverse > 0.0:
                slot_out[k] = m
                index_out[m], aim_out[m], per_out[m], total_out[m] = k, goal[i], 1.0 / inverse, 0.0
                m += 1
    return m


@kernel
def note(n, awake, m, index, total, nodes, weight, normal, inverse_mass, impulse_out, slot_out, push_out):
    """Keep the impulses of m constraints for the next step; of other pairs awake there are none. push_out: nodes that
    do not yield get what pushes on them [N s], (nodes, 3)."""
    for i in range(n):
        impulse_out[awake[i]] = 0.0
    for q in range(m):
        k = index[q]
        impulse_out[k], slot_out[k] = total[q], -1
        for i in range(4):
            j = nodes[k, i]
            if inverse_mass[j] <= 0.0:
                for axis in range(3):
                    push_out[j, axis] += total[q] * weight[k, i] * normal[k, axis]


@kernel
def allowance(
    n, before, velocities, start_velocity, stray, skin, ahead, ready, seen, looked_with, struck_out, changed_out
):  # fmt: skip
    """How much of its allowance the node used that used most [-], for the list; which nodes have changed since they
    were `seen`, as they are from now on; and which of them were struck: changed by more than `ready` [m/s] since their
    pairs were looked at, `looked_with` these velocities, and again from now on. before: velocities before any impulse;
    stray: of each node from its path so far [m], (nodes,)."""
    largest, any_struck = 0.0, False
    for i in range(n):
        dx, dy, dz = velocities[i, 0] - before[i, 0], velocities[i, 1] - before[i, 1], velocities[i, 2] - before[i, 2]
        changed_out[i] = (
            (velocities[i, 0] != seen[i, 0]) | (velocities[i, 1] != seen[i, 1]) | (velocities[i, 2] != seen[i, 2])
        )
        seen[i, 0], seen[i, 1], seen[i, 2] = velocities[i, 0], velocities[i, 1], velocities[i, 2]
        if dx == 0.0 and dy == 0.0 and dz == 0.0:
            struck_out[i] = False
            continue
        wx, wy, wz = (
            velocities[i, 0] - looked_with[i, 0], velocities[i, 1] - looked_with[i, 1],
            velocities[i, 2] - looked_with[i, 2],
        )  # fmt: skip
        struck_out[i] = wx * wx + wy * wy + wz * wz > ready * ready
        if struck_out[i]:
            any_struck = True
            for k in range(3):
                looked_with[i, k] = velocities[i, k]
        vx, vy, vz = (
            velocities[i, 0] - start_velocity[i, 0], velocities[i, 1] - start_velocity[i, 1],
            velocities[i, 2] - start_velocity[i, 2],
        )  # fmt: skip
        largest = max(largest, (stray[i] + ahead * math.sqrt(vx * vx + vy * vy + vz * vz)) / skin[i])
    return largest, any_struck
