"""From a reference shape in space to the flat cut: where each triangle lies in its panel's own plane (docs/theory.md,
Reference shape). In a plane z = constant flat coordinates are x and y, elsewhere x is the horizontal direction nearest
to the global x axis.
"""

from __future__ import annotations

import numpy as np

from billow.geometry.surface import area_vectors

PLANE = np.cos(np.radians(1.0))
"""Cosine between a triangle's normal and its panel's up to which the panel counts as plane."""


def signed_areas(flat: np.ndarray) -> np.ndarray:
    """Areas [m^2], (n,), of flat triangles [m] (n, 3, 2); negative if they run clockwise."""
    u, w = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    return 0.5 * (u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0])


def flat_area(reference: np.ndarray) -> np.ndarray:
    """Area as cut [m^2], (triangles,), of flat corner coordinates [m], (triangles, 3, 2)."""
    return np.abs(signed_areas(reference))


def flat_cut(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Flat coordinates [m] of a panel's triangles, (n, 3, 2); points: [m], (nodes, 3); triangles: (n, 3).

    In a plane panel the sign of a triangle's area tells from which side it is seen: for z = constant from above, else
    from the side that most of its area is seen from.
    """
    corners = points[triangles]
    areas = area_vectors(triangles, points)
    normal = _plane(areas)
    if normal is None:
        length = np.linalg.norm(areas, axis=1, keepdims=True)
        normal = np.where(length > 0.0, areas / np.where(length > 0.0, length, 1.0), [0.0, 0.0, 1.0])
    normal = np.broadcast_to(normal, areas.shape)
    x = _along(normal, np.abs(areas.sum(axis=0)).argmax() == 0)
    y = np.cross(normal, x)
    from_first = corners if np.ptp(normal, axis=0).max() == 0.0 else corners - corners[:, :1]
    return np.stack([np.einsum("ncx,nx->nc", from_first, axis) for axis in (x, y)], axis=2)


def _plane(areas: np.ndarray) -> np.ndarray | None:
    """Unit normal (3,) of the plane that all triangles lie in, or None."""
    size = np.linalg.norm(areas, axis=1)
    largest = areas[size.argmax()]
    if not size.max() > 0.0:
        return None
    normal = largest / np.linalg.norm(largest)
    if (np.abs(areas @ normal) < PLANE * size).any():
        return None
    if abs(normal[2]) > PLANE:
        return np.array([0.0, 0.0, 1.0])
    return normal if (areas @ normal).sum() >= 0.0 else -normal


def _along(normal: np.ndarray, across_x: bool) -> np.ndarray:
    """Unit vectors in the planes of unit normals (n, 3), nearest to the global x axis, or to y where a panel faces
    along x."""
    axis = np.array([0.0, 1.0, 0.0]) if across_x else np.array([1.0, 0.0, 0.0])
    flat = axis - (normal @ axis)[:, None] * normal
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    level = length[:, 0] < 1e-6  # this triangle alone faces along the axis: any direction in it will do
    other = np.roll(normal[level], 1, axis=1)
    flat[level] = other - np.sum(other * normal[level], 1)[:, None] * normal[level]
    return flat / np.linalg.norm(flat, axis=1, keepdims=True)
