"""Walls as the flight sees them: triangles between chambers, and the room each of them takes in a step."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.compiled import kernel, scalar

SWEPT_NUMBERS = 12
"""Numbers per triangle that `sweep` fills in."""


@dataclass(frozen=True)
class Walls:
    """Triangles between chambers, as the flight needs them.

    nodes: (triangles, 3) uint32, each triangle's nodes in ascending order. corner: (triangles, 3) uint8, which corner
    of the triangle each of them is. orientation: (triangles,), +1 if the ascending order turns as the triangle does,
    else -1. behind, ahead: (triangles,) int32, chamber on the inner side and on the outer side (along the normal);
    OUTSIDE (-1) where there is none (geometry/chambers.py).
    """

    nodes: np.ndarray
    corner: np.ndarray
    orientation: np.ndarray
    behind: np.ndarray
    ahead: np.ndarray

    @classmethod
    def build(cls, triangles: np.ndarray, behind: np.ndarray, ahead: np.ndarray) -> Walls:
        """Walls from (triangles, 3) node indices and the chambers on both sides, (triangles,) each."""
        corner = np.argsort(triangles, axis=1, kind="stable")
        nodes = np.take_along_axis(triangles, corner, axis=1)
        even = (corner[:, 1] - corner[:, 0]) % 3 == 1
        return cls(
            np.ascontiguousarray(nodes, dtype=np.uint32),
            corner.astype(np.uint8),
            np.where(even, 1.0, -1.0),
            np.ascontiguousarray(behind, dtype=np.int32),
            np.ascontiguousarray(ahead, dtype=np.int32),
        )


@kernel
def sweep(n, nodes, orientation, start, end, swept_out):
    """Per triangle: box of its motion (low x y z, high x y z); unit normal at the start, height of its plane, lowest
    and highest end of a corner above that plane."""
    for t in prange(n):
        i, j, k = nodes[t, 0], nodes[t, 1], nodes[t, 2]
        for axis in range(3):
            a, b, c = start[i, axis], start[j, axis], start[k, axis]
            d, e, f = end[i, axis], end[j, axis], end[k, axis]
            swept_out[t, axis] = min(a, b, c, d, e, f)
            swept_out[t, 3 + axis] = max(a, b, c, d, e, f)
        ux, uy, uz = start[j, 0] - start[i, 0], start[j, 1] - start[i, 1], start[j, 2] - start[i, 2]
        wx, wy, wz = start[k, 0] - start[i, 0], start[k, 1] - start[i, 1], start[k, 2] - start[i, 2]
        nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        scale = orientation[t] / length if length > 0.0 else 0.0  # without a plane nothing is rejected by it
        nx, ny, nz = scale * nx, scale * ny, scale * nz
        height = nx * start[i, 0] + ny * start[i, 1] + nz * start[i, 2]
        a = nx * end[i, 0] + ny * end[i, 1] + nz * end[i, 2]
        b = nx * end[j, 0] + ny * end[j, 1] + nz * end[j, 2]
        c = nx * end[k, 0] + ny * end[k, 1] + nz * end[k, 2]
        swept_out[t, 6], swept_out[t, 7], swept_out[t, 8], swept_out[t, 9] = nx, ny, nz, height
        swept_out[t, 10], swept_out[t, 11] = min(a, b, c), max(a, b, c)


@scalar
def wall_velocity(nodes, t, wi, wj, wk, start, end, rate):
    """Velocity [m/s] of the place with weights wi, wj, wk on triangle t; rate: 1 / duration of the step [1/s]."""
    i, j, k = nodes[t, 0], nodes[t, 1], nodes[t, 2]
    return (
        rate * (wi * (end[i, 0] - start[i, 0]) + wj * (end[j, 0] - start[j, 0]) + wk * (end[k, 0] - start[k, 0])),
        rate * (wi * (end[i, 1] - start[i, 1]) + wj * (end[j, 1] - start[j, 1]) + wk * (end[k, 1] - start[k, 1])),
        rate * (wi * (end[i, 2] - start[i, 2]) + wj * (end[j, 2] - start[j, 2]) + wk * (end[k, 2] - start[k, 2])),
    )
