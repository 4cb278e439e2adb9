"""The `[bag]` table of a driver bag."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from billow.case.bag.quantities import Length
from billow.case.bag.schema_panels import PanelBag, Reinforcement
from billow.case.bag.schema_straps import PanelStrap, Straps
from billow.case.bag.schema_vents import Vents
from billow.case.quantity import Strict, quantity, refused

Own = Literal["own"]


class MeshOf(Strict):
    """Sizes for which the mesh is made before it is moved to the bag's own, so that bags of different sizes have the
    same nodes and triangles; own: the bag's own size. A study that varies sizes fills this in."""

    diameter: quantity("m", 0.05, 5.0) | Own = "own"
    """As bag.diameter."""
    mouth_radius: quantity("m", 5e-3, 1.0) | Own = "own"
    """As bag.mouth_radius."""
    vent_diameter: quantity("m", 1e-3, 0.2) | Own = "own"
    """As bag.vents.diameter."""
    vent_radius: Length | Own = "own"
    """As bag.vents.distance."""
    stitch_radius: quantity("m", 1e-3, 2.0) | Own = "own"
    """As bag.straps.stitch_radius."""


class DriverBag(PanelBag):
    """Driver bag: two round panels sewn at the rim, lying flat on the plane z = 0, mouth and vents in the rear
    panel."""

    shape: Literal["driver"] = "driver"
    """driver"""
    diameter: quantity("m", 0.05, 5.0) = 0.70
    """Diameter of the flat panels."""
    reinforcements: tuple[Reinforcement, ...] = ()
    vents: Vents = Vents()
    straps: Straps = Straps()
    tethers: tuple[PanelStrap, ...] = ()
    mesh_of: MeshOf = MeshOf()

    @model_validator(mode="after")
    def _moves_flat(self):
        if self.folds and self.mesh_of != MeshOf():
            raise refused("a folded bag has its nodes on its folds, so its mesh cannot be moved", "remove bag.mesh_of")
        return self


MOVABLE = {
    "bag.diameter": "diameter",
    "bag.mouth_radius": "mouth_radius",
    "bag.vents.diameter": "vent_diameter",
    "bag.vents.distance": "vent_radius",
    "bag.straps.stitch_radius": "stitch_radius",
}
"""Sizes of a driver bag that its mesh can be moved to -> their key in `MeshOf`."""
