"""What `Loads` put on the nodes, in plain NumPy: the sums that the product takes in passes."""

from __future__ import annotations

import numpy as np

from billow.geometry.surface import area_vectors
from billow.parts.part import Loads


def on_nodes(loads: Loads, surface, positions: np.ndarray) -> np.ndarray:
    """Forces [N], (nodes, 3), but for those of fabric: pressure, and what other parts added."""
    gauge, triangles = loads.gauge, surface.triangles.astype(np.int64)
    force = loads.node_force.copy()
    if gauge.any():
        pressure = gauge[surface.chambers.behind] - gauge[surface.chambers.ahead]
        np.add.at(force, triangles, (pressure[:, None] * area_vectors(triangles, positions) / 3.0)[:, None, :])
    if len(loads.corner_force):
        np.add.at(force, triangles, loads.corner_force)
    return force
