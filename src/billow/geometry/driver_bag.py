"""Driver bag: two round panels sewn at the rim, with mouth, vents and straps."""

from __future__ import annotations

import numpy as np

from billow.geometry.bag_shapes import DOES_NOT_FIT, BagShape, StrapLine
from billow.geometry.disc_mesh import CLEARANCE, Hole, hole_polygon, mesh_disc, rim_count
from billow.geometry.grid_disc_mesh import mesh_grid_disc
from billow.geometry.rectangle_mesh import NO_ROWS, ClosedHole, Ring, Rows
from billow.geometry.surface import Surface


def driver_bag(
    diameter: float, element_size: float, mouth_radius: float, vent_count: int, vent_diameter: float,
    vent_radius: float, strap_count: int, strap_width: float, strap_stitch_radius: float, initial_gap: float,
    folds: Rows = NO_ROWS, folded_last: int | None = None,
) -> BagShape:  # fmt: skip
    """Driver bag: two flat discs sewn at the rim, lying on the plane z = 0, mouth and vents in the rear (lower) panel.

    diameter: of the flat panels [m]. mouth_radius: retainer ring radius [m]; nodes on and inside it are fixed.
    vent_radius: distance of the vents' centres from the axis [m]. strap_stitch_radius: of the stitch line on the front
    panel [m]; on the rear panel the retainer ring holds the straps; bars are as long as in the start shape.
    initial_gap: height of the shallow dome that the front panel is at the start, for some air in the bag [m]. folds:
    rows of nodes across x and across y. folded_last: the axis across which the stack of the other folds is folded, if
    it is.

    Raises InputError E-GEO-010 if a vent or strap does not fit into its panel, E-GEO-048 for a row along the rim.
    """
    radius = 0.5 * diameter
    _require_fit(
        radius, element_size, mouth_radius, vent_count, 0.5 * vent_diameter, vent_radius, strap_count,
        strap_stitch_radius,
    )  # fmt: skip
    vents = tuple(
        Hole(vent_radius * np.cos(angle), vent_radius * np.sin(angle), 0.5 * vent_diameter)
        for angle in np.pi / 2 + 2.0 * np.pi * np.arange(vent_count) / max(vent_count, 1)
    )
    stitch = (strap_stitch_radius,) if strap_count else ()
    if any(folds):  # panels that bend together have their nodes in the same places
        rings = tuple(Ring(0.0, 0.0, r) for r in (mouth_radius, *stitch))
        closed = tuple(ClosedHole(vent.x, vent.y, vent.radius) for vent in vents)
        disc = mesh_grid_disc(radius, element_size, folds, (*closed, *rings), folded_last)
        front, front_triangles, rim = disc.points, disc.triangles, disc.rim
        rear, rear_triangles, vent_patches = disc.opened(vent_count)
    else:
        front, front_triangles, _ = mesh_disc(radius, element_size, stitch)
        rear, rear_triangles, vent_patches = mesh_disc(radius, element_size, (mouth_radius,), vents)
        rim = rim_count(radius, element_size)

    # The rim nodes come first in both panels and are the same nodes: the seam.
    rear_node = np.concatenate([np.arange(rim), len(front) + np.arange(len(rear) - rim)])
    flat = np.concatenate([front, rear[rim:]])
    height = np.concatenate([initial_gap * (1.0 - np.sum(front**2, axis=1) / radius**2), np.zeros(len(rear) - rim)])
    height[:rim] = 0.0
    in_mouth = np.hypot(*rear[rear_triangles].mean(axis=1).T) < mouth_radius
    part = np.concatenate([np.zeros(len(front_triangles)), np.where(in_mouth, 2, 1)])
    for k, patch in enumerate(vent_patches):
        part[len(front_triangles) + patch] = 3 + k
    names = ("front", "rear", "mouth", *(f"vent_{k + 1}" for k in range(vent_count)))
    triangles = np.concatenate([front_triangles, rear_node[rear_triangles][:, [0, 2, 1]]])  # rear normals point down
    surface = Surface.build(triangles, part, names, len(flat))
    fixed = np.zeros(len(flat), dtype=bool)
    fixed[surface.triangles[surface.triangles_of("mouth")]] = True
    positions = np.column_stack([flat, height])
    straps = tuple(
        StrapLine(bars, strap_width / len(bars), np.linalg.norm(positions[bars[:, 1]] - positions[bars[:, 0]], axis=1))
        for bars in _straps(front, rear, rear_node, strap_count, strap_width, strap_stitch_radius, mouth_radius)
    )
    return BagShape(surface, positions, flat[triangles], fixed, straps, seen_from_inside=("rear",))


