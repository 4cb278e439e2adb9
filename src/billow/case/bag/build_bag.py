"""From the `[bag]` table to a `BagShape`, and from its straps to bars of fabric."""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np

from billow.base.errors import InputError
from billow.base.plausible import require_possible
from billow.base.units import CONVERSIONS
from billow.case.bag import schema_bag
from billow.case.bag.build_folds import build_plan
from billow.case.bag.build_tear_seams import panel_tear_lines, tear_line
from billow.case.named_files import files_digest
from billow.geometry.bag_shapes import DOES_NOT_FIT, BagShape, StrapLine, along_warp
from billow.geometry.cover import covered
from billow.geometry.crossings import FARTHEST
from billow.geometry.driver_bag import driver_bag
from billow.geometry.driver_sizes import DriverSizes, resized
from billow.geometry.folding.fold_plan import FoldPlan
from billow.geometry.local_thickness import doubled, rim_depth, ring_depth
from billow.geometry.mesh_bag import MeshPart, mesh_bag, require_nodes
from billow.geometry.mesh_file import CellMesh, read_mesh
from billow.geometry.rectangle_mesh import NO_ROWS
from billow.geometry.rectangular_bag import FRONT, REAR, Gap, PanelVent, Seam, mouth_centre, rectangular_bag
from billow.parts.fabric.membrane import FabricLaw
from billow.parts.straps import NO_STRAPS, Straps

TOO_MANY_TRIANGLES = InputError.declare(
    "E-GEO-011",
    "the mesh would have about {triangles:.2g} triangles",
    where="bag.element_size, {size_key}",
    why="at most {most} are allowed, to fit into memory; a length may be in another unit",
    remedy="raise bag.element_size to {needed:.2g} m or more",
)
NO_SUCH_CHAMBER = InputError.declare(
    "E-GEO-012",
    "the bag has no chamber {chamber}",
    where="bag.{key}",
    why="it has {count}, counted from 1 at the lowest x",
    remedy="correct bag.{key}, or raise bag.chambers",
)
FILES_CHANGED = InputError.declare(
    "E-GEO-035",
    "the bag's mesh files are not those the case was made with",
    why="their SHA-256 is not that in bag.digest",
    cause="a file that was edited or replaced while a study or an interrupted run still needs it",
    remedy="bring the files back, or remove bag.digest to use them as they are now",
)

ANOTHER_UNIT = InputError.declare(
    "E-GEO-038",
    "the {larger} is {times:.4g} times as large as the {smaller}",
    where="bag.start, bag.reference",
    why="by the root of their areas; folding and sewing keep it, so one of the files is in another unit",
    cause="one file in metres, the other in millimetres",
    remedy="write both files in one unit, and name it in bag.unit",
)

TOO_FAR = InputError.declare(
    "E-GEO-039",
    "a node of the mesh lies {away:.4g} m from the origin",
    where="bag.start, {path}",
    why="results keep places in single precision, {rounding:.2g} mm there; at most {most:g} m are allowed",
    cause="a mesh in the coordinates of a plant or a map, a node that no cell uses, or a file in another unit",
    remedy="move the mesh to the origin, remove nodes without cells, or write bag.unit",
)
NO_NODE_THERE = InputError.declare(
    "E-GEO-061",
    "strap {strap} ends at ({x:g}, {y:g}) m, where the {panel} panel has no fabric",
    where="bag.{key}, strap {strap}",
    why="the nearest node is {away:.3g} mm away; a strap is sewn on at most an element away from where it shall be",
    cause="a point outside the panel or in a vent, or a length in another unit",
    remedy="move its end onto the panel",
)

MOST_TRIANGLES = 500_000
SHORTEST_STRAP = 1e-5
"""Length [m] below which a strap divides by next to nothing, and sets a step of nanoseconds."""
MOST_TIMES_LARGER = 8.0
"""Of sizes of start and reference: a start shape may be shrunk, but inch and centimetre differ by 2.5 from neighbours
in no bag; units that are confused differ by 10 or more."""


