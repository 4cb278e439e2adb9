"""A bag of any shape: a start mesh, and the flat pieces it was sewn from (docs/theory.md, Reference shape)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.geometry.bag_shapes import BagShape, along_warp
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.flat_cut import flat_cut
from billow.geometry.mesh_file import CellMesh
from billow.geometry.reference_check import require_unmirrored
from billow.geometry.surface import Surface, area_vectors
from billow.geometry.triangulation import diagonals, split

PARTS_DO_NOT_MATCH = InputError.declare(
    "E-GEO-032",
    "the parts of the mesh and those of the case do not match",
    where="bag.parts",
    cause="a part of the mesh without a [[bag.parts]] table, or a table without a part",
    remedy="add a [[bag.parts]] table for every part of the mesh, with its number",
)
REFERENCE_DOES_NOT_FIT = InputError.declare(
    "E-GEO-033",
    "the reference does not have the cells of the start mesh",
    where="bag.reference",
    cause="two meshes made separately, or one of them in another order",
    remedy="give both meshes the same cells in the same order; their nodes may differ",
)
NO_SUCH_NODE = InputError.declare(
    "E-GEO-034",
    "the mesh has no node {node}",
    why="it has {count} nodes, counted from 0",
    cause="a node counted from 1, or a number from another mesh",
    remedy="correct it; ParaView shows node numbers as point ids",
)

AMBIENT = "ambient"
"""Stands for the surroundings where a part names the chamber on one of its sides."""


@dataclass(frozen=True)
class MeshPart:
    """What a part is: name and number in the file (None: the number the file gives that name), kind (one of
    surface.PART_KINDS), warp angle [rad] in the flat cut, layers and permeability in units of the fabric's own, names
    of the chambers behind and ahead, whether its nodes are fixed, whether its flat cut is drawn as seen from inside."""

    name: str
    number: int | None = None
    kind: str = "fabric"
    warp_angle: float = 0.0
    layers: float = 1.0
    leak: float = 1.0
    behind: str = "bag"
    ahead: str = AMBIENT
    fixed: bool = False
    from_inside: bool = False


def mesh_bag(
    start: CellMesh, reference: CellMesh | None, parts: tuple[MeshPart, ...], fixed_nodes: tuple[int, ...] = ()
) -> BagShape:
    """The shape of a start mesh whose fabric was cut as in the reference; without one, as in the start itself.

    Points in metres. Nodes of mouths and of parts that are fixed stay where they are, and so do fixed_nodes.
    Raises InputError E-GEO-032 (parts of file and case do not match), E-GEO-033 (the reference does not fit),
    E-GEO-034 (no such node), E-GEO-036 and E-GEO-037 (a panel is mirrored).
    """
    which, reference = _part_of_cells(start, parts), reference or start
    _require_same_cells(start, reference)
    diagonal = diagonals(start.cells, len(start.points))
    (triangles, owner), (flat_triangles, _) = split(start.cells, diagonal), split(reference.cells, diagonal)
    part = which[owner]
    flat = np.zeros((len(triangles), 3, 2))
    layers, leak = np.ones(len(triangles)), np.ones(len(triangles))
    for k, one in enumerate(parts):
        mine = np.flatnonzero(part == k)
        if one.kind != "opening":
            flat[mine] = flat_cut(reference.points, flat_triangles[mine])
        layers[mine], leak[mine] = one.layers, one.leak
    surface = Surface.build(
        triangles, part, tuple(p.name for p in parts), len(start.points),
        part_kinds=tuple(p.kind for p in parts), chambers=_chambers(parts, part),
    )  # fmt: skip
    fixed = np.zeros(len(start.points), dtype=bool)
    held = [k for k, one in enumerate(parts) if one.fixed or one.kind == "mouth"]
    fixed[triangles[np.isin(part, held)]] = True
    fixed[require_nodes(fixed_nodes, len(start.points), "bag.fixed_nodes")] = True
    mouth = surface.triangles_of_kind("mouth")
    centre, axis = _mouth(triangles[mouth], start.points)
    shape = BagShape(
        surface, start.points, flat, fixed, (), centre, axis, layers, leak,
        seen_from_inside=tuple(one.name for one in parts if one.from_inside), azimuths_from=None,
    )  # fmt: skip
    angles = {one.name: one.warp_angle for one in parts if one.kind != "opening"}
    shape = along_warp(shape, angles)
    require_unmirrored(shape, angles)
    return shape


def require_nodes(nodes: tuple[int, ...] | np.ndarray, node_count: int, where: str) -> np.ndarray:
    """Node numbers as an array of int64. Raises InputError E-GEO-034 if there is no such node."""
    wrong = [n for n in np.ravel(nodes).tolist() if not 0 <= n < node_count]
    if wrong:
        raise NO_SUCH_NODE(where=where, node=wrong[0], count=node_count)
    return np.asarray(nodes, dtype=np.int64)


def _part_of_cells(mesh: CellMesh, parts: tuple[MeshPart, ...]) -> np.ndarray:
    """Index into parts of each cell's part."""
    numbers = [mesh.part_names.get(p.name) if p.number is None else p.number for p in parts]
    known = [f"{number} ({name})" for name, number in mesh.part_names.items()] or np.unique(mesh.part).tolist()
    listed = ", ".join(map(str, known[:20])) + (" and more" if len(known) > 20 else "")

    for one, number in zip(parts, numbers, strict=True):
        if number is None or number not in mesh.part:
            what = f"the mesh has no part called {one.name!r}" if number is None else f"the mesh has no part {number}"
            raise PARTS_DO_NOT_MATCH(
                what=what,
                where=f"bag.parts, part {one.name}",
                why=f"its parts are {listed}",
                remedy="correct the number of that part",
            )
    for k, number in enumerate(numbers):
        if number in numbers[:k]:
            twice = f"{parts[numbers.index(number)].name} and {parts[k].name}"
            raise PARTS_DO_NOT_MATCH(
                what=f"{twice} are the same part", why=f"both have number {number}", remedy="correct one of the numbers"
            )
    missing = np.setdiff1d(mesh.part, numbers)
    if len(missing):
        raise PARTS_DO_NOT_MATCH(
            what=f"part {missing[0]} of the mesh is not described", why=f"the parts of the mesh are {listed}"
        )
    order = np.argsort(numbers)
    return order[np.searchsorted(np.array(numbers)[order], mesh.part)]


