"""Boxes in whole steps of a grid, three sides in one integer each: whether two overlap is two subtractions and one
comparison (docs/theory.md, Flight).

A box is a pair of integers: 20 bits each for its far sides, and 20 bits each for its near sides counted from the other
end, each below a bit that is set. Subtracting the near sides of another box from the one, and its far sides, counted
likewise, from the other, leaves all six set bits as they are only where no side lies beyond its opposite one.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.geometry.search_grid import SearchGrid

LAST_STEP = 2**20 - 1

_LAST = np.uint64(LAST_STEP)
_SECOND, _THIRD = np.uint64(21), np.uint64(42)
SET_BITS = np.uint64(1 << 20 | 1 << 41 | 1 << 62)

SLACK = 1e-9
"""By which boxes of triangles are larger on each side [m], lest rounding part what touches."""


@scalar
def step_of(value, origin, per_metre):
    """Number of the step, from an origin, in which a coordinate [m] lies; the first and the last hold all beyond.

    It never falls as the coordinate grows, so that boxes that overlap also do so in steps. NaN is in the first.
    """
    place = (value - origin) * per_metre
    if not place > 0.0:
        return np.uint64(0)
    if place >= LAST_STEP:
        return _LAST
    return np.uint64(place)


@scalar
def packed(x, y, z):
    """Three steps in one integer."""
    return x | (y << _SECOND) | (z << _THIRD)


@scalar
def from_the_end(x, y, z):
    """Three steps in one integer, counted from the last one."""
    return (_LAST - x) | ((_LAST - y) << _SECOND) | ((_LAST - z) << _THIRD)


def steps_per_metre(grid: SearchGrid) -> float:
    """So that the whole grid is within LAST_STEP [1/m]."""
    return LAST_STEP / (grid.cell * float(grid.counts.max()))


@kernel
def pack_boxes(n, nodes, start, end, origin, per_metre, boxes_out):
    """Boxes of triangles that move from start to end [m], (nodes, 3), into (triangles, 2) uint64, with their bits set.

    nodes: (triangles, 3). origin: [m], (3,).
    """
    ox, oy, oz = origin[0], origin[1], origin[2]
    for t in prange(n):
        i, j, k = nodes[t, 0], nodes[t, 1], nodes[t, 2]
        low_x, high_x = _range(start, end, i, j, k, 0)
        low_y, high_y = _range(start, end, i, j, k, 1)
        low_z, high_z = _range(start, end, i, j, k, 2)
        boxes_out[t, 0] = SET_BITS | packed(
            step_of(high_x, ox, per_metre), step_of(high_y, oy, per_metre), step_of(high_z, oz, per_metre)
        )
        boxes_out[t, 1] = SET_BITS | from_the_end(
            step_of(low_x, ox, per_metre), step_of(low_y, oy, per_metre), step_of(low_z, oz, per_metre)
        )


@scalar
def _range(start, end, i, j, k, axis):
    a, b, c = start[i, axis], start[j, axis], start[k, axis]
    d, e, f = end[i, axis], end[j, axis], end[k, axis]
    return min(a, b, c, d, e, f) - SLACK, max(a, b, c, d, e, f) + SLACK