def build_shape(bag: schema_bag.Bag) -> BagShape:
    """The bag's geometry.

    Raises InputError E-GEO-010 (something does not fit), E-GEO-011 (too many triangles), E-GEO-012 (no such chamber),
    and of a mesh E-GEO-030..035, -038, -039 and those of `mesh_bag`.
    """
    return _mesh(bag) if isinstance(bag, schema_bag.MeshBag) else _ready_made(bag)


@functools.lru_cache(maxsize=1)
def _ready_made(bag: schema_bag.PanelBag) -> BagShape:
    """The last one is kept: a study tries many designs of one bag. Nobody writes to its arrays."""
    shape = MAKERS[bag.shape](bag)
    for ring in getattr(bag, "reinforcements", ()):
        shape = doubled(shape, (ring.panel,), ring_depth(ring.inner, ring.outer), ring.layers)
    leak = shape.leak.copy()
    for panel in bag.coated:
        leak[shape.surface.triangles_of(panel)] = 0.0
    angles = {FRONT: math.radians(bag.warp_angle.front), REAR: math.radians(bag.warp_angle.rear)}
    shape = along_warp(replace(shape, leak=leak), angles)
    shape = replace(shape, tear_lines=panel_tear_lines(bag, shape))
    plan = fold_plan(bag)
    shape = plan.applied(shape) if plan else shape
    for cover in bag.covers:
        place = np.array(cover.place)
        shape, ties = covered(shape, cover.name, place, cover.length, cover.width, cover.element_size, cover.layers)
        shape = replace(shape, tear_lines=(*shape.tear_lines, tear_line(cover, ties, shape)))
    return shape


def fold_plan(bag: schema_bag.Bag) -> FoldPlan | None:
    """How a bag is folded, None if it is not. InputError as `FoldPlan.of`, and E-GEO-012."""
    if not getattr(bag, "folds", ()):
        return None
    if isinstance(bag, schema_bag.DriverBag):
        length, width, mouth = bag.diameter, bag.diameter, (0.0, 0.0)
    elif isinstance(bag, schema_bag.SquareBag):
        length, width, mouth = bag.side, bag.side, (0.0, 0.0)
    else:
        length, width = bag.length, bag.width
        mouth = mouth_centre(length, *_mouth(bag))
    corner = np.array([0.5 * length, 0.5 * width])
    return build_plan(bag.folds, np.array([-corner, corner]), mouth, bag.mouth_radius, bag.element_size)


def _driver(bag: schema_bag.DriverBag) -> BagShape:
    _require_modest(bag, "bag.diameter", 0.25 * math.pi * bag.diameter**2)
    _require_apart(bag.vents)
    own = DriverSizes(bag.diameter, bag.mouth_radius, bag.vents.diameter, bag.vents.distance, bag.straps.stitch_radius)
    meshed = replace(own, **{key: size for key, size in bag.mesh_of if size != "own"})
    plan = fold_plan(bag)
    shape = driver_bag(
        diameter=meshed.diameter, element_size=bag.element_size, mouth_radius=meshed.mouth_radius,
        vent_count=bag.vents.count, vent_diameter=meshed.vent_diameter, vent_radius=meshed.vent_radius,
        strap_count=bag.straps.count, strap_width=bag.straps.width, strap_stitch_radius=meshed.stitch_radius,
        initial_gap=bag.initial_gap, folds=(plan.rows(0), plan.rows(1)) if plan else NO_ROWS,
        folded_last=plan.folded_last if plan else None,
    )  # fmt: skip
    if meshed != own:
        shape = resized(shape, meshed, own, bag.initial_gap)
    straps = tuple(strap_line(bag.straps, line.bars, shape.positions) for line in shape.straps)
    straps += _straps_of(bag.tethers, "tethers", shape, bag.element_size)
    rim = rim_depth(0.5 * bag.diameter, bag.element_size * bag.diameter / meshed.diameter, bag.seam.width)
    return doubled(replace(shape, straps=straps), (FRONT, REAR), rim, bag.seam.layers)


