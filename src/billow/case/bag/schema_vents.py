"""Vent holes of a bag, and how gas leaves through them."""

from __future__ import annotations

from billow.case.bag.quantities import Fraction, Length, Offset, Panel
from billow.case.quantity import Strict, number_or_curve, quantity, whole

Pressure = quantity("Pa", 0.0, 1e7)


class VentFlow(Strict):
    """How gas leaves through the vents; the same for all vents of a bag."""

    discharge: number_or_curve("-", 0.0, 1.0, "time") = 0.7
    """Discharge coefficient: a number, or a curve against time."""
    area_factor: number_or_curve("-", 0.0, 100.0, "time", "gauge_pressure") = 1.0
    """Factor on the area of the hole: a number, or a curve against time or against gauge pressure."""
    opening_pressure: Pressure = 0.0
    """Gauge pressure at which a vent opens and stays open."""
    burst_time: quantity("s", 0.0, 10.0) = 0.0
    """Latest time at which a vent opens; 0 if only the pressure decides. With an opening_pressure of 0 the vent stays
    closed until then."""
    blockage: bool = False
    """Whether contact with an obstacle, or with another layer of fabric ("layers"), closes a vent, in proportion to the
    share of its rim in contact."""
    through_blocked: Fraction = 0.0
    """Share of the flow that still passes through the blocked part of a vent."""


class Vents(VentFlow):
    """Vent holes in the rear panel, evenly spaced about the axis."""

    count: whole(0, 12, "vents") = 2
    """Number of vents."""
    diameter: quantity("m", 1e-3, 0.2) = 0.035
    """Diameter of each hole."""
    distance: Length = 0.17
    """Distance of their centres from the bag's axis."""


class PanelVents(Vents):
    """Vent holes in one panel, evenly spaced about the middle of the bag; the first lies in direction x."""

    count: whole(0, 12, "vents") = 0
    """Number of vents."""
    panel: Panel = "rear"
    """Panel they are cut into."""


class ChamberVents(VentFlow):
    """Vent holes in one panel, one in the middle of each chamber named, moved by `offset`."""

    chambers: tuple[whole(0, 64), ...] = ()
    """Chambers with a vent, counted from 1 at the lowest x."""
    diameter: quantity("m", 1e-3, 0.2) = 0.035
    """Diameter of each hole."""
    offset: tuple[Offset, Offset] = (0.0, 0.0)
    """Position of its centre relative to the middle of its chamber (x, y)."""
    panel: Panel = "rear"
    """Panel they are cut into."""
