"""The `[bag]` table: which kind of bag, its size and mesh, vents, straps, seams, layers, warp direction."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, field_validator

from billow.base.units import CONVERSIONS
from billow.case.bag.schema_folds import Fold
from billow.case.quantity import (
    Name,
    Strict,
    Text,
    chosen_by,
    distinct,
    number_or_curve,
    quantity,
    refused,
    whole,
)

Length = quantity("m", 1e-4, 10.0)
Offset = quantity("m", -10.0, 10.0)
Fraction = quantity("-", 0.0, 1.0)
Pressure = quantity("Pa", 0.0, 1e7)
Angle = quantity("deg", -180.0, 180.0)
Layers = quantity("-", 1.0, 20.0)
Panel = Literal["front", "rear"]
Node = whole(-(10**7), 10**7)
MOST_FOLDS = 20
ONE_TABLE_EACH = "write one [[bag.parts]] table for each part of the mesh"


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

    chambers: tuple[whole(0, 64), ...] = ()
    """Chambers with a vent, counted from 1 at the lowest x."""
    diameter: quantity("m", 1e-3, 0.2) = 0.035
    """Diameter of each hole."""
    offset: tuple[Offset, Offset] = (0.0, 0.0)
    """Position of its centre relative to the middle of its chamber (x, y)."""
    panel: Panel = "rear"
    """Panel they are cut into."""


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
    folds: tuple[Fold, ...] = ()
    birth_time: quantity("s", 0.0, 0.1) = 0.0
    """Time over which the reference moves from the folded start to the flat cut; for rolls and folds in two
    directions, which stretch the outer layers."""

    @field_validator("folds")
    @classmethod
    def _few(cls, value):
        if len(value) > MOST_FOLDS:
            raise refused(f"the bag has {len(value)} folds; at most {MOST_FOLDS} are allowed", "write fewer folds")
        return value


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


def _unit(value: str) -> str:
    if value not in CONVERSIONS["m"]:
        raise refused("it is no unit of length", f"use one of {', '.join(CONVERSIONS['m'])}", kind="unit")
    return value


class MeshPart(Strict):
    """What a part of the mesh is."""

    name: Name
    """Name in results."""
    number: whole(-(2**31), 2**31 - 1) = -1
    """Number of the part in the mesh file; -1 for the part that the file gives this name."""
    kind: Literal["fabric", "mouth", "vent", "opening"] = "fabric"
    """fabric, or what its virtual triangles close: the inflator's mouth, a vent, or an opening between two chambers."""
    behind: Name = "bag"
    """Chamber behind it, on the side that its normals point away from."""
    ahead: Name = "ambient"
    """Chamber ahead of it; ambient for the surroundings."""
    warp_angle: Angle = 0.0
    """Direction of the warp in the flat cut, from the x axis towards the y axis."""
    seen_from: Literal["outside", "inside"] = "outside"
    """Side from which its flat cut is drawn."""
    layers: Layers = 1.0
    """Layers of fabric: factor on the thickness."""
    coated: bool = False
    """Whether it lets no gas through, whatever fabric.permeability says."""
    fixed: bool = False
    """Whether its nodes are fixed; those of a mouth always are."""


class MeshStrap(StrapCloth):
    """A strap between nodes of the mesh, with a bar for each pair."""

    nodes: tuple[tuple[Node, Node], ...]
    """Pairs of nodes, counted from 0."""

    @field_validator("nodes")
    @classmethod
    def _some(cls, value):
        if not value or any(a == b for a, b in value):
            raise refused("a strap joins two different nodes", "write pairs: nodes = [[12, 340], [13, 341]]")
        return value


class MeshBag(Strict):
    """Bag of any shape, read from a mesh of triangles and quads (VTK, STL, OBJ or PLY). Strain is measured against
    the reference, the pieces of fabric before sewing."""

    shape: Literal["mesh"]
    """mesh"""
    start: Text
    """File of the start shape; normals point out of the bag. Relative to the case file."""
    reference: Text = ""
    """File of the flat pieces: the cells of the start mesh in the same order, on its own nodes. Empty if the fabric was
    cut in the start shape."""
    frame: whole(-(10**6), 10**6) = 0
    """Which time of the start file to use, if it has several; -1 is the last."""
    unit: Annotated[str, AfterValidator(_unit)] = "m"
    """Unit of length in the files."""
    part_field: Text = "part"
    """Cell field with the number of each cell's part."""
    birth_time: quantity("s", 0.0, 0.1) = 0.0
    """Time over which the reference moves from the start shape to the flat cut, for a distorted start."""
    digest: Text = ""
    """SHA-256 of the files, filled in when a case file is read, so that a case always means the same bag."""
    parts: tuple[MeshPart, ...]
    fixed_nodes: tuple[Node, ...] = ()
    """Nodes that are fixed, counted from 0."""
    vents: VentFlow = VentFlow()
    straps: tuple[MeshStrap, ...] = ()

    _distinct = field_validator("parts")(distinct("parts", ONE_TABLE_EACH))

    @field_validator("parts")
    @classmethod
    def _some(cls, value):
        if not value:
            raise refused("a bag has at least one part", ONE_TABLE_EACH)
        return value


BAGS = {"driver": DriverBag, "square": SquareBag, "rectangular": RectangularBag, "mesh": MeshBag}
"""Table of each shape."""

Bag = chosen_by("shape", BAGS, default="driver")
