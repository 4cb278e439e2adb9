"""What of a surface can touch: its solid triangles, their edges, and which triangle speaks for a node or an edge."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.geometry.crossings import edges_of
from billow.geometry.surface import Surface


class TouchMesh(NamedTuple):
    """triangles: (n, 3) int32. edges: (edges, 2) int32, lower node first, ascending. Each node and each edge is looked
    at once, with the first triangle that has it: own_node_start (n + 1,) and own_node, own_edge_start (n + 1,) and
    own_edge, int32, those of each triangle. free: whether a node can move, (nodes,) bool."""

    triangles: np.ndarray
    edges: np.ndarray
    own_node_start: np.ndarray
    own_node: np.ndarray
    own_edge_start: np.ndarray
    own_edge: np.ndarray
    free: np.ndarray

    @classmethod
    def of(cls, surface: Surface, free: np.ndarray) -> TouchMesh:
        triangles = surface.triangles[surface.solid].astype(np.int64)
        edges, nodes = edges_of(triangles), surface.node_count
        ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
        edge = np.searchsorted(edges[:, 0] * nodes + edges[:, 1], ends[:, :, 0] * nodes + ends[:, :, 1])
        return cls(
            triangles.astype(np.int32), edges.astype(np.int32), *_first_seen(triangles), *_first_seen(edge), free
        )


def _first_seen(numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of (n, 3) numbers those of each row that occur there for the first time: where each row's begin, and they."""
    first = np.sort(np.unique(numbers.ravel(), return_index=True)[1])
    start = np.searchsorted(first, 3 * np.arange(len(numbers) + 1))
    return start.astype(np.int32), numbers.ravel()[first].astype(np.int32)
