"""The `[bag]` table: which kind of bag, its size and mesh, vents, straps, seams, layers, warp direction."""

from __future__ import annotations

import math
from typing import ClassVar, Literal

from billow.case.gas.factor import over_either, over_time
from billow.case.quantity import Strict, quantity, whole

Length = quantity("m", 1e-4, 10.0)
Offset = quantity("m", -10.0, 10.0)
Fraction = quantity("-", 0.0, 1.0)
Pressure = quantity("Pa", 0.0, 1e7)
Angle = quantity("deg", -180.0, 180.0)
Layers = quantity("-", 1.0, 20.0)
Panel = Literal["front", "rear"]


class VentFlow(Strict):
    """How gas leaves through the vents; the same for all vents of a bag."""

    discharge: over_time("-", 0.0, 1.0) = 0.7
    """Discharge coefficient: a number, or a curve against time."""
    area_factor: over_either("-", 0.0, 100.0) = 1.0
    """Factor on the area of the hole: a number, or a curve against time or against gauge pressure."""
    opening_pressure: Pressure = 0.0
    """Gauge pressure at which a vent opens and stays open."""
    burst_time: quantity("s", 0.0, 10.0) = 0.0
    """Latest time at which a vent opens; 0 if only the pressure decides. With an opening_pressure of 0 the vent stays
    closed until then."""
    blockage: bool = False
    """Whether contact with an obstacle closes a vent, in proportion to the share of its rim in contact."""
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

    chambers: tuple[int, ...] = ()
    """Chambers with a vent, counted from 1 at the lowest x."""
    diameter: quantity("m", 1e-3, 0.2) = 0.035
    """Diameter of each hole."""
    offset: tuple[Offset, Offset] = (0.0, 0.0)
    """Position of its centre relative to the middle of its chamber (x, y)."""
    panel: Panel = "rear"
    """Panel they are cut into."""

    @property
    def count(self) -> int:
        return len(self.chambers)


class StrapCloth(Strict):
    """Material of straps, and when they pull."""

    length: quantity("m", 0.01, 2.0) | Literal["start"] = "start"
    """Unstretched length; start: the distance of its ends at the start."""
    slack: quantity("m", 0.0, 1.0) = 0.0
    """Added to the length: the strap pulls only beyond it."""
    width: quantity("m", 1e-3, 0.5) = 0.06
    """Width of each strap."""
    stiffness: quantity("N", 0.0, 1e7) = 0.0
    """Tension per strain of the whole strap; 0 to use the bag's fabric along the warp."""
    failure: quantity("N", 0.0, 1e6) = 0.0
    """Tension of the whole strap at which it tears; 0 for never."""


class Straps(StrapCloth):
    """Straps (tethers) from the retainer ring to a stitch line on the front panel, by default cut from the bag's
    fabric."""

    count: whole(0, 24, "straps") = 4
    """Number of straps."""
    length: quantity("m", 0.01, 2.0) | Literal["start"] = 0.28
    """Unstretched length; start: the distance of its ends at the start."""
    stitch_radius: quantity("m", 1e-3, 2.0) = 0.08
    """Radius of the stitch line on the front panel."""


class PanelStrap(StrapCloth):
    """A strap from a point of the front panel to a point of the rear panel."""

    front: tuple[Offset, Offset]
    """Its end on the front panel (x, y), relative to the middle of the bag; the nearest node is used."""
    rear: tuple[Offset, Offset]
    """Its end on the rear panel."""


class Seam(Strict):
    """Seams: fabric lies in several layers beside the stitching, at the rim and where panels are sewn together."""

    width: quantity("m", 0.0, 0.1) = 0.008
    """Width of the allowance in each panel."""
    layers: Layers = 2.0
    """Layers of fabric there; 1 means only the panel itself."""


class Reinforcement(Strict):
    """A ring of extra fabric sewn onto a panel, about the bag's axis."""

    panel: Panel = "rear"
    """Panel it is sewn to."""
    inner: quantity("m", 0.0, 5.0) = 0.0
    """Inner radius."""
    outer: quantity("m", 1e-3, 5.0) = 0.10
    """Outer radius."""
    layers: Layers = 2.0
    """Layers of fabric there, including the panel itself."""


class WarpAngle(Strict):
    """Direction of the warp in each panel, from the x axis towards the y axis."""

    front: Angle = 0.0
    """Front panel."""
    rear: Angle = 0.0
    """Rear panel."""


class PanelBag(Strict):
    """Settings common to bags of two sewn panels."""

    size_key: ClassVar[str]
    """The key that determines the size of the bag."""
    element_size: quantity("m", 5e-4, 0.2) = 0.010
    """Approximate edge length of the triangles."""
    mouth_radius: quantity("m", 5e-3, 1.0) = 0.05
    """Radius of the retainer ring; fabric on it and inside is held fixed."""
    initial_gap: quantity("m", 1e-5, 0.2) = 0.002
    """Greatest height of the front panel above the rear panel at the start."""
    coated: tuple[Panel, ...] = ()
    """Panels that let no gas through, whatever fabric.permeability says."""
    seam: Seam = Seam()
    warp_angle: WarpAngle = WarpAngle()


class DriverBag(PanelBag):
    """Driver bag: two round panels sewn at the rim, lying flat on the plane z = 0, mouth and vents in the rear
    panel."""

    shape: Literal["driver"] = "driver"
    """driver"""
    size_key: ClassVar[str] = "bag.diameter"
    diameter: quantity("m", 0.05, 5.0) = 0.70
    """Diameter of the flat panels."""
    reinforcements: tuple[Reinforcement, ...] = ()
    vents: Vents = Vents()
    straps: Straps = Straps()

    @property
    def panel_area(self) -> float:
        """[m^2], of one flat panel."""
        return 0.25 * math.pi * self.diameter**2


class SquareBag(PanelBag):
    """Two square panels sewn at the edges, lying flat on the plane z = 0, mouth in the middle of the rear panel
    (LS-DYNA paper, examples 1 and 2)."""

    shape: Literal["square"]
    """square"""
    size_key: ClassVar[str] = "bag.side"
    side: quantity("m", 0.05, 5.0) = 0.60
    """Side of the flat panels."""
    reinforcements: tuple[Reinforcement, ...] = ()
    vents: PanelVents = PanelVents()
    straps: tuple[PanelStrap, ...] = ()

    @property
    def panel_area(self) -> float:
        """[m^2], of one flat panel."""
        return self.side**2


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
    size_key: ClassVar[str] = "bag.length"
    length: quantity("m", 0.05, 10.0) = 1.20
    """Length of the flat panels, along x."""
    width: quantity("m", 0.05, 5.0) = 0.40
    """Width of the flat panels, along y."""
    chambers: whole(1, 64, "chambers") = 1
    """Number of chambers."""
    mouth_chamber: int = 1
    """Chamber with the inflator's mouth, in the middle of its rear panel; counted from 1 at the lowest x."""
    mouth_radius: quantity("m", 5e-3, 1.0) = 0.05
    """Radius of the retainer ring; fabric on it and inside is held fixed."""
    openings: Openings = Openings()
    vents: ChamberVents = ChamberVents()
    straps: tuple[PanelStrap, ...] = ()

    @property
    def panel_area(self) -> float:
        """[m^2], of one flat panel."""
        return self.length * self.width
