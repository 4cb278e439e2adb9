"""Fabric in several layers: seams and reinforcements, smeared over the elements they cover (docs/theory.md, Seams and
reinforcements)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from billow.geometry.bag_shapes import BagShape
from billow.geometry.disc_mesh import rim_count

SPLITS = 4
"""Elements that are partly covered are divided into 4 x 4 equal triangles, with linear depth in each."""

Depth = Callable[[np.ndarray], np.ndarray]
"""From flat points [m] (n, 2) to the depth [m] (n,) at which they lie under the second layer, negative outside."""


def doubled(shape: BagShape, parts: tuple[str, ...], depth: Depth, layers: float) -> BagShape:
    """The shape with `layers` layers of fabric instead of one wherever depth is positive in these parts."""
    thickness = shape.layers.copy()
    for part in parts:
        cloth = shape.surface.triangles_of(part)
        thickness[cloth] += (layers - 1.0) * covered_share(shape.reference[cloth], depth)
    return replace(shape, layers=thickness)


def covered_share(flat: np.ndarray, depth: Depth) -> np.ndarray:
    """Share of the area of flat triangles [m] (n, 3, 2) in which depth is positive, [-], (n,)."""
    centre = flat.mean(axis=1)
    reach = np.linalg.norm(flat - centre[:, None], axis=2).max(axis=1)
    middle = depth(centre)
    share = np.where(middle > 0.0, 1.0, 0.0)
    partly = np.flatnonzero(np.abs(middle) < reach)
    points = np.einsum("skc,ncx->nskx", _pieces(), flat[partly])
    depths = depth(points.reshape(-1, 2)).reshape(points.shape[:3])
    share[partly] = _positive_share(depths).mean(axis=1)
    return share


def _positive_share(corners: np.ndarray) -> np.ndarray:
    """Share of a triangle in which a linear function is positive, from its values at the corners (..., 3)."""
    low, middle, high = np.moveaxis(np.sort(corners, axis=-1), -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        tip = high**2 / ((high - low) * (high - middle))
        rest = 1.0 - low**2 / ((high - low) * (middle - low))
    return np.select([high <= 0.0, low >= 0.0, middle <= 0.0], [0.0, 1.0, tip], rest)


def ring_depth(inner: float, outer: float) -> Depth:
    """Between two radii [m] about the origin."""

    def depth(points):
        r = np.hypot(points[:, 0], points[:, 1])
        return np.minimum(r - inner, outer - r)

    return depth


def rim_depth(radius: float, size: float, width: float) -> Depth:
    """Within `width` [m] of the rim of a disc that is meshed as a polygon with edges of about `size` [m]."""
    step = 2.0 * np.pi / rim_count(radius, size)

    def depth(points):
        r, angle = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])
        from_middle = angle % step - 0.5 * step
        return width - (radius * np.cos(0.5 * step) - r * np.cos(from_middle))

    return depth


def line_depth(lines: np.ndarray, width: float) -> Depth:
    """Within `width` [m] of straight seams, lines: [m], (n, 2 ends, 2)."""
    return lambda points: width - distance_to_lines(points, lines)


def distance_to_lines(points: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Distance [m] of points (n, 2) to the nearest of some straight lines (m, 2 ends, 2), (n,)."""
    nearest = np.full(len(points), np.inf)
    for start, end in lines:
        way = end - start
        along = np.clip((points - start) @ way / (way @ way), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(points - start - along[:, None] * way, axis=1))
    return nearest


def _pieces() -> np.ndarray:
    """Barycentric coordinates of the corners of a triangle's SPLITS^2 equal parts, (SPLITS^2, 3 corners, 3)."""
    upright = [[(i, j), (i + 1, j), (i, j + 1)] for i in range(SPLITS) for j in range(SPLITS - i)]
    turned = [[(i + 1, j + 1), (i, j + 1), (i + 1, j)] for i in range(SPLITS - 1) for j in range(SPLITS - 1 - i)]
    first = np.array(upright + turned) / SPLITS
    return np.concatenate([first, 1.0 - first.sum(axis=2, keepdims=True)], axis=2)
