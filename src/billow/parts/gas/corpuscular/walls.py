"""Walls as the flight sees them: triangles between chambers, and the space each of them sweeps in a step."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.geometry.chambers import Chambers
from billow.geometry.triangle import cross, sides

SWEPT_NUMBERS = 19
"""Numbers per triangle that `sweep` fills in."""

FLATTEST = 1e-6
"""Twice a triangle's area over its longest edge squared, below which rounding errors dominate its weights."""

WEIGHT_SLACK = 1e-6
"""Slack of the tests against edges; rounding errors stay below 1e-6 of it for coordinates of metres and edges of
millimetres at `FLATTEST`."""


LEAST_DEPARTURE = 1e-6
"""Way [m] by which a particle must leave a triangle in a step for it to be out of the question, whatever is rounded."""


class Walls(NamedTuple):
    """Triangles between chambers, as the flight needs them.

    nodes: (triangles, 3) uint32, each triangle's nodes in ascending order. corner: (triangles, 3) uint8, which corner
    of the triangle each of them is. orientation: (triangles,), +1 if the ascending order has the sense of the triangle,
    else -1. behind, ahead: (triangles,) int32, chamber on the inner side and on the outer side (along the normal), or
    OUTSIDE (-1). group: (chambers,) int32, the same for chambers that openings join. group_behind, group_ahead:
    (triangles,) int32, groups on both sides, or OUTSIDE.
    """

    nodes: np.ndarray
    corner: np.ndarray
    orientation: np.ndarray
    behind: np.ndarray
    ahead: np.ndarray
    group: np.ndarray
    group_behind: np.ndarray
    group_ahead: np.ndarray

    @classmethod
    def build(cls, triangles: np.ndarray, chambers: Chambers, group: np.ndarray | None = None) -> Walls:
        """Walls from (triangles, 3) node indices; without `group` no chambers are joined."""
        group = np.arange(chambers.count, dtype=np.int32) if group is None else group
        joined = chambers.joined(group)
        corner = np.argsort(triangles, axis=1, kind="stable")
        nodes = np.take_along_axis(triangles, corner, axis=1)
        even = (corner[:, 1] - corner[:, 0]) % 3 == 1
        return cls(
            np.ascontiguousarray(nodes, dtype=np.uint32),
            corner.astype(np.uint8),
            np.where(even, 1.0, -1.0),
            np.ascontiguousarray(chambers.behind, dtype=np.int32),
            np.ascontiguousarray(chambers.ahead, dtype=np.int32),
            np.ascontiguousarray(group, dtype=np.int32),
            np.ascontiguousarray(joined.behind, dtype=np.int32),
            np.ascontiguousarray(joined.ahead, dtype=np.int32),
        )


@kernel
def sweep(n, nodes, orientation, start, end, swept_out):
    """Per triangle, what `may_cross` and `stays_away` need: unit normal at the start, height of its plane, lowest and
    highest end of a corner above that plane; gradient and offset of the weights of its first two nodes at the start,
    lowest value of the three weights at the end of any corner; by how much the pieces of its motion differ in way along
    the normal [m], and in slope."""
    for t in prange(n):
        i, j, k = nodes[t, 0], nodes[t, 1], nodes[t, 2]
        ux, uy, uz, wx, wy, wz = sides(start, i, j, k)
        nx, ny, nz = cross(ux, uy, uz, wx, wy, wz)
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        scale = orientation[t] / length if length > 0.0 else 0.0  # without a plane nothing is rejected
        nx, ny, nz = scale * nx, scale * ny, scale * nz
        height = nx * start[i, 0] + ny * start[i, 1] + nz * start[i, 2]
        a = nx * end[i, 0] + ny * end[i, 1] + nz * end[i, 2]
        b = nx * end[j, 0] + ny * end[j, 1] + nz * end[j, 2]
        c = nx * end[k, 0] + ny * end[k, 1] + nz * end[k, 2]
        swept_out[t, 0], swept_out[t, 1], swept_out[t, 2], swept_out[t, 3] = nx, ny, nz, height
        swept_out[t, 4], swept_out[t, 5] = min(a, b, c), max(a, b, c)
        # Gradients of the weights of j, k and i: the opposite edge, turned by a right angle in the plane.
        longest = max(ux * ux + uy * uy + uz * uz, wx * wx + wy * wy + wz * wz)
        turn = orientation[t] / length if length > FLATTEST * longest else 0.0
        jx, jy, jz = turn * (wy * nz - wz * ny), turn * (wz * nx - wx * nz), turn * (wx * ny - wy * nx)
        kx, ky, kz = turn * (ny * uz - nz * uy), turn * (nz * ux - nx * uz), turn * (nx * uy - ny * ux)
        ix, iy, iz = -jx - kx, -jy - ky, -jz - kz
        of_i = 1.0 - (ix * start[i, 0] + iy * start[i, 1] + iz * start[i, 2])
        of_j = 0.0 - (jx * start[i, 0] + jy * start[i, 1] + jz * start[i, 2])
        low_i = low_j = low_k = 1.0
        for corner in (i, j, k):
            x, y, z = end[corner, 0], end[corner, 1], end[corner, 2]
            at_i, at_j = ix * x + iy * y + iz * z + of_i, jx * x + jy * y + jz * z + of_j
            low_i, low_j, low_k = min(low_i, at_i), min(low_j, at_j), min(low_k, 1.0 - at_i - at_j)
        swept_out[t, 6], swept_out[t, 7], swept_out[t, 8], swept_out[t, 9] = ix, iy, iz, of_i
        swept_out[t, 10], swept_out[t, 11], swept_out[t, 12], swept_out[t, 13] = jx, jy, jz, of_j
        swept_out[t, 14], swept_out[t, 15], swept_out[t, 16] = low_i, low_j, low_k
        # The pieces (`piece_normal`) as graphs over the plane at the start: normals of unit height.
        dux, duy, duz, dwx, dwy, dwz = sides(end, i, j, k)
        way_i, slope_i = _graph(nx, ny, nz, dux, duy, duz, dwx, dwy, dwz, orientation[t], start, end, i)
        dwx, dwy, dwz = dwx - dux, dwy - duy, dwz - duz
        way_j, slope_j = _graph(nx, ny, nz, ux, uy, uz, dwx, dwy, dwz, orientation[t], start, end, j)
        way_k = c - (nx * start[k, 0] + ny * start[k, 1] + nz * start[k, 2])
        swept_out[t, 17] = max(way_i, way_j, way_k) - min(way_i, way_j, way_k)
        swept_out[t, 18] = 2.0 * max(slope_i, slope_j)


