"""The `[bag]` table: which kind of bag; a file for each kind, and for what several have in common."""

from __future__ import annotations

from billow.case.bag.schema_driver import MOVABLE, DriverBag
from billow.case.bag.schema_mesh import MeshBag
from billow.case.bag.schema_panels import PanelBag
from billow.case.bag.schema_passenger import PassengerBag
from billow.case.bag.schema_rectangular import RectangularBag
from billow.case.bag.schema_square import SquareBag
from billow.case.bag.schema_straps import PanelStrap, StrapCloth
from billow.case.bag.schema_tear_seams import TearStrength
from billow.case.bag.schema_tube import TubeBag
from billow.case.bag.schema_vents import PanelVents, VentFlow, Vents
from billow.case.bag.schema_window import WindowBag
from billow.case.quantity import chosen_by

__all__ = [
    "BAGS", "MOVABLE", "Bag", "DriverBag", "MeshBag", "PanelBag", "PanelStrap", "PanelVents", "PassengerBag",
    "RectangularBag", "SquareBag", "StrapCloth", "TearStrength", "TubeBag", "VentFlow", "Vents", "WindowBag",
]  # fmt: skip

BAGS = {
    "driver": DriverBag,
    "square": SquareBag,
    "rectangular": RectangularBag,
    "window": WindowBag,
    "tube": TubeBag,
    "passenger": PassengerBag,
    "mesh": MeshBag,
}
"""Table of each shape."""

Bag = chosen_by("shape", BAGS, default="driver")
