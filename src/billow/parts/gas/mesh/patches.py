"""Patches: where a triangle lies in a cell during a step, its fragments there before and after the step together.

Walls count as the mean over time of both fragments, weighted as the time says. As one they cost half of two, and cell
by cell they lie together in memory, so that a cluster finds its walls in one place.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import kernel
from billow.base.scratch import Scratch
from billow.geometry.cut_cells import CutCells
from billow.geometry.lattice_clipping import NORMAL, PLACE, WEIGHT

SIDE, AREA, AT, SPEED, BEFORE = 0, 3, 4, 7, 10
"""Columns of a patch: unit normal, out of the gas, and area [faces] in the middle of a part of the step; centroid, in
lattice coordinates; velocity [m/s]; area before the step [faces]."""
COLUMNS = 11


class Patches(NamedTuple):
    """start: (cells + 1,) int32, those of cell i are start[i] to start[i + 1], in order of triangles. triangle, old,
    new: (n,) int32, the triangle of each and its fragments in the cuts before and after, or -1. of_old, of_new:
    (fragments,) int32, the patch of each fragment. rows: (n, COLUMNS)."""

    start: np.ndarray
    triangle: np.ndarray
    old: np.ndarray
    new: np.ndarray
    of_old: np.ndarray
    of_new: np.ndarray
    rows: np.ndarray

    @classmethod
    def find(
        cls, in_old: np.ndarray, in_new: np.ndarray, old: CutCells, new: CutCells, triangles: np.ndarray,
        velocity: np.ndarray, scratch: Scratch,
    ) -> Patches:  # fmt: skip
        """In the middle of the step. in_old, in_new: number of each cell in the cuts before and after, or -1.
        triangles, velocity [m/s]: of the walls and their nodes. scratch: memory until the next step."""
        cells = len(in_old)
        start = np.zeros(cells + 1, np.int32)
        cuts = old.start, old.fragments.triangle, new.start, new.fragments.triangle
        _count(cells, in_old, in_new, *cuts, start)
        np.cumsum(start, out=start)
        n = int(start[-1])
        triangle, f_old, f_new = (scratch.take(name, n, kind=np.int32) for name in ("triangle", "old", "new"))
        of_old = scratch.take("of_old", len(old.fragments.triangle), kind=np.int32)
        of_new = scratch.take("of_new", len(new.fragments.triangle), kind=np.int32)
        rows = scratch.take("patches", n, COLUMNS)
        _fill(
            cells, in_old, in_new, *cuts, start, old.fragments.rows, new.fragments.rows, triangles, velocity, triangle,
            f_old, f_new, of_old, of_new, rows,
        )  # fmt: skip
        return cls(start, triangle, f_old, f_new, of_old, of_new, rows)

    def turn(self, old: CutCells, new: CutCells, middle: float) -> None:
        """Normals and areas at another time, as a share of the step."""
        _turn(len(self.old), self.old, self.new, old.fragments.rows, new.fragments.rows, middle, self.rows)


@kernel
def _count(
    n, in_old, in_new, old_start, old_triangle, new_start, new_triangle, start_out
):  # fmt: skip
    for i in prange(n):
        a, b = in_old[i], in_new[i]
        f, f_end = (old_start[a], old_start[a + 1]) if a >= 0 else (0, 0)
        g, g_end = (new_start[b], new_start[b + 1]) if b >= 0 else (0, 0)
        found = 0
        while f < f_end or g < g_end:
            first = old_triangle[f] if f < f_end else 2**31
            second = new_triangle[g] if g < g_end else 2**31
            f, g = f + (first <= second), g + (second <= first)
            found += 1
        start_out[i + 1] = found


@kernel
def _fill(
    n, in_old, in_new, old_start, old_triangle, new_start, new_triangle, start, old_rows, new_rows, triangles,
    velocity, triangle_out, old_out, new_out, of_old_out, of_new_out, rows_out,
):  # fmt: skip
    """Patches of n cells; places and velocities are those of the fragment after the step if there is one."""
    for i in prange(n):
        a, b = in_old[i], in_new[i]
        f, f_end = (old_start[a], old_start[a + 1]) if a >= 0 else (0, 0)
        g, g_end = (new_start[b], new_start[b + 1]) if b >= 0 else (0, 0)
        for q in range(start[i], start[i + 1]):
            first = old_triangle[f] if f < f_end else 2**31
            second = new_triangle[g] if g < g_end else 2**31
            t, x, y, z = min(first, second), 0.0, 0.0, 0.0
            triangle_out[q], old_out[q], new_out[q], rows_out[q, BEFORE] = t, -1, -1, 0.0
            u, v, w = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            if first <= second:
                old_out[q], of_old_out[f] = f, q
                x, y, z = 0.5 * old_rows[f, NORMAL], 0.5 * old_rows[f, NORMAL + 1], 0.5 * old_rows[f, NORMAL + 2]
                rows_out[q, BEFORE] = 2.0 * np.sqrt(x * x + y * y + z * z)
                if second > first:  # it ends
                    wv, ww = old_rows[f, WEIGHT], old_rows[f, WEIGHT + 1]
                    wu = 1.0 - wv - ww
                    for d in range(3):
                        rows_out[q, AT + d] = old_rows[f, PLACE + d]
                        rows_out[q, SPEED + d] = wu * velocity[u, d] + wv * velocity[v, d] + ww * velocity[w, d]
                f += 1
            if second <= first:
                new_out[q], of_new_out[g] = g, q
                x += 0.5 * new_rows[g, NORMAL]
                y += 0.5 * new_rows[g, NORMAL + 1]
                z += 0.5 * new_rows[g, NORMAL + 2]
                wv, ww = new_rows[g, WEIGHT], new_rows[g, WEIGHT + 1]
                wu = 1.0 - wv - ww
                for d in range(3):
                    rows_out[q, AT + d] = new_rows[g, PLACE + d]
                    rows_out[q, SPEED + d] = wu * velocity[u, d] + wv * velocity[v, d] + ww * velocity[w, d]
                g += 1
            area = np.sqrt(x * x + y * y + z * z)
            share = 1.0 / area if area > 0.0 else 0.0
            rows_out[q, SIDE], rows_out[q, SIDE + 1], rows_out[q, SIDE + 2] = share * x, share * y, share * z
            rows_out[q, AREA] = area


@kernel
def _turn(n, old, new, old_rows, new_rows, middle, rows_out):
    for q in prange(n):
        x, y, z = 0.0, 0.0, 0.0
        f, g = old[q], new[q]
        if f >= 0:
            early = 1.0 - middle
            x, y, z = early * old_rows[f, NORMAL], early * old_rows[f, NORMAL + 1], early * old_rows[f, NORMAL + 2]
        if g >= 0:
            x += middle * new_rows[g, NORMAL]
            y += middle * new_rows[g, NORMAL + 1]
            z += middle * new_rows[g, NORMAL + 2]
        area = np.sqrt(x * x + y * y + z * z)
        share = 1.0 / area if area > 0.0 else 0.0
        rows_out[q, SIDE], rows_out[q, SIDE + 1], rows_out[q, SIDE + 2] = share * x, share * y, share * z
        rows_out[q, AREA] = area
