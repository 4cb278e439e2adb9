"""How deep points lie in a chamber: how often its surface, however crumpled, goes round them.

A ray from the point leaves the chamber once more than it enters it, for each time the surface goes round; the winding
number is the sum of these passages with their sign. Rays run along the thinnest extent of the bag, and whether one
meets a triangle is decided as for `points_inside`: none slips between two triangles, none meets both.
"""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar
from billow.parts.gas.corpuscular.inside_points import meet


def depths(
    points: np.ndarray, chamber: np.ndarray, triangles: np.ndarray, positions: np.ndarray, behind: np.ndarray,
    ahead: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """How often the surface of its chamber goes round each point, (points,) int32: 0 outside, 1 inside, 2 where two
    portions of the bag overlap, negative where it is turned inside out.

    points [m] (points, 3), one that is not a number is outside; chamber (points,). triangles (n, 3), positions [m]
    (nodes, 3); behind, ahead: (n,) int32, chamber on the inner side of each triangle and on its outer side.
    """
    low, extent = positions.min(axis=0), np.ptp(positions, axis=0)
    thin = int(np.argmin(extent))
    order = np.array([(thin + 1) % 3, (thin + 2) % 3, thin])  # cyclic: keeps the sense of orientation
    turned = np.ascontiguousarray((positions - low)[:, order])
    width, depth = extent[order[:2]]
    field = math.sqrt(max(width * depth, 1e-300) / len(triangles))
    shape = np.array([int(width / field) + 1, int(depth / field) + 1])
    corners = triangles.astype(np.int64)
    start, listed = _list_by_field(corners, turned, field, shape)
    found = np.zeros(len(points), np.int32)
    _depths(
        len(points),
        points,
        low,
        order,
        np.asarray(chamber),
        corners,
        turned,
        behind,
        ahead,
        field,
        shape,
        start,
        listed,
        found,
    )
    return found


@scalar
def _list_by_field(triangles, positions, field, shape):
    """Triangles over each field of the plane across the rays, those of each in ascending order: start, listed."""
    start = np.zeros(shape[0] * shape[1] + 2, np.int64)
    listed = np.empty(0, np.int64)
    for filling in range(2):
        for t in range(len(triangles)):
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            x0 = int(min(positions[a, 0], positions[b, 0], positions[c, 0]) / field)
            x1 = int(max(positions[a, 0], positions[b, 0], positions[c, 0]) / field)
            y0 = int(min(positions[a, 1], positions[b, 1], positions[c, 1]) / field)
            y1 = int(max(positions[a, 1], positions[b, 1], positions[c, 1]) / field)
            for x in range(x0, x1 + 1):
                for y in range(y0, y1 + 1):
                    place = x * shape[1] + y
                    if filling == 0:
                        start[place + 2] += 1
                    else:
                        listed[start[place + 1]] = t
                        start[place + 1] += 1
        if filling == 0:
            for place in range(len(start) - 1):
                start[place + 1] += start[place]
            listed = np.empty(start[-1], np.int64)
    return start, listed


@kernel
def _depths(
    n, points, low, order, chamber, triangles, positions, behind, ahead, field, shape, start, listed, found_out
):  # fmt: skip
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        for p in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            home = chamber[p]
            x, y = points[p, order[0]] - low[order[0]], points[p, order[1]] - low[order[1]]
            z = points[p, order[2]] - low[order[2]]
            if not (0.0 <= x < field * shape[0] and 0.0 <= y < field * shape[1] and abs(z) < np.inf):
                continue
            place = int(x / field) * shape[1] + int(y / field)
            depth = 0
            for entry in range(start[place], start[place + 1]):
                t = listed[entry]
                left = (1 if behind[t] == home else 0) - (1 if ahead[t] == home else 0)
                if left == 0:
                    continue
                a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
                sense, _ = meet(a, b, c, positions, x, y)
                if sense == 0:
                    continue
                # Above the point, if the point is behind the triangle and the ray passes along the normal, or neither.
                wx, wy, wz = positions[a, 0] - x, positions[a, 1] - y, positions[a, 2] - z
                ux, uy, uz = (
                    positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1],
                    positions[b, 2] - positions[a, 2],
                )  # fmt: skip
                vx, vy, vz = (
                    positions[c, 0] - positions[a, 0], positions[c, 1] - positions[a, 1],
                    positions[c, 2] - positions[a, 2],
                )  # fmt: skip
                behind_it = (
                    (uy * vz - uz * vy) * wx + (uz * vx - ux * vz) * wy + (ux * vy - uy * vx) * wz
                ) > 0.0  # fmt: skip
                if behind_it == (sense > 0):
                    depth += sense * left
            found_out[p] = depth
