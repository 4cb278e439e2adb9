"""What is allowed but probably not meant about the curves of a fabric."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.base.errors import Concern
from billow.parts.fabric.curve_check import cost_of_steepness, reach
from billow.parts.fabric.curve_fabric import CurveFabric
from billow.solver.model import Model

COSTLY = 0.5
"""Part of the stable step that a single steep curve may leave of what it would be without."""

PEAK_PRESSURE = 60e3
"""Gauge pressure [Pa] that curves should reach: that of a hot driver bag at its peak."""


def curve_warnings(model: Model) -> Iterator[Concern]:
    """Curves so steep that they alone cost half the step, and curves that end before the stresses of a deployment."""
    for membrane in model.membranes:
        fabric = membrane.fabric
        if not isinstance(fabric, CurveFabric):
            continue
        name, now, without = cost_of_steepness(fabric, float(membrane.altitude.min()))
        if now < COSTLY * without:
            yield Concern(
                "W-FAB-004",
                f"the curve of {name} makes the step {1e6 * now:.3g} us instead of {1e6 * without:.3g} us",
                f"fabric.curves.{name}",
                "its steepest piece, or unloading from it, sets the step of all: a kink, noise, or a wrong unit",
                "smooth the steepest piece, or end the curve before it",
            )
        needed = 0.25 * PEAK_PRESSURE * float(np.ptp(model.start, axis=0).max())  # p R / 2 of a round bag
        for name, (strain, force) in reach(fabric).items():
            if force < needed:
                yield Concern(
                    "W-FAB-005",
                    f"the curve of {name} ends at {force:.3g} N/m, a strain of {strain:.3g}",
                    f"fabric.curves.{name}.loading",
                    f"{1e-3 * PEAK_PRESSURE:g} kPa in this bag pull with {needed:.3g} N/m; beyond, it goes on straight",
                    "measure further, or check the unit of the stress",
                )
