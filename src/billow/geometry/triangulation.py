"""Delaunay triangulation of points in a plane, always in the same order, smoothing of points that may move, and quads
split into triangles."""

from __future__ import annotations

import numpy as np

from billow.geometry.components import components
from billow.geometry.delaunay import delaunay

SWEEPS = 8


def triangulate(points: np.ndarray) -> np.ndarray:
    """Triangles (m, 3) int64, counter-clockwise, that join points [m] (n, 2) and fill their convex hull."""
    triangles = delaunay(points).astype(np.int64)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    flipped = twice < 0.0
    triangles[flipped] = triangles[flipped][:, [0, 2, 1]]
    longest = np.max([np.sum((p - q) ** 2, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    triangles = triangles[np.abs(twice) > 1e-6 * longest]  # slivers on the convex rim
    return triangles[np.lexsort(triangles.T[::-1])]


def smoothed(points: np.ndarray, movable: np.ndarray) -> np.ndarray:
    """Points [m] (n, 2) after a few sweeps that pull the movable ones, (n,) bool, towards the mean of their neighbours
    (Laplacian smoothing)."""
    for _ in range(SWEEPS):
        edges = np.unique(sorted_edges(triangulate(points)), axis=0)
        both = np.concatenate([edges, edges[:, ::-1]])
        degree = np.bincount(both[:, 0], minlength=len(points))
        sums = [np.bincount(both[:, 0], points[both[:, 1], k], len(points)) for k in range(2)]
        mean = np.column_stack(sums) / np.maximum(degree, 1)[:, None]
        points = np.where(movable[:, None], 0.5 * points + 0.5 * mean, points)
    return points


def sorted_edges(triangles: np.ndarray) -> np.ndarray:
    """All first, second and third edges, (3 triangles, 2), lower node first."""
    return np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)


def diagonals(cells: np.ndarray, node_count: int) -> np.ndarray:
    """Corner, 0 or 1, from which each quad's diagonal runs, (cells,); cells: (cells, 4), -1 last for triangles.

    The diagonals join nodes of one colour of a checkerboard, so that on a grid their directions alternate. A node with
    two edges is a corner where two panels meet; there the diagonal runs into the corner, because two panels must not
    share a diagonal that cuts the corner off.
    """
    quads = cells[cells[:, 3] >= 0]
    first, second = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    # In the double cover of the graph of edges a node and its image are connected unless the graph has two colours.
    crossed = np.column_stack([first, second + node_count]), np.column_stack([first + node_count, second])
    least = components(2 * node_count, np.concatenate(crossed))
    colour = (least[:node_count] > least[node_count:]).astype(np.int64)
    edges = np.unique(np.sort(np.column_stack([first, second]), axis=1), axis=0)
    corner = np.bincount(edges.ravel(), minlength=node_count) == 2
    diagonal = np.zeros(len(cells), dtype=np.int64)
    sharp = corner[quads]
    diagonal[cells[:, 3] >= 0] = np.where(sharp.any(axis=1), sharp.argmax(axis=1) % 2, colour[quads[:, 0]])
    return diagonal


def split(cells: np.ndarray, diagonal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (n, 3) in the order of their cells, and the cell of each, (n,)."""
    turned = np.where(diagonal[:, None] == 1, np.roll(cells, -1, axis=1), cells)
    quad = cells[:, 3] >= 0
    first, second = np.where(quad[:, None], turned, cells)[:, [0, 1, 2]], turned[quad][:, [0, 2, 3]]
    owner = np.concatenate([np.arange(len(cells)), np.flatnonzero(quad)])
    order = np.argsort(owner, kind="stable")
    return np.concatenate([first, second])[order], owner[order]
