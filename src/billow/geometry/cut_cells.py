"""What part of each cell of a lattice lies within a closed surface, and of each face between cells.

Signed sums over the fragments of the surface (Gauss' theorem cell by cell) give volumes, apertures and centroids that
are exact for any number of layers in a cell. A place that the surface goes round twice counts twice, and one that it
goes round the wrong way counts as less than nothing: so the sum of all volumes is the volume of the surface, and every
cell is closed, also where fabric lies in itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.base.errors import NumericalStop
from billow.base.scratch import Scratch
from billow.geometry.lattice_clipping import (
    COLUMNS,
    FARTHEST,
    NORMAL,
    PLACE,
    STRIDE,
    Fragments,
    cell_of,
    clip,
    key_of,
    pack,
)

NOTHING = 1e-10
"""Size of a volume fraction or aperture below which there is nothing."""

LARGEST_WINDOW = 200_000_000
"""Cells about a surface, above which the lattice does not fit into memory."""

TOO_LARGE = NumericalStop.declare(
    "E-NUM-020",
    "the mesh of the gas would have {cells:.3g} cells",
    where="the surface reaches over {x:.3g} x {y:.3g} x {z:.3g} cells",
    why=f"at most {LARGEST_WINDOW:.0e} fit into memory",
    cause="fabric that flies away, or cells that are far too small for the bag",
    remedy="look at the last frames; reduce run.dt_scale, or raise gas.cell",
)


@dataclass
class Window:
    """A box about a surface: low corner and shape [cells], (3,) each; first fragment of each of its cells; and room for
    the cuts of the surface, the last one and the one before it."""

    low: np.ndarray
    shape: np.ndarray
    start: np.ndarray
    scratch: Scratch
    turn: int = 0

    @classmethod
    def none(cls) -> Window:
        return cls(np.zeros(3, np.int64), np.zeros(3, np.int64), np.zeros(1, np.int32), Scratch())

    def about(self, triangles: np.ndarray, places: np.ndarray) -> None:
        """Lie about triangles (n, 3) of places in lattice coordinates, (nodes, 3), with a cell to spare on every side.
        Raises NumericalStop E-NUM-020."""
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        _reach(triangles, places, low, high)
        size = high - low + 3.0
        if not (np.prod(size) < LARGEST_WINDOW and max(np.abs(low).max(), np.abs(high).max()) < FARTHEST - 2):
            raise TOO_LARGE(cells=np.prod(size), x=size[0], y=size[1], z=size[2])
        self.low = np.floor(low).astype(np.int64) - 1
        self.shape = np.floor(high).astype(np.int64) + 2 - self.low
        cells = int(self.shape.prod())
        if len(self.start) <= cells:
            self.start = np.zeros(cells + cells // 16 + 1, np.int32)


@dataclass(frozen=True)
class CutCells:
    """The cells within a closed surface, in order of their keys; in lattice coordinates.

    key: (cells,) int64. volume: (cells,), 1 for a full cell. aperture: (cells, 3), open share of the face towards the
    next cell along each axis. centroid: (cells, 3). fragments: of the surface; start: (cells + 1,) int32, those of cell
    c are start[c] to start[c + 1]. inverted: sum of the negative volumes, where the surface lies in itself.
    """

    key: np.ndarray
    volume: np.ndarray
    aperture: np.ndarray
    centroid: np.ndarray
    fragments: Fragments
    start: np.ndarray
    inverted: float

    @cached_property
    def cell(self) -> np.ndarray:
        """Number of the cell of each fragment, (fragments,) int32."""
        return np.repeat(np.arange(len(self.key), dtype=np.int32), np.diff(self.start))

    @cached_property
    def total(self) -> float:
        """Volume of all cells."""
        return float(self.volume.sum())


def cut_cells(triangles: np.ndarray, sign: np.ndarray, places: np.ndarray, window: Window) -> CutCells:
    """triangles: of a closed surface, (n, 3); sign: 1.0 where the normal points out of it, (n,); places: of the nodes,
    in lattice coordinates, (nodes, 3). window: of this surface, which is changed; what it is cut into stays as it
    is for one more cut. Its scratch lends "passing", "slope", "half" and "state" to the cut. Raises NumericalStop
    E-NUM-020."""
    window.about(triangles, places)
    window.turn = 1 - window.turn

    def take(name: str, *size: int, kind: type = np.float64) -> np.ndarray:
        return window.scratch.take(f"{name}{window.turn}", *size, kind=kind)

    loose = clip(triangles, sign, places, window.scratch)
    low, shape, start = window.low, window.shape, window.start
    aperture = window.scratch.take("state", int(shape.prod()), 3)
    count, layers, inverted = int(loose.first[-1]), np.zeros(shape[0] + 1, np.int64), np.zeros(shape[0])
    number = take("number", count, kind=np.int32)
    _sort(*loose[:3], low, shape, start, number)
    rows, triangle = take("rows", count, COLUMNS), take("triangle", count, kind=np.int32)
    levers, moment = window.scratch.take("levers", count, 3), window.scratch.take("slope", count, 3)
    pack(len(triangles), loose.slot, loose.first, loose.rows, number, rows, triangle, moment, levers)
    _sum_up(count, shape, start, rows, aperture)
    _along_x(count, shape, start, aperture, layers)
    np.cumsum(layers, out=layers)
    cells = int(layers[-1])
    key, first = take("key", cells, kind=np.int64), take("start", cells + 1, kind=np.int32)
    volume, apertures, centroid = take("volume", cells), take("aperture", cells, 3), take("centroid", cells, 3)
    first[cells] = count
    _collect(
        count, shape, start, rows, moment, low, aperture, layers, key, volume, apertures, centroid, first, inverted
    )
    fragments = Fragments(rows, triangle, loose.first, number, levers)
    return CutCells(key, volume, apertures, centroid, fragments, first, float(inverted.sum()))


@scalar
def _reach(triangles, places, low_out, high_out):
    """Ends of triangles along the axes."""
    for t in range(len(triangles)):
        for k in range(3):
            for d in range(3):
                x = places[triangles[t, k], d]
                low_out[d], high_out[d] = min(low_out[d], x), max(high_out[d], x)


@scalar
def _sort(slot, first, key, low, shape, start, number_out):
    """Counting sort by cell: the number of each fragment, in order of triangles; those of a cell stay in order."""
    cells = shape[0] * shape[1] * shape[2]
    for c in range(cells + 1):
        start[c] = 0
    for t in range(len(slot) - 1):
        for m in range(first[t + 1] - first[t]):
            i, j, k = cell_of(key[slot[t] + m])
            c = ((i - low[0]) * shape[1] + j - low[1]) * shape[2] + k - low[2]
            number_out[first[t] + m] = c
            start[c] += 1
    total = 0
    for c in range(cells + 1):
        here = start[c]
        start[c] = total
        total += here
    for f in range(len(number_out)):
        c = number_out[f]
        number_out[f] = start[c]
        start[c] += 1
    for c in range(cells, 0, -1):
        start[c] = start[c - 1]
    start[0] = 0


@kernel
def _sum_up(n, shape, start, rows, aperture_out):
    """Running sums along y and z; along x what each cell adds. n: fragments, which decide whether it is parallel."""
    ny, nz = shape[1], shape[2]
    for i in prange(shape[0]):
        for j in range(ny):
            az = 0.0
            for k in range(nz):
                c = (i * ny + j) * nz + k
                sx, sy = 0.0, 0.0
                for f in range(start[c], start[c + 1]):
                    sx += rows[f, NORMAL]
                    sy += rows[f, NORMAL + 1]
                    az -= rows[f, NORMAL + 2]
                aperture_out[c, 0] = -sx
                aperture_out[c, 1] = (aperture_out[c - nz, 1] if j > 0 else 0.0) - sy
                aperture_out[c, 2] = az


@scalar
def _is_open(aperture, c):
    return max(abs(aperture[c, 0]), abs(aperture[c, 1]), abs(aperture[c, 2])) > NOTHING


@kernel
def _along_x(n, shape, start, aperture, layers_out):
    """Running sums along x; then how many cells of each layer there is something of."""
    ny, nz = shape[1], shape[2]
    for j in prange(ny):
        for i in range(1, shape[0]):
            for k in range(nz):
                c = (i * ny + j) * nz + k
                aperture[c, 0] += aperture[c - ny * nz, 0]
    for i in prange(shape[0]):
        found = 0
        for c in range(i * ny * nz, (i + 1) * ny * nz):
            if start[c + 1] > start[c] or _is_open(aperture, c):
                found += 1
        layers_out[i + 1] = found


@kernel
def _collect(
    n, shape, start, rows, moment, low, aperture, layers, key_out, volume_out, aperture_out, centroid_out, first_out,
    inverted_out,
):  # fmt: skip
    ny, nz = shape[1], shape[2]
    for i in prange(shape[0]):
        at, x = layers[i], low[0] + np.int64(i)  # i is unsigned in threads
        for j in range(ny):
            for k in range(nz):
                c = (i * ny + j) * nz + k
                begin, end = start[c], start[c + 1]
                if not (end > begin or _is_open(aperture, c)):
                    continue
                volume, mx, my, mz = aperture[c, 0], aperture[c, 0], aperture[c, 1], aperture[c, 2]
                for f in range(begin, end):
                    volume += (rows[f, PLACE] - x) * rows[f, NORMAL]
                    mx, my, mz = mx + moment[f, 0], my + moment[f, 1], mz + moment[f, 2]
                volume = volume if abs(volume) > NOTHING else 0.0
                inverted_out[i] += min(volume, 0.0)
                double = 2.0 * volume if volume != 0.0 else 1.0
                key_out[at], volume_out[at], first_out[at] = key_of(x, low[1] + j, low[2] + k), volume, begin
                centroid_out[at, 0] = x + min(max(mx / double, 0.0), 1.0)
                centroid_out[at, 1] = low[1] + j + min(max(my / double, 0.0), 1.0)
                centroid_out[at, 2] = low[2] + k + min(max(mz / double, 0.0), 1.0)
                for d in range(3):
                    share = aperture[c, d]
                    aperture_out[at, d] = share if abs(share) > NOTHING else 0.0
                at += 1


def unite(old: np.ndarray, new: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All keys of two ascending lists, (n,), and where each is in the one and in the other, (n,) int32, -1 if it is
    not."""
    n = len(old) + len(new) - _shared(old, new)
    key, in_old, in_new = np.empty(n, np.int64), np.empty(n, np.int32), np.empty(n, np.int32)
    _unite(old, new, key, in_old, in_new)
    return key, in_old, in_new


