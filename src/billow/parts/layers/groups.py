"""Groups of eight neighbours, groups of eight of these, and so on: boxes around them lead a search.

Neighbours are told by the mesh, not by where they lie: groups of fabric that is folded stay whole when it opens. The
hops of a node from some landmarks, far from each other, serve as its coordinates; items are sorted by halves along the
longest extent of these.
"""

from __future__ import annotations

import numpy as np

from billow.base.compiled import kernel, scalar
from billow.geometry.neighbours import GROUP
from billow.parts.layers.rings import Rings

LANDMARKS = 6

OUTWARD = 2e-7
"""Part of a coordinate by which boxes are widened, for single precision."""


def landmark_hops(rings: Rings) -> np.ndarray:
    """Coordinates of nodes in the mesh: the piece of fabric, and hops from landmarks, (nodes, 1 + LANDMARKS)."""
    n = len(rings.rim_begin) - 1
    piece, hops = np.full(n, -1, np.int64), np.full((n, 1 + LANDMARKS), 0.0)
    pieces = 0
    for first in range(n):
        if piece[first] < 0:
            _spread(rings.rim_begin, rings.rim, first, pieces, piece, np.empty(n))
            pieces += 1
    hops[:, 0] = piece * float(4 * n)
    nearest, landmark = np.full(n, np.inf), 0
    for k in range(LANDMARKS):
        away = np.full(n, float(n))
        _spread(rings.rim_begin, rings.rim, landmark, -2 - k, piece, away)
        hops[:, 1 + k] = away
        nearest = np.minimum(nearest, away)
        landmark = int(np.argmax(nearest))
    return hops


@scalar
def _spread(begin, neighbours, first, mark, mark_out, hops_out):
    """Mark all nodes of one piece of fabric; their hops from the first."""
    open_ends, last = np.empty(len(mark_out), np.int64), 1
    open_ends[0], mark_out[first], hops_out[first] = first, mark, 0.0
    i = 0
    while i < last:
        node = open_ends[i]
        for k in range(begin[node], begin[node + 1]):
            other = neighbours[k]
            if mark_out[other] != mark:
                mark_out[other], hops_out[other] = mark, hops_out[node] + 1.0
                open_ends[last] = other
                last += 1
        i += 1


def level_starts(items: int) -> np.ndarray:
    """Where the boxes of items begin, of groups, and of groups of groups, and the end; each fill whole groups."""
    groups = -(-max(1, items) // GROUP)
    counts = [GROUP * -(-count // GROUP) for count in (items, groups, -(-groups // GROUP))]
    return np.cumsum([0, *counts])


def boxes_of_groups(sides: np.ndarray, starts: np.ndarray) -> None:
    """Fill in the boxes of groups, those of items being there; sides: low and high coordinates, (6, boxes)."""
    for level in (1, 2):
        count = (starts[level] - starts[level - 1]) // GROUP
        _enclose(count, sides, starts[level - 1], starts[level])
        sides[:3, starts[level] + count : starts[level + 1]] = np.inf
        sides[3:, starts[level] + count : starts[level + 1]] = -np.inf


@kernel
def _enclose(n, sides, first, into):
    for i in range(n):
        for k in range(3):
            low, high = sides[k, first + GROUP * i], sides[3 + k, first + GROUP * i]
            for j in range(first + GROUP * i + 1, first + GROUP * (i + 1)):
                low, high = min(low, sides[k, j]), max(high, sides[3 + k, j])
            sides[k, into + i], sides[3 + k, into + i] = low, high
