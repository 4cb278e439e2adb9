"""What of a surface can touch: its solid triangles, their edges and nodes, neighbours beside each other."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.geometry.crossings import edges_of
from billow.geometry.neighbours import by_halves
from billow.geometry.surface import Surface
from billow.parts.layers.groups import landmark_hops
from billow.parts.layers.rings import Rings


class TouchMesh(NamedTuple):
    """Neighbours stand beside each other, as in `groups`. triangles: (n, 3) int32. edges: (edges, 4) int32, their two
    nodes, and the third ones of up to two of their triangles, -1 where there is none. nodes: those of the triangles,
    (touching nodes,) int32. free: whether a node can move, (nodes,) bool. rings: of triangles, around nodes."""

    triangles: np.ndarray
    edges: np.ndarray
    nodes: np.ndarray
    free: np.ndarray
    rings: Rings

    @classmethod
    def of(cls, surface: Surface, free: np.ndarray) -> TouchMesh:
        triangles = surface.triangles[surface.solid].astype(np.int32)
        rings = Rings.of(triangles, surface.node_count)
        hops, edges = landmark_hops(rings), edges_of(triangles)
        triangles = triangles[by_halves(hops[triangles].mean(axis=1))]
        edges = edges[by_halves(hops[edges].mean(axis=1))]
        nodes = np.unique(triangles)
        nodes = nodes[by_halves(hops[nodes])]
        with_thirds = np.column_stack([edges, third_nodes(edges, triangles, surface.node_count)])
        return cls(triangles, with_thirds.astype(np.int32), nodes.astype(np.int32), free, rings)


def third_nodes(edges: np.ndarray, triangles: np.ndarray, nodes: int) -> np.ndarray:
    """Of each edge (edges, 2) the nodes opposite to it in the first two triangles that have it, -1 where there is none:
    (edges, 2)."""
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    third, key = np.roll(triangles, 1, axis=1).ravel(), ends[:, 0].astype(np.int64) * nodes + ends[:, 1]
    order = np.argsort(key, kind="stable")
    wanted = edges[:, 0].astype(np.int64) * nodes + edges[:, 1]
    first, end = np.searchsorted(key[order], wanted), np.searchsorted(key[order], wanted, side="right")
    second = np.where(end - first > 1, third[order[np.minimum(first + 1, len(order) - 1)]], -1)
    return np.column_stack([third[order[first]], second])
