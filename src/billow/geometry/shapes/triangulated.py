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
    directions, triangles = sphere(fineness)
    if isinstance(shape, Box | Cylinder):  # as many triangles across a thin side as across a wide one
        directions = directions * (shape.half if isinstance(shape, Box) else [shape.radius, shape.radius, shape.half])
        directions /= np.linalg.norm(directions, axis=1)[:, None]
    return directions * reach(shape, directions)[:, None], triangles


def reach(shape: Shape, directions: np.ndarray) -> np.ndarray:
    """How far [m] the surface of a shape lies from its centre in directions (n, 3), of length one: (n,), by halving.

    Every such shape but a mesh is seen whole from its centre, so there is one surface in each direction.
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
