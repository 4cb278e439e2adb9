"""The last resort of the filter: nodes of pairs that would still come too near move with one velocity, their mean,
cluster by cluster, until no pair does."""

from __future__ import annotations

import numpy as np

from billow.base.compiled import kernel, scalar
from billow.parts.layers.distance import least_apart, nearest_after

LEFT = 0.5
"""Of the distance that a pair has to keep at least: below it its nodes are joined."""


@scalar
def _root(parent, i):
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@kernel
def join_short(n, awake, edges_from, nodes, normal, distance, gap, floor_of, ways, positions, velocities, dt, parent):
    """Join the clusters of the nodes of pairs that are short; returns how many were. parent: (nodes,) int64, the tree
    of clusters, each node its own at first; ways: over the step, from `look_ahead`."""
    share, highest, least = floor_of
    short = 0
    for i in range(n):
        k = awake[i]
        floor = max(least, min(highest, share * gap[k]))
        wanted = LEFT * min(distance[k], 0.5 * floor)
        if least_apart(k, edges_from, nodes, normal, ways) >= wanted:
            continue
        if nearest_after(k, edges_from, nodes, normal, positions, velocities, dt) >= wanted:
            continue
        short += 1
        lowest = _root(parent, nodes[k, 0])
        for corner in range(1, 4):
            other = _root(parent, nodes[k, corner])
            lowest, highest_root = min(lowest, other), max(lowest, other)
            parent[highest_root] = lowest
    return short


@kernel
def move_together(n, parent, inverse_mass, before, velocities):
    """Nodes of each cluster get its mean of the velocities [m/s] `before`; those of a cluster with a fixed node get the
    velocity of that node."""
    mass, momentum = np.zeros(n), np.zeros((n, 3))
    size, held = np.zeros(n, np.int64), np.full(n, -1, np.int64)
    for i in range(n):
        r = _root(parent, i)
        size[r] += 1
        if inverse_mass[i] > 0.0:
            mass[r] += 1.0 / inverse_mass[i]
            for k in range(3):
                momentum[r, k] += before[i, k] / inverse_mass[i]
        else:
            held[r] = i
    for i in range(n):
        r = _root(parent, i)
        if size[r] == 1:
            continue
        if inverse_mass[i] > 0.0:
            for k in range(3):
                velocities[i, k] = before[held[r], k] if held[r] >= 0 else momentum[r, k] / mass[r]


@kernel
def push_held(n, parent, inverse_mass, before, velocities, push_out):
    """What the nodes of a cluster that moves with a held one push on that [N s], added to push_out, (nodes, 3);
    before: velocities [m/s] before they were joined, (nodes, 3)."""
    held = np.full(n, -1, np.int64)
    for i in range(n):
        if inverse_mass[i] <= 0.0:
            held[_root(parent, i)] = i
    for i in range(n):
        j = held[_root(parent, i)]
        if j >= 0 and inverse_mass[i] > 0.0:
            for k in range(3):
                push_out[j, k] -= (velocities[i, k] - before[i, k]) / inverse_mass[i]