def _straps(front, rear, rear_node, count, width, stitch_radius, mouth_radius):
    """Bars (n, 2) of each strap: a fan from an arc of the front stitch line to the nearest nodes of the retainer
    ring."""
    on_stitch = np.flatnonzero(np.abs(np.hypot(front[:, 0], front[:, 1]) - stitch_radius) < 1e-9)
    on_ring = np.flatnonzero(np.abs(np.hypot(rear[:, 0], rear[:, 1]) - mouth_radius) < 1e-9)
    front_angle, ring_angle = (np.arctan2(p[:, 1], p[:, 0]) for p in (front[on_stitch], rear[on_ring]))
    for k in range(count):
        middle = 2.0 * np.pi * k / count
        away = np.abs(_wrap(front_angle - middle))
        reach = max(0.5 * width / stitch_radius, away.min() + 1e-9)
        picked = np.flatnonzero(away <= reach)
        partner = [np.argmin(np.abs(_wrap(ring_angle - front_angle[i]))) for i in picked]
        yield np.column_stack([on_stitch[picked], rear_node[on_ring[partner]]])


def _wrap(angle):
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def _require_fit(radius, element_size, mouth_radius, vent_count, vent_half, vent_radius, strap_count, stitch_radius):
    if mouth_radius >= 0.5 * radius:
        raise DOES_NOT_FIT(
            part="the inflator mouth",
            key="mouth_radius",
            why=f"its radius, {mouth_radius} m, is more than half that of the panel, {radius} m",
            remedy="reduce bag.mouth_radius",
        )
    if strap_count and stitch_radius >= 0.9 * radius:
        raise DOES_NOT_FIT(
            what="the stitch line of the straps lies outside the front panel",
            key="straps.stitch_radius",
            why=f"its radius is {stitch_radius} m, that of the panel {radius} m, of which a tenth must stay free",
            remedy="reduce bag.straps.stitch_radius",
        )
    if vent_count:
        apart = 2.0 * vent_radius * np.sin(np.pi / vent_count) if vent_count > 1 else np.inf
        _, reach = hole_polygon(vent_half, element_size)
        inner = vent_radius - max(reach, vent_half + CLEARANCE * element_size)  # the retainer ring keeps all its nodes
        outer = radius * np.cos(np.pi / rim_count(radius, element_size))  # the rim is a polygon too
        if apart <= 2.0 * reach:
            raise DOES_NOT_FIT(
                what="vents overlap",
                key="vents",
                why=f"the centres of {vent_count} vents lie {apart:.3g} m apart, each reaches {reach:.3g} m",
                remedy="reduce bag.vents.count or bag.vents.diameter, or raise bag.vents.distance",
            )
        if inner <= mouth_radius or vent_radius + reach >= outer:
            raise DOES_NOT_FIT(
                part="a vent",
                key="vents",
                why=f"a vent and the elements around it reach from {inner:.3g} to {vent_radius + reach:.3g} m from the "
                f"axis; the panel from {mouth_radius:.3g} to {outer:.3g} m",
                remedy="change bag.vents.diameter or bag.vents.distance, or reduce bag.element_size",
            )
