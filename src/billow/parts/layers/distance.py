"""Which pairs can matter in a step, and how far apart they are.

Along any direction, the least place of the nodes of one side less the most of the other is a lower bound of the
distance of a pair; while nodes move straight it is concave in time, and so no less than at both ends. Along the last
normal this bound is close. Most pairs of a list sleep through a step: they are farther apart now, and where their nodes
will be.
"""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, inlined, kernel, scalar
from billow.geometry.closest_blocks import (
    BLOCK,
    ROWS,
    SQUARE,
    S,
    T,
    X,
    Y,
    Z,
    fill,
    nodes_on_triangles,
    segments_on_segments,
)  # fmt: skip
from billow.geometry.closest_points import of_segments, on_triangle

AWAKE, ABLE = 1, 2
"""Marks."""

PASSED = -0.5
"""Cosine of the angle by which a normal turns in a step, at which a pair counts as having changed sides."""


@inlined
def along(vectors, i, x, y, z):
    """Component of a node's vector along a direction."""
    return x * vectors[i, 0] + y * vectors[i, 1] + z * vectors[i, 2]


@inlined
def between(is_node, a, b, c, d):
    """How much lower the second side ends than the first begins: of four numbers, one a node."""
    first = a if is_node or a < b else b
    second = c if c > d else d
    second = b if is_node and b > second else second
    return first - second


@kernel
def look_ahead(n, positions, velocities, ahead, ways_out):
    """Where nodes are, and where they will be `ahead` [s] from now [m], side by side: (nodes, 6)."""
    for i in range(n):
        for k in range(3):
            ways_out[i, k] = positions[i, k]
            ways_out[i, 3 + k] = positions[i, k] + ahead * velocities[i, k]


@inlined
def least_apart(k, edges_from, nodes, normal, ways):
    """A lower bound of the distance of pair k [m] on the ways of its nodes, from `look_ahead`."""
    x, y, z = normal[k, 0], normal[k, 1], normal[k, 2]
    a, b, c, d = np.uint64(nodes[k, 0]), np.uint64(nodes[k, 1]), np.uint64(nodes[k, 2]), np.uint64(nodes[k, 3])
    now = between(k < edges_from, along(ways, a, x, y, z), along(ways, b, x, y, z), along(ways, c, x, y, z),
                  along(ways, d, x, y, z))  # fmt: skip
    then = between(
        k < edges_from, x * ways[a, 3] + y * ways[a, 4] + z * ways[a, 5],
        x * ways[b, 3] + y * ways[b, 4] + z * ways[b, 5], x * ways[c, 3] + y * ways[c, 4] + z * ways[c, 5],
        x * ways[d, 3] + y * ways[d, 4] + z * ways[d, 5],
    )  # fmt: skip
    return now if now < then else then


@scalar
def closest(is_node, ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz):
    """Way from the second side of a pair to its first [m]."""
    if is_node:
        _, _, x, y, z = on_triangle(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz)
    else:
        _, _, x, y, z = of_segments(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz)
    return x, y, z


@inlined
def nearest_after(k, edges_from, nodes, normal, positions, velocities, dt):
    """True distance of pair k after a time of dt [s] [m], negative if its sides have changed places."""
    a, b, c, d = nodes[k, 0], nodes[k, 1], nodes[k, 2], nodes[k, 3]
    rx, ry, rz = closest(
        k < edges_from,
        positions[a, 0] + dt * velocities[a, 0], positions[a, 1] + dt * velocities[a, 1],
        positions[a, 2] + dt * velocities[a, 2],
        positions[b, 0] + dt * velocities[b, 0], positions[b, 1] + dt * velocities[b, 1],
        positions[b, 2] + dt * velocities[b, 2],
        positions[c, 0] + dt * velocities[c, 0], positions[c, 1] + dt * velocities[c, 1],
        positions[c, 2] + dt * velocities[c, 2],
        positions[d, 0] + dt * velocities[d, 0], positions[d, 1] + dt * velocities[d, 1],
        positions[d, 2] + dt * velocities[d, 2],
    )  # fmt: skip
    size = math.sqrt(rx * rx + ry * ry + rz * rz)
    return -size if rx * normal[k, 0] + ry * normal[k, 1] + rz * normal[k, 2] < PASSED * size else size


@scalar
def fastest(k, edges_from, nodes, velocities):
    """Largest relative speed of nodes on the two sides of pair k [m/s]."""
    firsts, square = 1 if k < edges_from else 2, 0.0
    for i in range(firsts):
        for j in range(firsts, 4):
            a, b = nodes[k, i], nodes[k, j]
            x, y = velocities[a, 0] - velocities[b, 0], velocities[a, 1] - velocities[b, 1]
            z = velocities[a, 2] - velocities[b, 2]
            square = max(square, x * x + y * y + z * z)
    return math.sqrt(square)


@scalar
def comes_near(k, edges_from, nodes, normal, now, positions, velocities, ahead, near):
    """Whether pair k, `now` [m] apart, comes within `near` [m] until `ahead` [s] from now; by less than half of that it
    may be missed. Whatever does is in every list."""
    time, apart, speed = 0.0, now, fastest(k, edges_from, nodes, velocities)
    while apart > near and time < ahead:
        time = min(ahead, time + (apart - 0.5 * near) / speed)
        apart = abs(nearest_after(k, edges_from, nodes, normal, positions, velocities, time))
    return apart <= near


