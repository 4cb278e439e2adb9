"""The `[bag]` table of a rectangular bag of chambers."""

from __future__ import annotations

from typing import Literal

from billow.case.bag.quantities import Fraction, Offset
from billow.case.bag.schema_panels import PanelBag
from billow.case.bag.schema_straps import PanelStrap
from billow.case.bag.schema_vents import ChamberVents
from billow.case.quantity import Strict, quantity, whole


class Openings(Strict):
    """The gap that each seam between two chambers leaves open."""

    width: quantity("m", 1e-3, 5.0) = 0.08
    """Length of the gap along the seam."""
    place: Fraction = 0.9
    """Position of its middle across the bag, from 0 to 1 along y; moved to the rim if the remaining seam would be
    shorter than an element."""


class RectangularBag(PanelBag):
    """Two rectangular panels sewn at the edges, divided into chambers of equal length along x by seams that join both
    panels and leave gaps: side and window bags (LS-DYNA paper, example 3). Flat on the plane z = 0."""

    shape: Literal["rectangular"]
    """rectangular"""
    length: quantity("m", 0.05, 10.0) = 1.20
    """Length of the flat panels, along x."""
    width: quantity("m", 0.05, 5.0) = 0.40
    """Width of the flat panels, along y."""
    chambers: whole(1, 64, "chambers") = 1
    """Number of chambers."""
    mouth_chamber: whole(0, 64) = 1
    """Chamber with the inflator's mouth, in the middle of its rear panel; counted from 1 at the lowest x."""
    mouth_offset: tuple[Offset, Offset] = (0.0, 0.0)
    """Position of the mouth's centre relative to the middle of its chamber (x, y)."""
    openings: Openings = Openings()
    vents: ChamberVents = ChamberVents()
    straps: tuple[PanelStrap, ...] = ()
