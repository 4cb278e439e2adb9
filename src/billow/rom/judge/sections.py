"""Cross-sections: the plane y = 0 through a triangle mesh and through obstacles."""

from __future__ import annotations

import numpy as np


def cut(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Where the plane y = 0 cuts a triangle mesh: [m], (segments, 2 ends, 2) as x and z.

    points: [m], (nodes, 3); triangles: (triangles, 3) int

    A node exactly on the plane counts as above it, so every cut triangle gives one segment, none is given twice, and
    a closed surface gives closed loops.
    """
    above = points[:, 1] >= 0.0
    side = above[triangles]
    crossed = triangles[side.any(axis=1) & ~side.all(axis=1)]
    edges = np.stack([crossed, np.roll(crossed, -1, axis=1)], axis=2)  # (triangles, 3 edges, 2 ends)
    ends = edges[above[edges[..., 0]] != above[edges[..., 1]]]  # two edges of each triangle, in order
    start, stop = points[ends[:, 0]].astype(float), points[ends[:, 1]].astype(float)
    part = (start[:, 1] / (start[:, 1] - stop[:, 1]))[:, None]
    return (start + part * (stop - start))[:, [0, 2]].reshape(-1, 2, 2)


def super_ellipsoid(obstacle: dict, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The function whose zero line is an obstacle's outline in the plane y = 0: [-], negative inside, shape of x and z.

    obstacle: "center" [m] (3,), "radii" [m] (3,), "degree" [-], "rotation" (3, 3) from body to space
    """
    space = np.stack([x, np.zeros_like(x), z], axis=-1) - np.asarray(obstacle["center"], float)
    body = space @ np.asarray(obstacle["rotation"], float)  # rotation transposed, from the left
    radii, degree = np.asarray(obstacle["radii"], float), float(obstacle["degree"])
    return (np.abs(body / radii) ** degree).sum(axis=-1) - 1.0
