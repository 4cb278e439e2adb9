"""From the `[bag]` table of shape mesh to a `BagShape`, and the files it names."""

from __future__ import annotations

import hashlib
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from billow.base.errors import InputError
from billow.base.units import CONVERSIONS
from billow.case.bag import schema_mesh_bag
from billow.case.bag.build_straps import strap_line
from billow.geometry.bag_shapes import BagShape
from billow.geometry.mesh_bag import MeshPart, mesh_bag, require_nodes
from billow.geometry.mesh_file import LARGEST_FILE, CellMesh, read_mesh

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


def settle_files(data: Any, folder: Path) -> None:
    """Make the paths of a case's mesh files absolute, counted from the case file's folder, and note their digest."""
    bag = data.get("bag") if isinstance(data, dict) else None
    if not isinstance(bag, dict) or bag.get("shape") != "mesh":
        return
    for key in ("start", "reference"):
        if isinstance(bag.get(key), str) and bag[key]:
            bag[key] = str((folder / bag[key]).absolute())
    if "digest" not in bag and isinstance(bag.get("start"), str):
        bag["digest"] = files_digest(bag["start"], bag.get("reference", ""))


def files_digest(*paths: Any) -> str:
    """SHA-256 over the contents of files; empty if one cannot be read, which `read_mesh` then explains."""
    digest = hashlib.sha256()
    try:
        for path in filter(None, paths):
            if not Path(path).is_file() or Path(path).stat().st_size > LARGEST_FILE:
                return ""
            with open(path, "rb") as file:
                digest.update(hashlib.file_digest(file, "sha256").digest())
    except (OSError, ValueError, TypeError):
        return ""
    return digest.hexdigest()


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
