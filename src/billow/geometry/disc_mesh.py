"""Triangulation of a flat disc with round holes, near equilateral and the same on every machine: Delaunay, of points
on concentric rings (6k on ring k), on the holes' rims and at required radii, smoothed near the holes.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from billow.geometry.triangulation import smoothed, triangulate

CLEARANCE = 0.55
"""Distance kept between a hole and the nodes around it, in edges."""


@dataclass(frozen=True)
class Hole:
    """A circular patch cut out of a panel: centre [m] (x, y), radius [m]."""

    x: float
    y: float
    radius: float


def circle(radius: float, count: int, x: float = 0.0, y: float = 0.0) -> np.ndarray:
    """`count` points [m] on a circle, (count, 2)."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)])


def mesh_disc(
    radius: float, size: float, ring_radii: tuple[float, ...] = (), holes: tuple[Hole, ...] = ()
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Mesh a disc of `radius` [m] with edges of about `size` [m].

    ring_radii: radii [m] on which a ring of nodes must lie (stitch lines, retainer ring).
    holes: patches with nodes on their rim and none inside; they are meshed too (a vent is closed by virtual triangles).

    Returns points (n, 2) [m], triangles (m, 3) counter-clockwise, and for each hole the indices of its triangles.
    The outer rim's points come first, `rim_count(radius, size)` of them, equally spaced from angle 0.
    """
    fixed = [circle(radius, rim_count(radius, size))]
    rings = _rings(radius, size, ring_radii)
    free = []
    for ring in rings:
        points = _ring_points(ring, size, required=ring in ring_radii)
        clear = np.ones(len(points), dtype=bool)
        for hole in holes:
            clear &= np.hypot(points[:, 0] - hole.x, points[:, 1] - hole.y) > hole.radius + CLEARANCE * size
        (fixed if ring in ring_radii else free).append(points[clear])
    rims = []
    for hole in holes:
        count, polygon = hole_polygon(hole.radius, size)
        start = sum(map(len, fixed))
        fixed.append(circle(polygon, count, hole.x, hole.y))
        rims.append(np.arange(start, start + count))
    anchored = np.concatenate(fixed)
    points = np.concatenate([anchored, *free])
    if holes:
        points = _smooth(points, len(anchored), size, holes)
    triangles = triangulate(points)
    patches = [np.flatnonzero(np.isin(triangles, rim).all(axis=1)) for rim in rims]
    return points, triangles, patches


def rim_count(radius: float, size: float) -> int:
    """Number of nodes on the outer rim."""
    return 6 * max(2, round(radius / size))


def hole_polygon(radius: float, size: float) -> tuple[int, float]:
    """Corners and circumradius [m] of the polygon that stands for a hole: of the hole's area, so that the outflow does
    not depend on the mesh."""
    count = max(6, round(2.0 * np.pi * radius / size))
    return count, radius * np.sqrt(2.0 * np.pi / (count * np.sin(2.0 * np.pi / count)))


def _rings(radius: float, size: float, required: tuple[float, ...]) -> list[float]:
    """Ring radii from the centre outwards (rim excluded): required ones exactly, the gaps filled evenly."""
    stops = [0.0, *sorted(required), radius]
    rings = []
    for inner, outer in itertools.pairwise(stops):
        count = max(1, round((outer - inner) / size))
        rings += [inner] + [inner + (outer - inner) * k / count for k in range(1, count)]
    return rings


def _ring_points(ring: float, size: float, required: bool) -> np.ndarray:
    if ring == 0.0:
        return np.zeros((1, 2))
    if required:  # a multiple of 12, so that 2, 3, 4 or 6 straps meet the same pattern of nodes
        return circle(ring, 12 * max(1, round(ring / (2.0 * size))))
    return circle(ring, max(6, 6 * round(ring / size)))


def _smooth(points: np.ndarray, anchored: int, size: float, holes: tuple[Hole, ...]) -> np.ndarray:
    """Even out the points around holes; those further away stay, and only those nearby are triangulated for it."""
    away = np.min([np.hypot(points[:, 0] - h.x, points[:, 1] - h.y) - h.radius for h in holes], axis=0)
    near = np.flatnonzero(away < 7.0 * size)
    movable = (away[near] < 3.5 * size) & (near >= anchored)
    points[near] = smoothed(points[near], movable)
    return points