def _require_same_cells(start: CellMesh, reference: CellMesh) -> None:
    cells, others = len(start.cells), len(reference.cells)
    if cells != others:
        raise REFERENCE_DOES_NOT_FIT(why=f"the start has {cells} cells, the reference {others}")
    if ((start.cells[:, 3] < 0) != (reference.cells[:, 3] < 0)).any():
        raise REFERENCE_DOES_NOT_FIT(why="a triangle of one is a quad of the other")
    if not np.array_equal(start.part, reference.part):
        cell = int(np.argmax(start.part != reference.part))
        here, there = start.part[cell], reference.part[cell]
        raise REFERENCE_DOES_NOT_FIT(
            what=f"cell {cell} belongs to part {here} at the start, to part {there} in the reference",
            why="cells are matched by their order, so one of the files is in another order",
        )


def _chambers(parts: tuple[MeshPart, ...], part: np.ndarray) -> Chambers:
    names = tuple(dict.fromkeys(name for p in parts for name in (p.behind, p.ahead) if name != AMBIENT))
    index = {AMBIENT: OUTSIDE, **{name: k for k, name in enumerate(names)}}
    sides = np.array([[index[p.behind], index[p.ahead]] for p in parts], dtype=np.int32)
    return Chambers(names, sides[part, 0], sides[part, 1])


def _mouth(triangles: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre [m] and unit axis into the bag of the mouth; the origin and z without one."""
    areas = area_vectors(triangles, points)
    size = np.linalg.norm(areas, axis=1)
    total = np.linalg.norm(areas.sum(axis=0))
    if not total > 0.0:
        return np.zeros(3), np.array([0.0, 0.0, 1.0])
    return size @ points[triangles].mean(axis=1) / size.sum(), -areas.sum(axis=0) / total
