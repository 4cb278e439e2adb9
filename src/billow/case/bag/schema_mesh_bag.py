"""The `[bag]` table of a bag that is read from mesh files."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, field_validator

from billow.base.units import CONVERSIONS
from billow.case.bag.schema_bag import Angle, Layers, StrapCloth, VentFlow
from billow.case.quantity import Strict, quantity, refused
from billow.case.text import Name, Text


def _unit(value: str) -> str:
    if value not in CONVERSIONS["m"]:
        raise refused("it is no unit of length", f"use one of {', '.join(CONVERSIONS['m'])}", kind="unit")
    return value


class MeshPart(Strict):
    """What a part of the mesh is."""

    name: Name
    """Name in results."""
    number: int = -1
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

    nodes: tuple[tuple[int, int], ...]
    """Pairs of nodes, counted from 0."""

    @field_validator("nodes")
    @classmethod
    def _some(cls, value):
        if not value or any(a == b for a, b in value):
            raise refused("a strap joins two different nodes", "write pairs: nodes = [[12, 340], [13, 341]]")
        return value


class MeshBag(Strict):
    """Bag of any shape, read from a mesh of triangles and quads (.vtkhdf or .vtk). Strain is measured against
    the reference, the pieces of fabric before sewing."""

    shape: Literal["mesh"]
    """mesh"""
    size_key: ClassVar[str] = "bag.unit"
    start: Text
    """File of the start shape; normals point out of the bag. Relative to the case file."""
    reference: Text = ""
    """File of the flat pieces: the cells of the start mesh in the same order, on its own nodes. Empty if the fabric was
    cut in the start shape."""
    frame: int = 0
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
    fixed_nodes: tuple[int, ...] = ()
    """Nodes that are fixed, counted from 0."""
    vents: VentFlow = VentFlow()
    straps: tuple[MeshStrap, ...] = ()

    @field_validator("parts")
    @classmethod
    def _distinct(cls, value):
        names = [part.name for part in value]
        if not names or len(set(names)) != len(names):
            reason = f"two parts are called {max(names, key=names.count)}" if names else "a bag has at least one part"
            raise refused(reason, "write one [[bag.parts]] table for each part of the mesh")
        return value
