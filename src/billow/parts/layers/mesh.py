"""What of a surface can touch: its solid triangles, their edges, and which triangle speaks for a node or an edge."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.crossings import edges_of
from billow.geometry.surface import Surface

PASSES = 10
"""Over all members, when they are shared out; more would hardly even them out further."""


class TouchMesh(NamedTuple):
    """triangles: (n, 3) int32. edges: (edges, 2) int32, lower node first, ascending. Each node and each edge is looked
    at once, with one triangle that has it: own_node, own_edge: (n, most) int32, those of each triangle, filled up with
    the number of nodes and of edges. free: whether a node can move, (nodes,) bool."""

    triangles: np.ndarray
    edges: np.ndarray
    own_node: np.ndarray
    own_edge: np.ndarray
    free: np.ndarray

    @classmethod
    def of(cls, surface: Surface, free: np.ndarray) -> TouchMesh:
        triangles = surface.triangles[surface.solid].astype(np.int64)
        edges, nodes = edges_of(triangles), surface.node_count
        ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
        edge = np.searchsorted(edges[:, 0] * nodes + edges[:, 1], ends[:, :, 0] * nodes + ends[:, :, 1])
        own_node, own_edge = shared_out(triangles, nodes), shared_out(edge, len(edges))
        return cls(triangles.astype(np.int32), edges.astype(np.int32), own_node, own_edge, free)


def shared_out(members: np.ndarray, count: int) -> np.ndarray:
    """Give each of `count` members to one of the triangles (n, 3) that have it, about as many to each: what each
    triangle has, (n, most) int32, filled up with `count`."""
    n = len(members)
    order = np.argsort(members.ravel(), kind="stable")
    start = np.searchsorted(members.ravel()[order], np.arange(count + 1))
    own, load = np.full((n, 3), count, np.int32), np.zeros(n, np.int64)
    _share_out(start, order // 3, own, load)
    return np.ascontiguousarray(own[:, : max(1, int(load.max(initial=0)))])


@scalar
def _share_out(start, triangle, own, load):
    """Each member goes to the triangle that has the fewest, and again while that helps any."""
    count = len(start) - 1
    owner = np.full(count, -1, np.int64)
    for _ in range(PASSES):
        for member in range(count):
            best = owner[member]
            for i in range(start[member], start[member + 1]):
                if best < 0 or load[triangle[i]] < load[best] - (best == owner[member]):
                    best = triangle[i]
            if best != owner[member]:
                if owner[member] >= 0:
                    load[owner[member]] -= 1
                owner[member] = best
                load[best] += 1
    load[:] = 0
    for member in range(count):
        if owner[member] >= 0:
            own[owner[member], load[owner[member]]] = member
            load[owner[member]] += 1
