"""From the `[bag]` table to a `BagShape`."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from billow.base.errors import InputError
from billow.case.bag import schema_bag
from billow.case.bag.bags import Bag
from billow.case.bag.build_mesh_bag import build_mesh_shape
from billow.case.bag.build_straps import strap_line
from billow.case.bag.schema_mesh_bag import MeshBag
from billow.geometry.bag_shapes import DOES_NOT_FIT, BagShape, along_warp
from billow.geometry.driver_bag import driver_bag
from billow.geometry.local_thickness import doubled, rim_depth, ring_depth
from billow.geometry.rectangular_bag import FRONT, REAR, Gap, PanelVent, Seam, rectangular_bag

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

MOST_TRIANGLES = 500_000


def build_shape(bag: Bag) -> BagShape:
    """The bag's geometry.

    Raises InputError E-GEO-010 (something does not fit), E-GEO-011 (too many triangles), E-GEO-012 (no such chamber),
    and those of `build_mesh_shape`.
    """
    if isinstance(bag, MeshBag):
        return build_mesh_shape(bag)
    _require_modest(bag)
    shape = MAKERS[type(bag)](bag)
    for ring in getattr(bag, "reinforcements", ()):
        shape = doubled(shape, (ring.panel,), ring_depth(ring.inner, ring.outer), ring.layers)
    leak = shape.leak.copy()
    for panel in bag.coated:
        leak[shape.surface.triangles_of(panel)] = 0.0
    angles = {FRONT: math.radians(bag.warp_angle.front), REAR: math.radians(bag.warp_angle.rear)}
    return along_warp(replace(shape, leak=leak), angles)


def _driver(bag: schema_bag.DriverBag) -> BagShape:
    _require_apart(bag.vents)
    shape = driver_bag(
        diameter=bag.diameter,
        element_size=bag.element_size,
        mouth_radius=bag.mouth_radius,
        vent_count=bag.vents.count,
        vent_diameter=bag.vents.diameter,
        vent_radius=bag.vents.distance,
        strap_count=bag.straps.count,
        strap_width=bag.straps.width,
        strap_stitch_radius=bag.straps.stitch_radius,
        initial_gap=bag.initial_gap,
    )
    straps = tuple(strap_line(bag.straps, line.bars, shape.positions) for line in shape.straps)
    rim = rim_depth(0.5 * bag.diameter, bag.element_size, bag.seam.width)
    return doubled(replace(shape, straps=straps), (FRONT, REAR), rim, bag.seam.layers)


def _square(bag: schema_bag.SquareBag) -> BagShape:
    _require_apart(bag.vents)
    angles = 2.0 * np.pi * np.arange(bag.vents.count) / max(bag.vents.count, 1)
    vents = [_vent(bag.vents, bag.vents.distance * np.cos(a), bag.vents.distance * np.sin(a)) for a in angles]
    shape = rectangular_bag(
        length=bag.side, width=bag.side, element_size=bag.element_size, mouth_radius=bag.mouth_radius,
        initial_gap=bag.initial_gap, vents=tuple(vents), seam=_seam(bag),
    )  # fmt: skip
    return _with_point_straps(bag.straps, shape)


def _rectangular(bag: schema_bag.RectangularBag) -> BagShape:
    for key, chambers in (("mouth_chamber", (bag.mouth_chamber,)), ("vents.chambers", bag.vents.chambers)):
        for chamber in chambers:
            _require_chamber(chamber, bag.chambers, key)
    room = bag.length / bag.chambers
    middles = [(chamber - 0.5) * room - 0.5 * bag.length for chamber in bag.vents.chambers]
    x, y = bag.vents.offset
    shape = rectangular_bag(
        length=bag.length, width=bag.width, element_size=bag.element_size, mouth_radius=bag.mouth_radius,
        initial_gap=bag.initial_gap, vents=tuple(_vent(bag.vents, middle + x, y) for middle in middles),
        chambers=bag.chambers, mouth_chamber=bag.mouth_chamber - 1, gap=Gap(bag.openings.width, bag.openings.place),
        seam=_seam(bag),
    )  # fmt: skip
    return _with_point_straps(bag.straps, shape)


MAKERS = {
    schema_bag.DriverBag: _driver,
    schema_bag.SquareBag: _square,
    schema_bag.RectangularBag: _rectangular,
}


def _vent(vents: schema_bag.PanelVents | schema_bag.ChamberVents, x: float, y: float) -> PanelVent:
    return PanelVent(float(x), float(y), 0.5 * vents.diameter, vents.panel)


def _seam(bag: schema_bag.PanelBag) -> Seam:
    return Seam(bag.seam.width, bag.seam.layers)


def _with_point_straps(straps: tuple[schema_bag.PanelStrap, ...], shape: BagShape) -> BagShape:
    made = tuple(
        strap_line(s, np.array([[_nearest(shape, FRONT, s.front), _nearest(shape, REAR, s.rear)]]), shape.positions)
        for s in straps
    )
    return replace(shape, straps=made)


def _nearest(shape: BagShape, panel: str, point: tuple[float, float]) -> int:
    nodes = np.unique(shape.surface.triangles[shape.surface.triangles_of(panel)]).astype(np.int64)
    return int(nodes[np.linalg.norm(shape.positions[nodes, :2] - point, axis=1).argmin()])


def _require_modest(bag: schema_bag.PanelBag) -> None:
    triangles = 2.0 * bag.panel_area / (0.25 * np.sqrt(3.0) * bag.element_size**2)
    if triangles > MOST_TRIANGLES:
        raise TOO_MANY_TRIANGLES(
            triangles=triangles,
            size_key=bag.size_key,
            most=MOST_TRIANGLES,
            needed=bag.element_size * np.sqrt(triangles / MOST_TRIANGLES),
        )


def _require_apart(vents: schema_bag.Vents) -> None:
    apart = 2.0 * vents.distance * np.sin(np.pi / vents.count) if vents.count > 1 else np.inf
    if apart <= vents.diameter:
        raise DOES_NOT_FIT(
            what="the vents overlap",
            key="vents",
            why=f"{vents.count} vents of {vents.diameter:g} m have their centres {apart:.3g} m apart",
            remedy="reduce bag.vents.diameter or bag.vents.count, or raise bag.vents.distance",
        )


def _require_chamber(chamber: int, chambers: int, key: str) -> None:
    if not 1 <= chamber <= chambers:
        raise NO_SUCH_CHAMBER(chamber=chamber, key=key, count=chambers)
