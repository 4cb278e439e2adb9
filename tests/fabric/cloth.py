"""Small pieces of fabric for tests: the three answers to compression, one patch of four triangles."""

from __future__ import annotations

import numpy as np

from billow.geometry.assembly import COLUMNS, Corners
from billow.parts.fabric.linear_law import KEEP, PRINCIPAL, YARN, LinearFabric
from billow.parts.fabric.membrane import Membrane

COMMON = {"density": 800.0, "thickness": 3e-4, "young_warp": 0.4e9}
WOVEN = {**COMMON, "young_weft": 0.3e9, "poisson": 0.25, "shear": 2e7}
FABRICS = {
    KEEP: LinearFabric(**WOVEN, compression=True, damping=0.05),
    PRINCIPAL: LinearFabric(
        **COMMON, young_weft=0.4e9, poisson=0.3, shear=0.4e9 / 2.6, compression=False, damping=0.05
    ),
    YARN: LinearFabric(**WOVEN, compression=False, damping=0.05),
}
"""What compression does -> a fabric that does it."""

TRIANGLES = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], dtype=np.uint32)
FLAT = np.array([[0.0, 0.0], [0.011, 0.001], [0.012, 0.009], [-0.001, 0.010], [0.005, 0.006]])
"""A square patch of four triangles, all different, [m]."""


def patch(rule: int) -> Membrane:
    return Membrane.build(FABRICS[rule], np.arange(4), FLAT[TRIANGLES])


def forces(membrane: Membrane, positions, velocities=None):
    """Corner forces [N] (4, 3, 3), energy [J], damping power [W] of the patch."""
    velocities = np.zeros_like(positions) if velocities is None else velocities
    force, sums = corner_forces(membrane, TRIANGLES, positions, velocities, membrane.fresh_history())
    return force, sums[0], sums[1]


def corner_forces(membrane: Membrane, triangles, positions, velocities, history):
    """Corner forces [N] (n, 3, 3) of a membrane on these triangles, and its sums; brings the history up to date."""
    corners, sums = Corners.apart(triangles), membrane.sums()
    loads = np.full((corners.entry.size, COLUMNS), np.nan)
    membrane.fabric.add_forces(membrane, corners, positions, velocities, history, loads, sums)
    return loads[:, :3].reshape(-1, 3, 3), sums[0]


def nodal(corner_force):
    """Sum of corner forces at each node [N], (5, 3)."""
    out = np.zeros((5, 3))
    np.add.at(out, TRIANGLES.astype(int), corner_force)
    return out


def shaken(seed: int, strain: float) -> np.ndarray:
    """The patch in space, crumpled at random by about `strain`, (5, 3) [m]."""
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    flat = np.column_stack([FLAT, np.zeros(5)])
    return flat @ turn.T + rng.normal(scale=strain * 0.005, size=(5, 3))
