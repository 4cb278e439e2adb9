"""Surfaces of shapes as triangles, for pictures and files."""

from __future__ import annotations

from functools import cache

import numpy as np

from billow.geometry.shapes.box import Box
from billow.geometry.shapes.cylinder import Cylinder
from billow.geometry.shapes.mesh import Mesh
from billow.geometry.shapes.shape import Shape

FINENESS = 4
"""How often the triangles of an icosahedron are cut in four: 5,120 triangles."""
HALVINGS = 40
"""Of the distance from the centre at which a surface is looked for."""


def triangulated(shape: Shape, fineness: int = FINENESS) -> tuple[np.ndarray, np.ndarray]:
    """Points [m] (nodes, 3) in a shape's own axes and triangles (n, 3), outwards, of one that has an end."""
    if isinstance(shape, Mesh):
        return shape.points, shape.triangles
    if isinstance(shape, Box | Cylinder):
        return _with_edges(shape, fineness)
    directions, triangles = sphere(fineness)
    return directions * reach(shape, directions)[:, None], triangles


def _with_edges(shape: Box | Cylinder, fineness: int) -> tuple[np.ndarray, np.ndarray]:
    """A smaller box or cylinder and the radius of the edges on it: rings around the third axis from its lower to its
    upper face, which are fans. So edges are round lines, however fine they are, and faces are flat."""
    steps = max(fineness, 1)
    quarter = np.linspace(0.0, 0.5 * np.pi, steps + 1)
    up = np.concatenate([quarter - 0.5 * np.pi, quarter])
    if isinstance(shape, Box):
        half = shape.half[2]
        around = np.concatenate([quarter + 0.5 * np.pi * k for k in range(4)])
        signs = np.repeat([[1, 1], [-1, 1], [-1, -1], [1, -1]], steps + 1, axis=0)
        inner = signs * (np.asarray(shape.half)[:2] - shape.edge)
    else:
        half = shape.half
        around = np.linspace(0.0, 2.0 * np.pi, 4 * 2**fineness, endpoint=False)
        inner = (shape.radius - shape.edge) * np.column_stack([np.cos(around), np.sin(around)])
    out = np.column_stack([np.cos(around), np.sin(around)])
    rings = np.empty((len(up), len(around), 3))
    rings[..., :2] = inner + shape.edge * np.cos(up)[:, None, None] * out
    rings[..., 2] = (np.repeat([-1.0, 1.0], steps + 1) * (half - shape.edge) + shape.edge * np.sin(up))[:, None]
    points = np.concatenate([rings.reshape(-1, 3), [[0.0, 0.0, -half], [0.0, 0.0, half]]])
    at = np.arange(rings[..., 0].size).reshape(len(up), -1)
    low, high, after = at[:-1], at[1:], np.roll(at, -1, axis=1)
    strips = [(low, after[:-1], after[1:]), (low, after[1:], high)]
    ends = [
        (after[0], at[0], np.full_like(at[0], len(points) - 2)),
        (at[-1], after[-1], np.full_like(at[0], len(points) - 1)),
    ]
    triangles = np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in (*strips, *ends)])
    # Where the smaller box or cylinder has no length, points fall together.
    points, where = np.unique(np.round(points, 12), axis=0, return_inverse=True)
    triangles = where.reshape(-1)[triangles]
    return points, triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]


def reach(shape: Shape, directions: np.ndarray) -> np.ndarray:
    """How far [m] the surface of a shape lies from its centre in directions (n, 3), of length one: (n,), by halving.

    A super-ellipsoid is seen whole from its centre, so there is one surface in each direction.
    """
    low, high = np.zeros(len(directions)), np.full(len(directions), float(shape.bound))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        inside = shape.level(middle[:, None] * directions) < 0.0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return high


@cache
def sphere(fineness: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (nodes, 3) of length one and triangles (20 * 4^fineness, 3), outwards, of an icosahedron cut finer."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    points = np.array([
        [-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0], [0, -1, golden], [0, 1, golden],
        [0, -1, -golden], [0, 1, -golden], [golden, 0, -1], [golden, 0, 1], [-golden, 0, -1], [-golden, 0, 1],
    ])  # fmt: skip
    triangles = np.array([
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6],
        [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10],
        [8, 6, 7], [9, 8, 1],
    ])  # fmt: skip
    for _ in range(fineness):
        sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        edges, where = np.unique(sides, axis=0, return_inverse=True)
        middle = where.reshape(3, -1).T + len(points)
        points = np.concatenate([points, 0.5 * (points[edges[:, 0]] + points[edges[:, 1]])])
        a, b, c = triangles.T
        ab, bc, ca = middle.T
        triangles = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return points / np.linalg.norm(points, axis=1, keepdims=True), triangles
