"""The `[bag]` table of a passenger bag."""

from __future__ import annotations

from typing import Literal

from billow.case.bag.schema_panels import PanelBag, Reinforcement
from billow.case.bag.schema_straps import PanelStrap
from billow.case.bag.schema_vents import PanelVents
from billow.case.quantity import quantity


class PassengerBag(PanelBag):
    """Bag of a passenger's size, about 110 l: two rectangular panels sewn at the edges, mouth in the middle of the rear
    panel. Flat on the plane z = 0."""

    shape: Literal["passenger"]
    """passenger"""
    length: quantity("m", 0.05, 10.0) = 0.80
    """Length of the flat panels, along x."""
    width: quantity("m", 0.05, 5.0) = 0.90
    """Width of the flat panels, along y."""
    mouth_radius: quantity("m", 5e-3, 1.0) = 0.07
    """Radius of the retainer ring; fabric on it and inside is held fixed."""
    reinforcements: tuple[Reinforcement, ...] = ()
    vents: PanelVents = PanelVents(count=2, diameter=0.06, distance=0.25)
    straps: tuple[PanelStrap, ...] = ()
