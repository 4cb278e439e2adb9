"""Edges that a triangulation must have: edges in their way are flipped (Sloan, Adv. Eng. Software 15, 1993)."""

from __future__ import annotations

from collections import deque

import numpy as np

ROUNDING = 1e-12
"""Twice the area of a triangle [m^2] up to which its corners lie on a line."""
PATIENCE = 1000
"""Flips for one edge, at most."""


def with_edges(points: np.ndarray, triangles: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """The triangulation (m, 3) of points [m] (n, 2), counter-clockwise, with the edges (k, 2) in it; edges that cross
    each other, or run through a point, are left out."""
    triangles = triangles.copy()
    across: dict[tuple[int, int], int] = {}  # directed edge -> its triangle
    for k, corners in enumerate(triangles.tolist()):
        across.update({(corners[i], corners[i - 2]): k for i in range(3)})
    forced: set[tuple[int, int]] = set()
    for a, b in edges.tolist():
        if (a, b) not in across and (b, a) not in across:
            _force(points, triangles, across, forced, a, b)
        forced |= {(a, b), (b, a)}
    return triangles


def _force(points, triangles, across, forced, a: int, b: int) -> None:
    waiting = deque(_in_the_way(points, triangles, a, b))
    for _ in range(PATIENCE):
        if not waiting:
            return
        c, d = waiting.popleft()
        if (c, d) in forced or (c, d) not in across or (d, c) not in across:
            continue
        one, other = across[c, d], across[d, c]
        e, f = (int(sum(triangles[k]) - c - d) for k in (one, other))
        if min(_twice_area(points, e, f, d), _twice_area(points, f, e, c)) <= ROUNDING:
            waiting.append((c, d))  # not convex yet
            continue
        del across[c, d], across[d, c]
        for k, corners in ((one, (e, f, d)), (other, (f, e, c))):
            triangles[k] = corners
            across.update({(corners[i], corners[i - 2]): k for i in range(3)})
        if {e, f} != {a, b} and _cross(points, a, b, e, f):
            waiting.append((e, f))


def _in_the_way(points, triangles, a: int, b: int) -> list[tuple[int, int]]:
    """Edges that cross the segment from a to b."""
    found = []
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    ends = ends[ends[:, 0] < ends[:, 1]]
    low, high = np.minimum(points[a], points[b]), np.maximum(points[a], points[b])
    near = (points[ends].min(axis=1) <= high).all(axis=1) & (points[ends].max(axis=1) >= low).all(axis=1)
    for c, d in ends[near].tolist():
        if not {a, b} & {c, d} and _cross(points, a, b, c, d):
            found.append((c, d))
    return found


def _cross(points, a: int, b: int, c: int, d: int) -> bool:
    return (
        _twice_area(points, a, b, c) * _twice_area(points, a, b, d) < 0.0
        and _twice_area(points, c, d, a) * _twice_area(points, c, d, b) < 0.0
    )


def _twice_area(points, a: int, b: int, c: int) -> float:
    (ax, ay), (bx, by), (cx, cy) = points[a], points[b], points[c]
    return float((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))
