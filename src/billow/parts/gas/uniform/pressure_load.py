"""Uniform pressure on a surface: a third of p times the area vector on each corner, whose work on a closed surface is
exactly p dV."""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import kernel
from billow.geometry.triangle import double_area_vector


def add_pressure(triangles: np.ndarray, positions: np.ndarray, pressure: float, corner_force: np.ndarray) -> None:
    """Add the forces [N] of a gauge pressure [Pa] to corner_force (triangles, 3, 3)."""
    behind = np.zeros(len(triangles), np.int32)
    add_pressures(triangles, positions, behind, behind - np.int32(1), np.array([pressure, 0.0]), corner_force)


def add_pressures(
    triangles: np.ndarray, positions: np.ndarray, behind: np.ndarray, ahead: np.ndarray, gauge: np.ndarray,
    corner_force: np.ndarray,
) -> None:  # fmt: skip
    """As `add_pressure` for several chambers: each triangle bears the difference across it.

    behind, ahead: (triangles,) int32 as in Chambers. gauge: [Pa], (chambers + 1,), the last one of the surroundings.
    """
    _add_pressures(len(triangles), triangles, positions, behind, ahead, gauge, corner_force)


@kernel
def _add_pressures(n, triangles, positions, behind, ahead, gauge, corner_force):
    for i in prange(n):
        third = (gauge[behind[i]] - gauge[ahead[i]]) / 6.0  # OUTSIDE, -1: the last
        nx, ny, nz = double_area_vector(positions, triangles[i, 0], triangles[i, 1], triangles[i, 2])
        fx, fy, fz = third * nx, third * ny, third * nz
        for k in range(3):
            corner_force[i, k, 0] += fx
            corner_force[i, k, 1] += fy
            corner_force[i, k, 2] += fz