def _square(bag: schema_bag.SquareBag) -> BagShape:
    _require_modest(bag, "bag.side", bag.side**2)
    _require_apart(bag.vents)
    return _two_rectangles(bag, bag.side, bag.side, _around(bag.vents))


def _around(vents: schema_bag.PanelVents) -> list[tuple[float, float]]:
    """Centres of vents (x, y) [m] about the middle of the bag."""
    angles = 2.0 * np.pi * np.arange(vents.count) / max(vents.count, 1)
    return [(vents.distance * np.cos(a), vents.distance * np.sin(a)) for a in angles]


def _rectangular(bag: schema_bag.RectangularBag) -> BagShape:
    return _divided(bag, Gap(bag.openings.width, bag.openings.place))


def _window(bag: schema_bag.WindowBag) -> BagShape:
    if not bag.gallery < bag.width:
        raise DOES_NOT_FIT(
            part="the gallery",
            key="gallery",
            why=f"it is {bag.gallery:g} m wide, the whole bag {bag.width:g} m",
            remedy="reduce bag.gallery, or raise bag.width",
        )
    return _divided(bag, Gap(bag.gallery, 1.0))


def _divided(bag: schema_bag.RectangularBag | schema_bag.WindowBag, gap: Gap) -> BagShape:
    """A bag of chambers side by side."""
    _require_modest(bag, "bag.length", bag.length * bag.width)
    count, chamber, offset = _mouth(bag)
    room, (x, y) = bag.length / count, bag.vents.offset
    return _two_rectangles(
        bag, bag.length, bag.width, [((k - 0.5) * room - 0.5 * bag.length + x, y) for k in bag.vents.chambers],
        chambers=count, mouth_chamber=chamber, gap=gap, mouth_offset=offset,
    )  # fmt: skip


def _undivided(bag: schema_bag.TubeBag | schema_bag.PassengerBag) -> BagShape:
    """A rectangular bag of one chamber."""
    _require_modest(bag, "bag.length", bag.length * bag.width)
    _require_apart(bag.vents)
    return _two_rectangles(bag, bag.length, bag.width, _around(bag.vents), mouth_offset=_mouth(bag)[2])


def _mouth(bag: schema_bag.PanelBag) -> tuple[int, int, tuple[float, float]]:
    """Number of chambers side by side of a rectangular bag, that with the mouth, counted from 0, and the place of the
    mouth from its middle [m]. Raises InputError E-GEO-012 for the number of a chamber that the bag does not have."""
    if isinstance(bag, schema_bag.PassengerBag):
        return 1, 0, (0.0, 0.0)
    if isinstance(bag, schema_bag.TubeBag):
        return 1, 0, (bag.mouth_distance - 0.5 * bag.length, 0.0)
    is_window = isinstance(bag, schema_bag.WindowBag)
    key, count = ("mouth_tube", bag.tubes) if is_window else ("mouth_chamber", bag.chambers)
    mouth = getattr(bag, key)
    for where, chambers in ((key, (mouth,)), ("vents.chambers", bag.vents.chambers)):
        for chamber in chambers:
            if not 1 <= chamber <= count:
                raise NO_SUCH_CHAMBER(chamber=chamber, key=where, count=count)
    return count, mouth - 1, (0.0, 0.5 * (bag.width - bag.gallery)) if is_window else bag.mouth_offset


def _two_rectangles(
    bag: schema_bag.PanelBag,
    length: float,
    width: float,
    vents: list[tuple[float, float]],
    **divided: Any,
) -> BagShape:
    """vents: their centres (x, y) [m]. divided: the chambers, as `rectangular_bag` takes them."""
    hole, plan = bag.vents, fold_plan(bag)
    shape = rectangular_bag(
        length=length, width=width, element_size=bag.element_size, mouth_radius=bag.mouth_radius,
        initial_gap=bag.initial_gap, seam=Seam(bag.seam.width, bag.seam.layers),
        vents=tuple(PanelVent(float(x), float(y), 0.5 * hole.diameter, hole.panel) for x, y in vents),
        folds=(plan.rows(0), plan.rows(1)) if plan else NO_ROWS, **divided,
    )  # fmt: skip
    return replace(shape, straps=_straps_of(bag.straps, "straps", shape, bag.element_size))


