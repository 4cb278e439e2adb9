"""The `[bag]` table of a tube."""

from __future__ import annotations

from typing import Literal

from billow.case.bag.quantities import Length
from billow.case.bag.schema_panels import PanelBag
from billow.case.bag.schema_straps import PanelStrap
from billow.case.bag.schema_vents import PanelVents
from billow.case.quantity import quantity


class TubeBag(PanelBag):
    """A tube lying flat on the plane z = 0, sewn all around, with the mouth near its end at the lowest x (LS-DYNA
    paper, example 4)."""

    shape: Literal["tube"]
    """tube"""
    length: quantity("m", 0.05, 10.0) = 1.00
    """Length of the flat tube, along x."""
    width: quantity("m", 0.02, 5.0) = 0.16
    """Flat width, along y: half of its girth."""
    mouth_radius: quantity("m", 5e-3, 1.0) = 0.04
    """Radius of the retainer ring; fabric on it and inside is held fixed."""
    mouth_distance: Length = 0.08
    """Distance of the mouth's centre from the end."""
    vents: PanelVents = PanelVents()
    straps: tuple[PanelStrap, ...] = ()