@scalar
def _shared(old, new):
    """How many keys both lists have."""
    a, b, m = 0, 0, 0
    while a < len(old) and b < len(new):
        first, second = old[a] <= new[b], new[b] <= old[a]
        a, b, m = a + first, b + second, m + (first and second)
    return m


@scalar
def _unite(old, new, key_out, old_out, new_out):
    a, b, m = 0, 0, 0
    while a < len(old) or b < len(new):
        first = a < len(old) and (b >= len(new) or old[a] <= new[b])
        second = b < len(new) and (a >= len(old) or new[b] <= old[a])
        key_out[m] = old[a] if first else new[b]
        old_out[m], new_out[m] = a if first else -1, b if second else -1
        a, b, m = a + first, b + second, m + 1


def neighbours(key: np.ndarray) -> np.ndarray:
    """Numbers of the next cells along -x, x, -y, y, -z, z among cells with ascending keys: (n, 6) int32, or -1."""
    beside = np.full((len(key), 6), -1, np.int32)
    _neighbours(key, beside)
    return beside


@scalar
def _neighbours(key, beside_out):
    n = len(key)
    for d in range(3):
        j = 0
        for i in range(n):
            wanted = key[i] + STRIDE[d]
            while j < n and key[j] < wanted:
                j += 1
            if j < n and key[j] == wanted:
                beside_out[i, 2 * d + 1] = j
                beside_out[j, 2 * d] = i