def _straps_of(
    straps: tuple[schema_bag.PanelStrap, ...], key: str, shape: BagShape, size: float
) -> tuple[StrapLine, ...]:
    """Straps between the nodes nearest to their ends. Raises InputError E-GEO-061 if one is more than `size` away."""
    lines = []
    for k, strap in enumerate(straps):
        ends, moved = [], []
        for panel, point in ((FRONT, strap.front), (REAR, strap.rear)):
            node, away = _nearest(shape, panel, point)
            if away > size:
                raise NO_NODE_THERE(key=key, strap=k + 1, panel=panel, x=point[0], y=point[1], away=1e3 * away)
            ends.append(node)
            moved.append(away)
        line = strap_line(strap, np.array([ends]), shape.positions)
        lines.append(replace(line, moved=max(moved)))
    return tuple(lines)


def _mesh(bag: schema_bag.MeshBag) -> BagShape:
    if bag.digest and bag.digest != files_digest(bag.start, bag.reference):
        raise FILES_CHANGED(
            where=f"bag.start = {bag.start!r}" + (f", bag.reference = {bag.reference!r}" if bag.reference else "")
        )

    def scaled(mesh: CellMesh) -> CellMesh:
        return replace(mesh, points=mesh.points * CONVERSIONS["m"][bag.unit])

    start = scaled(read_mesh(bag.start, bag.part_field, bag.frame))
    reference = scaled(read_mesh(bag.reference, bag.part_field)) if bag.reference else None
    _require_one_unit(start, reference)
    change = 'write bag.unit = "{unit}"'
    for key, mesh in (("start", start), ("reference", reference)):
        if mesh is not None:
            require_possible(
                "bag size", mesh.size, f"the width of the mesh in bag.{key}", getattr(bag, key), change, bag.unit
            )
    if not (away := float(np.abs(start.points).max())) < FARTHEST:
        rounding = 1e3 * away * np.finfo(np.float32).eps
        raise TOO_FAR(away=away, path=bag.start, rounding=rounding, most=FARTHEST)
    parts = tuple(
        MeshPart(
            **part.model_dump(include={"name", "kind", "layers", "behind", "ahead", "fixed"}),
            number=None if part.number == -1 else part.number,
            warp_angle=math.radians(part.warp_angle),
            leak=0.0 if part.coated else 1.0,
            from_inside=part.seen_from == "inside",
        )
        for part in bag.parts
    )
    shape, straps = mesh_bag(start, reference, parts, bag.fixed_nodes), []
    for k, strap in enumerate(bag.straps):
        bars = require_nodes(np.array(strap.nodes), len(start.points), f"bag.straps, strap {k + 1}")
        straps.append(strap_line(strap, bars, start.points))
    seams = []
    for seam in bag.tear_seams:
        ties = require_nodes(np.array(seam.nodes), len(start.points), f"bag.tear_seams, seam {seam.name}")
        seams.append(tear_line(seam, ties, shape))
    return replace(shape, straps=tuple(straps), tear_lines=tuple(seams))


def _require_one_unit(start: CellMesh, reference: CellMesh | None) -> None:
    """Raises InputError E-GEO-038: fabric is not a multiple larger in its flat pieces than at the start."""
    if reference is None or not (start.area > 0.0 and reference.area > 0.0):
        return
    ratio = math.sqrt(reference.area / start.area)
    if max(ratio, 1.0 / ratio) > MOST_TIMES_LARGER:
        larger, smaller = ("reference", "start") if ratio > 1.0 else ("start", "reference")
        raise ANOTHER_UNIT(larger=larger, smaller=smaller, times=max(ratio, 1.0 / ratio))


