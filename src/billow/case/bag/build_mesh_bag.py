"""From the `[bag]` table of shape mesh to a `BagShape`."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from billow.base.errors import InputError
from billow.base.units import CONVERSIONS
from billow.case.bag import schema_mesh_bag
from billow.case.bag.build_straps import strap_line
from billow.case.named_files import files_digest
from billow.geometry.bag_shapes import BagShape
from billow.geometry.mesh_bag import MeshPart, mesh_bag, require_nodes
from billow.geometry.mesh_file import CellMesh, read_mesh

FILES_CHANGED = InputError.declare(
    "E-GEO-035",
    "the bag's mesh files are not those the case was made with",
    why="their SHA-256 is not that in bag.digest",
    cause="a file that was edited or replaced while a study or an interrupted run still needs it",
    remedy="bring the files back, or remove bag.digest to use them as they are now",
)


def build_mesh_shape(bag: schema_mesh_bag.MeshBag) -> BagShape:
    """The bag of mesh files. Raises InputError E-GEO-030..035 and those of `mesh_bag`."""
    if bag.digest and bag.digest != files_digest(bag.start, bag.reference):
        raise FILES_CHANGED(
            where=f"bag.start = {bag.start!r}" + (f", bag.reference = {bag.reference!r}" if bag.reference else "")
        )
    start = _scaled(read_mesh(bag.start, bag.part_field, bag.frame), bag.unit)
    reference = _scaled(read_mesh(bag.reference, bag.part_field), bag.unit) if bag.reference else None
    shape = mesh_bag(start, reference, tuple(map(_part, bag.parts)), bag.fixed_nodes)
    straps = []
    for k, strap in enumerate(bag.straps):
        bars = require_nodes(np.array(strap.nodes), len(start.points), f"bag.straps, strap {k + 1}")
        straps.append(strap_line(strap, bars, start.points))
    return replace(shape, straps=tuple(straps))


def _scaled(mesh: CellMesh, unit: str) -> CellMesh:
    return replace(mesh, points=mesh.points * CONVERSIONS["m"][unit])


def _part(part: schema_mesh_bag.MeshPart) -> MeshPart:
    return MeshPart(
        name=part.name,
        number=None if part.number == -1 else part.number,
        kind=part.kind,
        warp_angle=math.radians(part.warp_angle),
        layers=part.layers,
        leak=0.0 if part.coated else 1.0,
        behind=part.behind,
        ahead=part.ahead,
        fixed=part.fixed,
        from_inside=part.seen_from == "inside",
    )
