"""Work to the last digit: the gas pays what the fabric receives.

Over a step the structure does the work of the mean of the forces at its start and end. What the gas booked at the
walls, part by part, differs a little. The difference is owed by the gas beside each triangle, and taken from it there;
so the energy of the gas closes to rounding, and its work is the fabric's.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.geometry.lattice_clipping import NORMAL
from billow.geometry.triangle import double_area_vector

LARGEST_SHARE = 0.02
"""Of the energy of a cell that is taken for debts in one step, at most; the rest is owed until the next."""


@kernel
def work_of(n, triangles, before, after, force_before, force_after, sign, outer, ambient, work_out, against_out):
    """Work [J] of the gas on n triangles over a step, and of the ambient pressure [Pa] against it, (n,) each.

    before, after: positions of the nodes [m]; force_before, force_after: (n, 3, 3) [N].
    """
    for t in prange(n):
        work, against = 0.0, 0.0
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        nx, ny, nz = double_area_vector(before, a, b, c)
        mx, my, mz = double_area_vector(after, a, b, c)
        pull = ambient * sign[t] / 12.0 if outer[t] else 0.0
        mean = (pull * (nx + mx), pull * (ny + my), pull * (nz + mz))
        for k in range(3):
            node = triangles[t, k]
            for d in range(3):
                way = after[node, d] - before[node, d]
                work += 0.5 * (force_before[t, k, d] + force_after[t, k, d]) * way
                against += mean[d] * way
        work_out[t], against_out[t] = work, against


@kernel
def add_load(n, triangles, index, positions, force, sign, outer, ambient, corner_force):
    """Add the force of the gas, less that of the ambient pressure [Pa], to the corners (all triangles, 3, 3)."""
    for t in prange(n):
        nx, ny, nz = double_area_vector(positions, triangles[t, 0], triangles[t, 1], triangles[t, 2])
        pull = ambient * sign[t] / 6.0 if outer[t] else 0.0
        back = (pull * nx, pull * ny, pull * nz)
        for k in range(3):
            for d in range(3):
                corner_force[index[t], k, d] += force[t, k, d] - back[d]


def pay(owed: np.ndarray, first: np.ndarray, rows: np.ndarray, cell: np.ndarray, of: np.ndarray, held: np.ndarray,
        start_of: np.ndarray) -> None:  # fmt: skip
    """Take what triangles owe [J] (triangles,) from the cells beside them, by the area of fragments; what these cannot
    give remains owed.

    first, rows: of the fragments; cell: of each. of, start_of: cluster of each cell, and clusters + 1. held: (cells,
    species + 4).
    """
    _pay(owed, first, rows, cell, of, held, np.zeros(start_of), np.zeros(start_of), np.zeros(start_of))


@scalar
def _pay(owed, first, rows, cell, of, held, thermal, debt, given):
    species = held.shape[1] - 4
    for i in range(len(of)):
        m = 0.0
        for s in range(species):
            m += held[i, s]
        if m > 0.0:
            flow = held[i, species] ** 2 + held[i, species + 1] ** 2 + held[i, species + 2] ** 2
            thermal[of[i]] += held[i, species + 3] - 0.5 * flow / m
    for t in range(len(owed)):
        area = _area(first, rows, t)
        if area > 0.0:
            for f in range(first[t], first[t + 1]):
                debt[of[cell[f]]] += owed[t] * _size(rows, f) / area
    for c in range(len(debt)):
        limit = LARGEST_SHARE * thermal[c]
        given[c] = min(max(debt[c], -limit), limit) / debt[c] if debt[c] != 0.0 else 0.0
    for t in range(len(owed)):
        area, paid = _area(first, rows, t), 0.0
        if area > 0.0:
            for f in range(first[t], first[t + 1]):
                paid += given[of[cell[f]]] * owed[t] * _size(rows, f) / area
            owed[t] -= paid
    for i in range(len(of)):
        c = of[i]
        if given[c] != 0.0:
            m, flow = 0.0, 0.0
            for s in range(species):
                m += held[i, s]
            if m > 0.0:
                flow = held[i, species] ** 2 + held[i, species + 1] ** 2 + held[i, species + 2] ** 2
                share = (held[i, species + 3] - 0.5 * flow / m) / thermal[c]
                held[i, species + 3] -= given[c] * debt[c] * share


@scalar
def _size(rows, f):
    return np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)


@scalar
def _area(first, rows, t):
    total = 0.0
    for f in range(first[t], first[t + 1]):
        total += _size(rows, f)
    return total
