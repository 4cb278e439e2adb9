"""The `[bag]` table: which kind of bag, its size and mesh, vents, straps, seams, layers, warp direction."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, field_validator, model_validator

from billow.case.bag.schema_folds import Fold, Relax
from billow.case.quantity import (
    Name,
    Strict,
    Text,
    chosen_by,
    curve,
    distinct,
    number_or_curve,
    quantity,
    refused,
    unit_of_length,
    whole,
)

Length = quantity("m", 1e-4, 10.0)
Offset = quantity("m", -10.0, 10.0)
Fraction = quantity("-", 0.0, 1.0)
Pressure = quantity("Pa", 0.0, 1e7)
Angle = quantity("deg", -180.0, 180.0)
Layers = quantity("-", 1.0, 20.0)
Panel = Literal["front", "rear"]
Own = Literal["own"]
Node = whole(-(10**7), 10**7)
MOST_FOLDS = 20
ONE_TABLE_EACH = "write one [[bag.parts]] table for each part of the mesh"


def _pairs(value):
    """A validator of pairs of nodes."""
    if not value or any(a == b for a, b in value):
        raise refused("two different nodes are joined", "write pairs: nodes = [[12, 340], [13, 341]]")
    return value


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
    """Its end on the front panel (x, y), relative to the middle of the bag; the nearest node is used, at most an
    element away."""
    rear: tuple[Offset, Offset]
    """Its end on the rear panel."""


class TearStrength(Strict):
    """A tear seam: when it tears, and how stiff it is until then."""

    name: Name = "tear_seam"
    """Name in results."""
    strength: quantity("N/m", 0.0, 1e6) | curve("N/m", 0.0, 1e6, "loading_rate")
    """Force per length of seam at which it tears: a number, or a curve against the rate of loading, which is the mean
    since the stitch there went taut."""
    stiffness: quantity("N/m^2", 0.0, 1e10) = 0.0
    """Force per length of seam and opening; 0 for that of a row of elements of the bag's fabric."""


class PanelTearSeam(TearStrength):
    """A straight seam that joins front and rear panel until it tears; nodes of both panels near the line are tied."""

    begin: tuple[Offset, Offset]
    """Its beginning (x, y), relative to the middle of the bag."""
    end: tuple[Offset, Offset]
    """Its end."""


class MeshTearSeam(TearStrength):
    """A seam of tied nodes of the mesh."""

    nodes: tuple[tuple[Node, Node], ...]
    """Pairs of nodes, counted from 0, in their order along the seam."""

    _some = field_validator("nodes")(_pairs)


class Cover(TearStrength):
    """A cover of fabric over the bag: two flaps, held at their outer edges and joined by a tear seam along y."""

    name: Name = "cover"
    """Name of its fabric and of its seam in results."""
    place: tuple[Offset, Offset, Offset]
    """Its middle (x, y, z)."""
    length: Length
    """Distance of the edges that are held, along x."""
    width: Length
    """Length of the seam, along y."""
    element_size: quantity("m", 5e-4, 0.2) = 0.010
    """Approximate edge length of its triangles."""
    layers: Layers = 2.0
    """Layers of the bag's fabric."""


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
    tear_seams: tuple[PanelTearSeam, ...] = ()
    covers: tuple[Cover, ...] = ()
    birth_time: quantity("s", 0.0, 0.1) = 0.0
    """Time over which the reference moves from the folded start to the flat cut; for rolls and folds in two
    directions, which stretch the outer layers."""

    _distinct_seams = field_validator("tear_seams")(distinct("tear seams"))
    _distinct_covers = field_validator("covers")(distinct("covers"))

    @field_validator("folds")
    @classmethod
    def _few(cls, value):
        if len(value) > MOST_FOLDS:
            raise refused(f"the bag has {len(value)} folds; at most {MOST_FOLDS} are allowed", "write fewer folds")
        if any(fold.kind == "relax" for fold in value[:-1]) or (value and value[0].kind == "relax"):
            raise refused("relax has to follow all folds", 'write kind = "relax" as the last table, after a fold')
        return value

    @model_validator(mode="after")
    def _one_ramp(self):
        if self.relax is not None and self.birth_time:
            raise refused(
                'the flat cut comes in twice: by a fold of kind "relax" and by birth_time', "remove one of them"
            )
        return self

    @property
    def relax(self) -> Relax | None:
        """How the folded bag comes to rest before it deploys, if it does."""
        return self.folds[-1] if self.folds and self.folds[-1].kind == "relax" else None


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

    _some = field_validator("nodes")(_pairs)


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
    unit: Annotated[str, AfterValidator(unit_of_length)] = "m"
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
    tear_seams: tuple[MeshTearSeam, ...] = ()

    _distinct_seams = field_validator("tear_seams")(distinct("tear seams"))
    _distinct = field_validator("parts")(distinct("parts", ONE_TABLE_EACH))

    @field_validator("parts")
    @classmethod
    def _some(cls, value):
        if not value:
            raise refused("a bag has at least one part", ONE_TABLE_EACH)
        return value


MOVABLE = {
    "bag.diameter": "diameter",
    "bag.mouth_radius": "mouth_radius",
    "bag.vents.diameter": "vent_diameter",
    "bag.vents.distance": "vent_radius",
    "bag.straps.stitch_radius": "stitch_radius",
}
"""Sizes of a driver bag that its mesh can be moved to -> their key in `MeshOf`."""

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