@scalar
def _graph(nx, ny, nz, ux, uy, uz, wx, wy, wz, orientation, start, end, mover):
    """A piece with sides u and w as a graph over the plane with unit normal n: its way along n in the step [m] at one
    place of the plane, and its slope; infinitely steep if it is no graph."""
    px, py, pz = cross(ux, uy, uz, wx, wy, wz)
    height = nx * px + ny * py + nz * pz
    if not orientation * height > 0.0:
        return 0.0, np.inf
    px, py, pz = px / height, py / height, pz / height
    way = (
        px * (end[mover, 0] - start[mover, 0]) + py * (end[mover, 1] - start[mover, 1])
        + pz * (end[mover, 2] - start[mover, 2])
    )  # fmt: skip
    return way, math.sqrt((px - nx) ** 2 + (py - ny) ** 2 + (pz - nz) ** 2)


@scalar
def stays_away(swept, t, leaves, way):
    """Whether a particle cannot meet triangle t again in this step after it was reflected by one of its pieces.

    leaves: by how much that piece and the particle part along the piece's normal in a whole step [m]; way: length of
    the particle's path in a whole step [m]. Over any other piece they part by as much, but for what the pieces differ
    in way and slope: where that is less, the distance along the normal at the start only grows.
    """
    return leaves > swept[t, 17] + swept[t, 18] * way + LEAST_DEPARTURE


@scalar
def may_cross(swept, t, x0, y0, z0, x1, y1, z1, standoff):
    """Whether the line from (x0, y0, z0) at the start of a step to (x1, y1, z1) at its end may cross triangle t.

    Never false where `crossing` finds something: at any time the triangle lies in the hull of its corners, these lie
    between the lines in time from their extremes at the start to those at the end, and the tests have slack: standoff
    [m] in height, WEIGHT_SLACK in weights. First comes the time between the planes of the lowest and of the highest
    corner, then the three edges at both ends of that time.
    """
    nx, ny, nz, height = swept[t, 0], swept[t, 1], swept[t, 2], swept[t, 3]
    before = nx * x0 + ny * y0 + nz * z0 - height
    later = nx * x1 + ny * y1 + nz * z1
    above_low, above_high = later - swept[t, 4], later - swept[t, 5]
    early, late = 0.0, 1.0
    if before < -standoff:
        if above_low < -standoff:
            return False
        early = (-standoff - before) / (above_low - before)
    elif above_low < -standoff:
        late = (before + standoff) / (before - above_low)
    if before > standoff:
        if above_high > standoff:
            return False
        early = (before - standoff) / (before - above_high)
    elif above_high > standoff:
        late = min(late, (standoff - before) / (above_high - before))
    ax, ay, az, a = swept[t, 6], swept[t, 7], swept[t, 8], swept[t, 9]
    bx, by, bz, b = swept[t, 10], swept[t, 11], swept[t, 12], swept[t, 13]
    a0, a1 = ax * x0 + ay * y0 + az * z0 + a, ax * x1 + ay * y1 + az * z1 + a
    b0, b1 = bx * x0 + by * y0 + bz * z0 + b, bx * x1 + by * y1 + bz * z1 + b
    c0, c1 = 1.0 - a0 - b0, 1.0 - a1 - b1
    # Growth of each weight in the step relative to that of the lowest corner, whose weight is zero at the start.
    a1, b1, c1 = a1 - swept[t, 14] - a0, b1 - swept[t, 15] - b0, c1 - swept[t, 16] - c0
    return (
        min(
            max(a0 + early * a1, a0 + late * a1),
            max(b0 + early * b1, b0 + late * b1),
            max(c0 + early * c1, c0 + late * c1),
        )
        >= -WEIGHT_SLACK
    )
