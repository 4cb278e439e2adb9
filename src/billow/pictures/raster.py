"""Which triangle each pixel shows: a z-buffer. It needs neither display nor OpenGL, and the same scene gives the same
pixels everywhere.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar, spliced

NOTHING = -1
"""Triangle of a pixel that shows none."""
ROUNDING = 1e-9
"""How far outside a triangle a pixel may seem to be that lies on its edge: between neighbours there is no gap."""
SAME = 1e-6
"""Depths that differ by less are equal [pixels]: walls of one plane, whose last digits would speckle it."""


class Buffers(NamedTuple):
    """What each pixel of a picture (height, width) shows.

    triangle: int32, `NOTHING` for the background. depth: [pixels] towards the viewer, -inf there.
    """

    triangle: np.ndarray
    depth: np.ndarray


class Cut(NamedTuple):
    """A plane that cuts a picture. kept: distance of each node behind it [m], (nodes,): what is below zero is not
    drawn. solid: (n,) int, number of the solid that each triangle belongs to, -1 for none: where a solid is cut, its
    filled inside is seen. forward: [pixels] of depth from a place behind the plane to the plane, for each metre of
    `kept`; 0 for a plane that is seen from its edge."""

    kept: np.ndarray
    solid: np.ndarray
    forward: float


def rasterise(projected: np.ndarray, triangles: np.ndarray, width: int, height: int, cut: Cut | None = None) -> Buffers:
    """The nearest triangle at the middle of every pixel; of equally near ones, the first.

    projected: [pixels], (nodes, 3), as `Camera.project`. triangles: (n, 3), counter-clockwise seen from outside.
    """
    found = Buffers(np.full((height, width), NOTHING, np.int32), np.full((height, width), -np.inf))
    triangles, projected = np.ascontiguousarray(triangles, np.int64), np.ascontiguousarray(projected, float)
    if cut is None:
        _draw(np.arange(len(triangles)), triangles, projected, np.ones(len(projected)), found)
        return found
    _draw(np.flatnonzero(cut.solid < 0), triangles, projected, cut.kept, found)
    for solid in np.unique(cut.solid[cut.solid >= 0]):
        _draw_solid(np.flatnonzero(cut.solid == solid), triangles, projected, cut, found)
    return found


def _draw_solid(which: np.ndarray, triangles: np.ndarray, projected: np.ndarray, cut: Cut, found: Buffers) -> None:
    """Draw the triangles of a solid, and its inside in the plane where what is seen first of it is the inside."""
    height, width = found.depth.shape
    corners = projected[triangles[which], :2].reshape(-1, 2)
    low = np.clip(np.floor(corners.min(axis=0)).astype(int), 0, (width, height))
    high = np.clip(np.ceil(corners.max(axis=0)).astype(int) + 1, 0, (width, height))
    window = slice(low[1], high[1]), slice(low[0], high[0])
    alone = Buffers(
        *(np.full_like(array[window], empty) for array, empty in zip(found, (NOTHING, -np.inf), strict=True))
    )
    _draw(which, triangles, projected - [low[0], low[1], 0.0], cut.kept, alone)
    _fill(triangles, projected - [low[0], low[1], 0.0], cut.kept, cut.forward, alone)
    nearer = alone.depth > found.depth[window] + SAME
    for whole, own in zip(found, alone, strict=True):
        whole[window][nearer] = own[nearer]


@scalar
def _fill(triangles, projected, kept, forward, buffers):
    triangle, depth = buffers
    height, width = depth.shape
    filling = NOTHING  # one triangle stands for all of the inside, which has no edges
    for row in range(height):
        for column in range(width):
            t = triangle[row, column]
            if t == NOTHING:
                continue
            wa, wb, wc, doubled = weights_at(projected, triangles[t], column + 0.5, row + 0.5)
            if doubled > 0.0:  # the inside: y goes down
                a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
                depth[row, column] += forward * (wa * kept[a] + wb * kept[b] + wc * kept[c])
                filling = t if filling == NOTHING else filling
                triangle[row, column] = filling


@spliced
def weights_at(projected, corners, x, y):
    """Weights of a triangle's corners at a place [pixels], and twice its area [pixels^2], negative if its outside is
    seen."""
    a, b, c = corners[0], corners[1], corners[2]
    ax, ay, bx, by = projected[a, 0], projected[a, 1], projected[b, 0], projected[b, 1]
    cx, cy = projected[c, 0], projected[c, 1]
    doubled = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    wa = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / doubled
    wb = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / doubled
    return wa, wb, 1.0 - wa - wb, doubled


@scalar
def _draw(which, triangles, projected, kept, buffers):
    triangle_out, depth_out = buffers
    height, width = depth_out.shape
    for t in which:
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        if kept[a] < 0.0 and kept[b] < 0.0 and kept[c] < 0.0:
            continue
        ax, ay, bx, by = projected[a, 0], projected[a, 1], projected[b, 0], projected[b, 1]
        cx, cy = projected[c, 0], projected[c, 1]
        doubled = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not abs(doubled) > 1e-12:  # seen from the edge, or not a number
            continue
        first, last = max(0, int(np.floor(min(ay, by, cy)))), min(height, int(np.ceil(max(ay, by, cy))) + 1)
        left, right = max(0, int(np.floor(min(ax, bx, cx)))), min(width, int(np.ceil(max(ax, bx, cx))) + 1)
        a_right, b_right = (by - cy) / doubled, (cy - ay) / doubled  # weights of a and b, per pixel to the right
        clipped = not min(kept[a], kept[b], kept[c]) >= 0.0
        az, bz, cz = projected[a, 2], projected[b, 2], projected[c, 2]
        for row in range(first, last):
            x, y = left + 0.5, row + 0.5
            a_left = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / doubled
            b_left = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / doubled
            begin, end = _span(a_left, a_right, left, left, right)
            begin, end = _span(b_left, b_right, left, begin, end)
            for column in range(begin, end):
                wa, wb = a_left + (column - left) * a_right, b_left + (column - left) * b_right
                wc = 1.0 - wa - wb
                if min(wa, wb, wc) < -ROUNDING:
                    continue
                if clipped and wa * kept[a] + wb * kept[b] + wc * kept[c] < 0.0:
                    continue
                depth = wa * az + wb * bz + wc * cz
                if depth > depth_out[row, column] + SAME:
                    depth_out[row, column], triangle_out[row, column] = depth, t


@scalar
def _span(weight, slope, left, begin, end):
    """The columns from `begin` to `end` where a weight may not be negative; it is `weight` in column `left`, and grows
    by `slope` from one to the next."""
    if slope > 0.0:
        return max(begin, left + int(max(min(-weight / slope, 1e9), 0.0)) - 1), end
    if slope < 0.0:
        return begin, min(end, left + int(max(min(-weight / slope, 1e9), -2.0)) + 2)
    return (begin, end) if weight >= -ROUNDING else (begin, begin)