MAKERS = {
    "driver": _driver,
    "square": _square,
    "rectangular": _rectangular,
    "window": _window,
    "tube": _undivided,
    "passenger": _undivided,
}


def _nearest(shape: BagShape, panel: str, point: tuple[float, float]) -> tuple[int, float]:
    """The node of a flat panel nearest to a point [m], and how far it is [m]."""
    nodes = np.unique(shape.surface.triangles[shape.surface.triangles_of(panel)]).astype(np.int64)
    away = np.linalg.norm(shape.positions[nodes, :2] - point, axis=1)
    return int(nodes[away.argmin()]), float(away.min())


def _require_modest(bag: schema_bag.PanelBag, size_key: str, panel_area: float) -> None:
    triangles = 2.0 * panel_area / (0.25 * np.sqrt(3.0) * bag.element_size**2)
    if triangles > MOST_TRIANGLES:
        needed = bag.element_size * np.sqrt(triangles / MOST_TRIANGLES)
        raise TOO_MANY_TRIANGLES(triangles=triangles, size_key=size_key, most=MOST_TRIANGLES, needed=needed)


def _require_apart(vents: schema_bag.Vents) -> None:
    apart = 2.0 * vents.distance * np.sin(np.pi / vents.count) if vents.count > 1 else np.inf
    if apart <= vents.diameter:
        raise DOES_NOT_FIT(
            what="the vents overlap",
            key="vents",
            why=f"{vents.count} vents of {vents.diameter:g} m have their centres {apart:.3g} m apart",
            remedy="reduce bag.vents.diameter or bag.vents.count, or raise bag.vents.distance",
        )


def strap_line(cloth: schema_bag.StrapCloth, bars: np.ndarray, positions: np.ndarray) -> StrapLine:
    """A strap of bars (n, 2) between nodes, which share its width; positions: start shape, [m], (nodes, 3).

    Raises InputError E-GEO-010 if a bar has no length.
    """
    apart = np.linalg.norm(positions[bars[:, 1]] - positions[bars[:, 0]], axis=1)
    length = apart if cloth.length == "start" else np.full(len(bars), cloth.length)
    if not (length + cloth.slack > SHORTEST_STRAP).all():
        bar = int(np.argmin(length))
        raise DOES_NOT_FIT(
            what="a strap has no length",
            key="straps",
            why=f"its ends, nodes {bars[bar, 0]} and {bars[bar, 1]}, are {1e3 * apart[bar]:.3g} mm apart at the start",
            remedy="join other nodes, or give the strap a length",
        )
    return StrapLine(
        bars=bars,
        width=cloth.width / len(bars),
        length=length + cloth.slack,
        stiffness=cloth.stiffness or None,
        failure=cloth.failure or np.inf,
    )


def build_straps(shape: BagShape, fabric: FabricLaw) -> Straps:
    """Bars of the bag's own fabric, warp along the strap, unless a strap has a stiffness of its own.

    The bars of a strap share its stiffness and its failure tension evenly.
    """
    if not shape.straps:
        return NO_STRAPS
    counts = [len(line.bars) for line in shape.straps]
    width = np.repeat([line.width for line in shape.straps], counts)
    length = np.concatenate([line.length for line in shape.straps])
    section = fabric.thickness * width
    own = np.repeat(
        [np.nan if line.stiffness is None else line.stiffness / len(line.bars) for line in shape.straps], counts
    )
    stiffness = np.where(np.isnan(own), fabric.warp_modulus * section, own)
    mass = fabric.density * section * length
    return Straps(
        bars=np.concatenate([line.bars for line in shape.straps]).astype(np.int64),
        length=length,
        stiffness=stiffness,
        # Of a bar's mass and stiffness: xi rho c l A = xi sqrt(EA m l), as in a membrane.
        viscosity=fabric.damping * np.sqrt(stiffness * mass * length),
        mass=mass,
        strap=np.repeat(np.arange(len(counts)), counts),
        failure=np.repeat([line.failure / len(line.bars) for line in shape.straps], counts),
    )
