"""Uniform pressure on a surface: a third of p times the area vector on each corner, whose work on a closed surface is
exactly p dV."""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import kernel
from billow.parts.gas.gas_model import Bag


def add_pressures(bag: Bag, gauge: np.ndarray, corner_force: np.ndarray) -> None:
    """Add the forces [N] of pressure in the chambers of a bag to corner_force (triangles, 3, 3); each triangle bears
    the difference across it. gauge: [Pa], (chambers + 1,), the last one of the surroundings."""
    thirds, chambers = bag.thirds, bag.surface.chambers
    _add_pressures(len(thirds), thirds, chambers.behind, chambers.ahead, gauge, corner_force)


@kernel
def _add_pressures(n, thirds, behind, ahead, gauge, corner_force):
    for item in prange(n):
        i = np.uint64(item)
        pressure = gauge[behind[i]] - gauge[ahead[i]]  # OUTSIDE, -1: the last
        fx, fy, fz = pressure * thirds[i, 0], pressure * thirds[i, 1], pressure * thirds[i, 2]
        for k in range(3):
            corner_force[i, k, 0] += fx
            corner_force[i, k, 1] += fy
            corner_force[i, k, 2] += fz
