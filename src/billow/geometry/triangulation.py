"""Delaunay triangulation of points in a plane, always in the same order, and smoothing of points that may move."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

SWEEPS = 8


def triangulate(points: np.ndarray) -> np.ndarray:
    """Triangles (m, 3) int64, counter-clockwise, that join points [m] (n, 2) and fill their convex hull."""
    triangles = Delaunay(points).simplices.astype(np.int64)
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
        edges = unique_edges(triangulate(points))
        both = np.concatenate([edges, edges[:, ::-1]])
        degree = np.bincount(both[:, 0], minlength=len(points))
        mean = np.column_stack(
            [
                np.bincount(both[:, 0], weights=points[both[:, 1], k], minlength=len(points)) / np.maximum(degree, 1)
                for k in range(2)
            ]
        )
        points = np.where(movable[:, None], 0.5 * points + 0.5 * mean, points)
    return points


def unique_edges(triangles: np.ndarray) -> np.ndarray:
    """Each edge once, (n, 2), lower node first, in ascending order."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return np.unique(edges, axis=0)
