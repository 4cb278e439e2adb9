"""Cells: particles that may collide with each other, sorted side by side (docs/theory.md, Collisions)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar, team
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.random_numbers import stream, uniform

PARTNERS = 9.0
"""Mean number of other particles in a particle's cell."""

ATTEMPTS = 12
"""Most sorts until the cell size fits, if it is off by more than a factor of two in partners (at the start)."""

CELLS_PER_PARTICLE = 2
"""Largest number of cells of a chamber per particle: in a box that is mostly empty the cells stay coarser."""

SHIFT = 0x5348494654
"""Names the random numbers of the grid's shift."""


@dataclass
class Cells:
    """Particles by cell: those of cell c are order[start[c]:start[c + 1]].

    size: cell edge [m]; partners: mean number of other particles in a cell at the last sort [-]; both (chambers,), all
    that a sort needs from the one before. origin [m] (chambers, 3) and shape (chambers, 3) int64 of the grids; first:
    (chambers + 1,) int64, where each chamber's cells begin; cell index = first + (ix shape_y + iy) shape_z + iz. start:
    (at least cells + 2,) int32. order, cell: (capacity,) int32; after a sort, order is ascending within each cell.
    """

    size: np.ndarray
    partners: np.ndarray
    origin: np.ndarray
    shape: np.ndarray
    first: np.ndarray
    start: np.ndarray
    order: np.ndarray
    cell: np.ndarray

    @classmethod
    def of(cls, chambers: int) -> Cells:
        """No cells yet."""
        return cls(
            np.zeros(chambers), np.zeros(chambers), np.zeros((chambers, 3)), np.zeros((chambers, 3), np.int64),
            np.zeros(chambers + 1, np.int64), np.zeros(2, np.int32), np.zeros(0, np.int32), np.zeros(0, np.int32),
        )  # fmt: skip

    @property
    def count(self) -> int:
        """Cells, empty ones included."""
        return int(self.first[-1])


def sort_into_cells(cells: Cells, particles: Particles, seed: int, step: int) -> None:
    """Sort the particles by cell; stable, and the same for any number of threads."""
    n, chambers = particles.count, len(cells.size)
    if len(cells.order) < n:
        cells.order, cells.cell = np.zeros(particles.capacity, np.int32), np.zeros(particles.capacity, np.int32)
    boxes = np.zeros((-(-n // CHUNK), chambers, 7))
    _boxes(n, particles.position, particles.chamber, boxes)
    low = boxes[:, :, :3].min(axis=0, initial=np.inf)
    high = boxes[:, :, 3:6].max(axis=0, initial=-np.inf)
    number = boxes[:, :, 6].sum(axis=0).astype(np.int64)
    for attempt in range(ATTEMPTS):
        _lay_grids(low, high, number, cells.size, cells.partners, cells.origin, cells.shape, cells.first, seed, step)
        if len(cells.start) < cells.count + 2:
            cells.start = np.zeros(cells.count + cells.count // 4 + 2, np.int32)
        _find_cells(
            n, particles.position, particles.chamber, cells.size, cells.origin, cells.shape, cells.first, cells.cell
        )
        _place(n, team(n), cells.cell, cells.first, cells.start, cells.order, number, cells.partners)
        wanted = np.minimum(PARTNERS, number - 1.0)
        fits = (cells.partners > 0.5 * wanted) & (cells.partners < 2.0 * wanted)
        if attempt + 1 == ATTEMPTS or (fits | (number < 2)).all():
            break


@kernel
def _boxes(n, position, chamber, boxes_out):
    """Per chunk and chamber: lowest corner, highest corner, number of particles."""
    chunks = (n + CHUNK - 1) // CHUNK
    for chunk in prange(chunks):
        for k in range(boxes_out.shape[1]):
            for axis in range(3):
                boxes_out[chunk, k, axis] = np.inf
                boxes_out[chunk, k, 3 + axis] = -np.inf
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            k = chamber[i]
            for axis in range(3):
                boxes_out[chunk, k, axis] = min(boxes_out[chunk, k, axis], position[i, axis])
                boxes_out[chunk, k, 3 + axis] = max(boxes_out[chunk, k, 3 + axis], position[i, axis])
            boxes_out[chunk, k, 6] += 1.0


@scalar
def _lay_grids(low, high, number, size, partners, origin, shape, first, seed, step):
    """Correct each chamber's cell size, and lay its grid over its particles."""
    for k in range(len(size)):
        first[k + 1] = first[k]
        shape[k, :] = 0
        if number[k] == 0:
            continue
        extent = high[k] - low[k]
        longest = max(extent[0], extent[1], extent[2])
        wanted = min(PARTNERS, number[k] - 1.0)
        if size[k] == 0.0:
            filled = max(extent[0], 1e-3 * longest) * max(extent[1], 1e-3 * longest) * max(extent[2], 1e-3 * longest)
            size[k] = max((wanted * filled / number[k]) ** (1.0 / 3.0), 1e-9)
        elif number[k] > 1:
            size[k] *= min(max((wanted / max(partners[k], 1e-3)) ** (1.0 / 3.0), 0.5), 2.0)
        size[k] = min(size[k], 2.0 * longest + 1e-9)
        key = stream(seed + SHIFT, step, k)
        while True:
            cells = 1.0
            for axis in range(3):
                origin[k, axis] = low[k, axis] - uniform(key, axis) * size[k]
                shape[k, axis] = int((high[k, axis] - origin[k, axis]) / size[k]) + 1
                cells *= shape[k, axis]
            if cells <= CELLS_PER_PARTICLE * number[k] + 64:
                break
            size[k] *= 1.1
        first[k + 1] = first[k] + shape[k, 0] * shape[k, 1] * shape[k, 2]


@kernel
def _find_cells(n, position, chamber, size, origin, shape, first, cell_out):
    for i in prange(n):
        k = chamber[i]
        inverse = 1.0 / size[k]
        ix = int((position[i, 0] - origin[k, 0]) * inverse)
        iy = int((position[i, 1] - origin[k, 1]) * inverse)
        iz = int((position[i, 2] - origin[k, 2]) * inverse)
        # The shape was found by dividing by the size: the last particle may differ by one rounding.
        ix, iy, iz = min(ix, shape[k, 0] - 1), min(iy, shape[k, 1] - 1), min(iz, shape[k, 2] - 1)
        cell_out[i] = first[k] + (ix * shape[k, 1] + iy) * shape[k, 2] + iz


@kernel
def _place(n, parts, cell, first, start, order, number, partners):
    """Counting sort (stable), and the mean number of partners of each chamber. Each part does its own cells."""
    cells = first[len(first) - 1]
    start[0], start[1] = 0, 0
    for part in prange(parts):
        begin, end = part * cells // parts, (part + 1) * cells // parts
        for c in range(begin, end):
            start[c + 2] = 0
        for i in range(n):
            if begin <= cell[i] < end:
                start[cell[i] + 2] += 1
    for k in range(len(partners)):
        pairs = 0
        for c in range(first[k], first[k + 1]):
            count = np.int64(start[c + 2])
            pairs += count * (count - 1)
            start[c + 2] += start[c + 1]
        partners[k] = pairs / max(number[k], 1)
    for part in prange(parts):  # start[c + 1] runs from the beginning of cell c to its end
        begin, end = part * cells // parts, (part + 1) * cells // parts
        for i in range(n):
            c = cell[i]
            if begin <= c < end:
                order[start[c + 1]] = i
                start[c + 1] += 1
