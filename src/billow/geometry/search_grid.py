"""Which triangles can be near a point: a uniform grid whose cells list the triangles within `margin` of them.

The lists stay valid until a node has moved further than the margin; over what is left of it (`reach`) a flight needs no
neighbouring cells, and over `clear` cells more where those around are empty. Coordinates are clipped to the grid:
outside it there is no triangle within `margin`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar, team

MOST_CELLS = 1 << 19
"""Largest number of cells (2 MB of offsets); a wider scene gets larger cells."""

MOST_CLEAR = 7
"""Most empty cells around a cell that are counted: further than a flight goes in a step."""

SPENT = 0.5
"""Part of the margin that node motion may use up before the lists are rebuilt."""


class Fineness(NamedTuple):
    """cell_in_edges: edge of a cell in mean triangle edges. margin_in_cells: margin in cells."""

    cell_in_edges: float
    margin_in_cells: float


FINE, USUAL, COARSE = Fineness(0.6, 0.35), Fineness(0.8, 0.5), Fineness(1.25, 0.4)
"""Measured: benchmarks/particles.py and docs/theory.md, Flight."""


class SearchGrid(NamedTuple):
    """Lists of triangles per cell.

    origin: lower corner [m], (3,). cell: edge [m]. counts: cells per axis, (3,) int64. The triangles of cell c are
    listed[first[c] : first[c + 1]], ascending; first: (cells + 1,) int32, listed: (n,) uint32. clear: (cells,) uint8,
    how many cells away the nearest one with a triangle is, along the axis along which it is furthest; at most
    MOST_CLEAR. margin: [m]. built_at: node positions [m], (nodes, 3), from which motion is counted. reach: what is left
    of the margin [m].
    """

    origin: np.ndarray
    cell: float
    counts: np.ndarray
    first: np.ndarray
    listed: np.ndarray
    clear: np.ndarray
    margin: float
    built_at: np.ndarray
    reach: float

    @classmethod
    def build(
        cls, triangles: np.ndarray, start: np.ndarray, end: np.ndarray, least_margin: float = 0.0,
        fineness: Fineness = USUAL,
    ) -> SearchGrid:  # fmt: skip
        """Lists for triangles (n, 3) that move from `start` to `end` [m], (nodes, 3); least_margin: [m]."""
        sides = end.take(triangles[:, 1], axis=0) - end.take(triangles[:, 0], axis=0)
        edge = math.sqrt(float(np.mean(np.sum(sides**2, axis=1))))
        (low, high), (low_end, high_end) = box_around(start), box_around(end)
        low, high = np.minimum(low, low_end), np.maximum(high, high_end)
        cell = fineness.cell_in_edges * edge
        while True:
            margin = max(fineness.margin_in_cells * cell, least_margin)
            counts = np.ceil((high - low + 2.0 * margin) / cell).astype(np.int64) + 1
            if np.prod(counts.astype(float)) <= MOST_CELLS:
                break
            cell *= 1.1
        # Half a cell of free space all around, so that rounding cannot put a triangle off the grid.
        origin = low - margin - 0.5 * (counts * cell - (high - low + 2.0 * margin))
        n = len(triangles)
        spans = np.empty((n, 6), np.int32)
        _find_spans(n, triangles, start, end, origin, cell, counts, margin, spans)
        first, listed = cell_lists(spans, counts)
        return cls(origin, cell, counts, first, listed, cells_to_lists(first, counts), margin, end.copy(), margin)

    def follow(
        self, triangles: np.ndarray, start: np.ndarray, end: np.ndarray, fineness: Fineness = USUAL
    ) -> SearchGrid:
        """The grid for a step from `start` to `end`: with the same lists if they are still valid, else a new one of the
        given fineness."""
        spent = largest_move(self.built_at, end)
        if spent > SPENT * self.margin:
            return SearchGrid.build(triangles, start, end, fineness=fineness)
        return self._replace(reach=self.margin - spent)

    def cells_of(self, position: np.ndarray) -> np.ndarray:
        """Cell index of each point, (points,) int64; points off the grid count to its nearest cell."""
        place = np.nan_to_num((position - self.origin) * (1.0 / self.cell))
        x, y, z = np.clip(place, 0, self.counts - 1).astype(np.int32).T
        return (x * self.counts[1] + y) * self.counts[2] + z


def cell_lists(spans: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles by cell, first and listed as in SearchGrid.

    spans: (n, 6) int32, cells along x, y and z that each triangle touches: from, to (inclusive). counts: cells of each
    axis, (3,).
    """
    first, n = np.zeros(int(np.prod(counts)) + 1, dtype=np.int32), len(spans)
    _list(n, team(n), spans, counts, first[1:], np.empty(0, np.uint32))
    np.cumsum(first, out=first)
    listed = np.empty(int(first[-1]), dtype=np.uint32)
    _list(n, team(n), spans, counts, first[:-1].copy(), listed)
    return first, listed


