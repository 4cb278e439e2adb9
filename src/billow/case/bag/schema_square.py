"""The `[bag]` table of a square bag."""

from __future__ import annotations

from typing import Literal

from billow.case.bag.schema_panels import PanelBag, Reinforcement
from billow.case.bag.schema_straps import PanelStrap
from billow.case.bag.schema_vents import PanelVents
from billow.case.quantity import quantity


class SquareBag(PanelBag):
    """Two square panels sewn at the edges, lying flat on the plane z = 0, mouth in the middle of the rear panel
    (LS-DYNA paper, examples 1 and 2)."""

    shape: Literal["square"]
    """square"""
    side: quantity("m", 0.05, 5.0) = 0.60
    """Side of the flat panels."""
    reinforcements: tuple[Reinforcement, ...] = ()
    vents: PanelVents = PanelVents()
    straps: tuple[PanelStrap, ...] = ()
