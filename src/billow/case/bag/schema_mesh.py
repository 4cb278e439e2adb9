"""The `[bag]` table of a bag of any shape, read from mesh files."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, field_validator

from billow.case.bag.quantities import Angle, Layers, Node, NodePairs
from billow.case.bag.schema_straps import StrapCloth
from billow.case.bag.schema_tear_seams import MeshTearSeam
from billow.case.bag.schema_vents import VentFlow
from billow.case.quantity import Name, Strict, Text, distinct, quantity, refused, unit_of_length, whole

ONE_TABLE_EACH = "write one [[bag.parts]] table for each part of the mesh"


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

    nodes: NodePairs
    """Pairs of nodes, counted from 0."""


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