@kernel
def wake(n, level, until, edges_from, nodes, normal, ways, reach, impulse, mark_out):
    """Mark those of n pairs that can matter: with AWAKE, or with ABLE those among them that may need an impulse. Only
    levels `until` one are looked at; reach: distances [m] at which a node and a triangle matter, and two edges, and at
    which any pair may need an impulse."""
    near, edges_near, pressing = reach
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            k = np.uint64(i)
            if level[k] > until:
                continue
            apart = least_apart(k, edges_from, nodes, normal, ways)
            if apart <= (edges_near if k >= edges_from else near):
                mark_out[k] = ABLE if apart <= pressing or impulse[k] > 0.0 else AWAKE


@kernel
def put_to_sleep(n, pairs, mark, full_gap, gap_out, impulse_out):
    """Those of n pairs, all that may not have it yet, which sleep get the full gap and no impulse: they are farther
    apart."""
    for i in range(n):
        k = pairs[i]
        if mark[k] == 0:
            gap_out[k], impulse_out[k] = full_gap, 0.0


@kernel
def gather_marked(n, marks, words, awake_out, able_out):
    """Indices of the pairs with a mark, ascending, and of those ABLE; how many they are, and all marks are taken off.
    words: marks (8 n,), eight by eight."""
    awake, able = 0, 0
    for w in range(n):
        if words[w] == 0:
            continue
        for k in range(8 * w, 8 * w + 8):
            if marks[k] == 0:
                continue
            awake_out[awake] = k
            awake += 1
            if marks[k] == ABLE:
                able_out[able] = k
                able += 1
        words[w] = 0
    return awake, able


@kernel
def wake_struck(n, level, until, edges_from, nodes, normal, ways, struck, is_found, reach, found_out, count_out):
    """Indices of pairs that can matter, (2, pairs), and how many there are, (2, chunks), by chunks, each from its own
    place on: of all that do, and of those among them that may need an impulse. Only those that were not found before,
    although one of their nodes was struck: nodes whose velocity an impulse changed by more than others are ready for.
    struck: (nodes,) bool; is_found: (2, pairs) bool; level, until, reach: as in `wake`."""
    near, edges_near, pressing = reach
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        awake, able = first, first
        for i in range(first, min(n, first + CHUNK)):
            k = np.uint64(i)
            if level[k] > until:
                continue
            a, b, c, d = np.uint64(nodes[k, 0]), np.uint64(nodes[k, 1]), np.uint64(nodes[k, 2]), np.uint64(nodes[k, 3])
            if is_found[1, k] or not (struck[a] | struck[b] | struck[c] | struck[d]):
                continue
            apart = least_apart(k, edges_from, nodes, normal, ways)
            if apart > (edges_near if k >= edges_from else near):
                continue
            if not is_found[0, k]:
                found_out[0, awake] = k
                awake += 1
            if apart <= pressing:
                found_out[1, able] = k
                able += 1
        count_out[0, chunk], count_out[1, chunk] = awake - first, able - first


@kernel
def gather(n, found, counts, indices_out):
    """Indices that chunks found, one chunk after the other."""
    into = 0
    for chunk in range(n):
        for i in range(chunk * CHUNK, chunk * CHUNK + counts[chunk]):
            indices_out[into] = found[i]
            into += 1


@kernel
def measure(n, awake, edges_from, nodes, positions, moment, normal_out, weight_out, distance_out, measured_out):
    """Weights, normal and distance of the pairs awake [m], where they are not known at this moment yet."""
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        todo, block, m, on = np.empty(CHUNK, np.int64), np.zeros(ROWS * BLOCK), 0, 0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            if measured_out[awake[i]] != moment:
                todo[m] = awake[i]
                m += 1
                on += awake[i] < edges_from
        for kind in range(2):
            begin, end = (0, on) if kind == 0 else (on, m)
            for first in range(begin, end, BLOCK):
                count = min(BLOCK, end - first)
                for j in range(count):
                    k = np.uint64(todo[first + j])
                    a, b = np.uint64(nodes[k, 0]), np.uint64(nodes[k, 1])
                    fill(block, j, positions, a, b, np.uint64(nodes[k, 2]), np.uint64(nodes[k, 3]))
                if kind == 0:
                    nodes_on_triangles(block)
                else:
                    segments_on_segments(block)
                for j in range(count):
                    k, s, t = np.uint64(todo[first + j]), block[S + j], block[T + j]
                    size = math.sqrt(block[SQUARE + j])
                    if kind == 0:
                        weight_out[k, 0], weight_out[k, 1], weight_out[k, 2], weight_out[k, 3] = (
                            1.0,
                            s + t - 1.0,
                            -s,
                            -t,
                        )
                    else:
                        weight_out[k, 0], weight_out[k, 1], weight_out[k, 2], weight_out[k, 3] = 1.0 - s, s, t - 1.0, -t
                    distance_out[k], measured_out[k] = size, moment
                    if size > 0.0:  # what lies in one place keeps the normal it had
                        per = 1.0 / size
                        normal_out[k, 0], normal_out[k, 1] = per * block[X + j], per * block[Y + j]
                        normal_out[k, 2] = per * block[Z + j]


@inlined
def speed_along(k, nodes, weight, normal, velocities):
    """Speed [m/s] at which the closest points of pair k part."""
    total = 0.0
    for i in range(4):
        j = nodes[k, i]
        speed = normal[k, 0] * velocities[j, 0] + normal[k, 1] * velocities[j, 1] + normal[k, 2] * velocities[j, 2]
        total += weight[k, i] * speed
    return total


@kernel
def touch(n, awake, edges_from, nodes, distance, near, touched_out):
    """Mark the nodes that lie within `near` [m] of a triangle."""
    for i in range(n):
        k = awake[i]
        if k >= edges_from:
            break
        if distance[k] <= near:
            touched_out[nodes[k, 0]] = True
