"""The `[bag]` table of a window bag."""

from __future__ import annotations

from typing import Literal

from billow.case.bag.quantities import Length
from billow.case.bag.schema_panels import PanelBag
from billow.case.bag.schema_straps import PanelStrap
from billow.case.bag.schema_vents import ChamberVents
from billow.case.quantity import quantity, whole


class WindowBag(PanelBag):
    """Window bag (curtain): two rectangular panels sewn at the edges, divided by seams along y into tubes that a
    gallery along the upper edge feeds; the mouth lies in the gallery. Each tube with its piece of the gallery is a
    chamber, open to the next. Flat on the plane z = 0."""

    shape: Literal["window"]
    """window"""
    length: quantity("m", 0.05, 10.0) = 1.40
    """Length of the flat panels, along x."""
    width: quantity("m", 0.05, 5.0) = 0.45
    """Width of the flat panels, along y, gallery included."""
    tubes: whole(2, 64, "tubes") = 8
    """Number of tubes."""
    gallery: Length = 0.12
    """Width of the gallery, at the highest y, into which seams do not reach."""
    mouth_radius: quantity("m", 5e-3, 1.0) = 0.03
    """Radius of the retainer ring, in the middle of the gallery; fabric on it and inside is held fixed."""
    mouth_tube: whole(0, 64) = 1
    """Tube above which the mouth lies, counted from 1 at the lowest x."""
    vents: ChamberVents = ChamberVents()
    straps: tuple[PanelStrap, ...] = ()