def cells_to_lists(first: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """How far the nearest cell with a list is from each cell, in cells, (cells,) uint8, as `clear` of SearchGrid.

    first: as there. counts: cells of each axis, (3,).
    """
    nx, ny, nz = counts
    away = np.empty(len(first) - 1, np.uint8)
    _along_z(len(away), nz, first, away)
    for across, cells in ((ny, nz), (nx, ny * nz)):  # along y, along x
        before = away.reshape(-1, cells)
        nearer = np.empty_like(before)
        _spread(before.size, across, before, nearer)
        away = nearer
    return away.ravel()


def box_around(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of the box around positions [m], (n, 3)."""
    columns = np.ascontiguousarray(positions.T)  # a reduction along rows of three is ten times slower
    return columns.min(axis=1), columns.max(axis=1)


def largest_move(before: np.ndarray, after: np.ndarray) -> float:
    """How far the node that moved most has moved [m]; before, after: positions [m], (nodes, 3)."""
    n = len(after)
    largest = np.empty(-(-n // CHUNK))
    _largest_move(n, before, after, largest)
    return math.sqrt(largest.max())


@scalar
def clipped_cell(value, origin, per_cell, count):
    """Cell along one axis, clipped to the grid; NaN goes to cell 0. per_cell: 1 / cell edge [1/m]."""
    place = (value - origin) * per_cell
    if not place > 0.0:
        return 0
    if place >= count:
        return count - 1
    return int(place)


@kernel
def _find_spans(n, triangles, start, end, origin, cell, counts, margin, spans_out):
    """The spans of moving triangles with their margin, as in `cell_lists`."""
    for t in prange(n):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for k in range(3):
            low = min(start[a, k], start[b, k], start[c, k], end[a, k], end[b, k], end[c, k]) - margin
            high = max(start[a, k], start[b, k], start[c, k], end[a, k], end[b, k], end[c, k]) + margin
            spans_out[t, 2 * k] = clipped_cell(low, origin[k], 1.0 / cell, counts[k])
            spans_out[t, 2 * k + 1] = clipped_cell(high, origin[k], 1.0 / cell, counts[k])


@kernel
def _list(n, parts, spans, counts, next_free, listed_out):
    """Add each triangle to the cells it touches; into an empty listed_out only count, (cells,) in next_free. Each part
    does its own cells."""
    for part in prange(parts):
        begin, end = part * counts[0] // parts, (part + 1) * counts[0] // parts
        for t in range(n):
            for x in range(max(begin, spans[t, 0]), min(end, spans[t, 1] + 1)):
                for y in range(spans[t, 2], spans[t, 3] + 1):
                    row = (x * counts[1] + y) * counts[2]
                    for z in range(spans[t, 4], spans[t, 5] + 1):
                        if len(listed_out) > 0:
                            listed_out[next_free[row + z]] = t
                        next_free[row + z] += 1


@kernel
def _along_z(n, cells, first, away_out):
    """From each of n cells to the nearest one of its row that lists a triangle; rows of some cells each."""
    most, one = np.uint8(MOST_CLEAR), np.uint8(1)
    for row in prange(n // cells):
        begin, away = row * cells, most
        for c in range(begin, begin + cells):
            away = np.uint8(0) if first[c + 1] > first[c] else min(most, np.uint8(away + one))
            away_out[c] = away
        for c in range(begin + cells - 1, begin - 1, -1):
            away = min(away_out[c], np.uint8(away + one))
            away_out[c] = away


@kernel
def _spread(n, across, away, nearer_out):
    """The same of n cells along one more axis, which rows, (rows, cells), go across so many at a time: the least of
    max(|j|, away of row j further on)."""
    for row in prange(len(away)):
        here = row % across
        for c in range(away.shape[1]):
            nearer_out[row, c] = away[row, c]
        for j in range(max(-here, -MOST_CLEAR), min(across - here, MOST_CLEAR + 1)):
            there, steps = np.uint64(row + j), np.uint8(abs(j))
            for c in range(np.uint64(away.shape[1])):  # unsigned, or it does not vectorise: a hundred times slower
                nearer_out[row, c] = min(nearer_out[row, c], max(steps, away[there, c]))


@kernel
def _largest_move(n, before, after, largest_out):
    chunks = (n + CHUNK - 1) // CHUNK
    for chunk in prange(chunks):
        largest = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            dx, dy, dz = after[i, 0] - before[i, 0], after[i, 1] - before[i, 1], after[i, 2] - before[i, 2]
            largest = max(largest, dx * dx + dy * dy + dz * dz)
        largest_out[chunk] = largest
