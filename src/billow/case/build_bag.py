"""From the `[bag]` table to a `BagShape`."""

from __future__ import annotations

import numpy as np

from billow.case import schema_bag
from billow.errors import InputError
from billow.geometry.bag_shapes import BagShape, driver_bag

MOST_TRIANGLES = 500_000


def build_shape(bag: schema_bag.Bag) -> BagShape:
    """The bag's geometry. Raises InputError E-GEO-010 (something does not fit), E-GEO-011 (too many triangles)."""
    _require_modest(bag)
    _require_apart(bag.vents)
    return driver_bag(
        diameter=bag.diameter,
        element_size=bag.element_size,
        mouth_radius=bag.mouth_radius,
        vent_count=bag.vents.count,
        vent_diameter=bag.vents.diameter,
        vent_radius=bag.vents.distance,
        strap_count=bag.straps.count,
        strap_length=bag.straps.length,
        strap_width=bag.straps.width,
        strap_stitch_radius=bag.straps.stitch_radius,
        initial_gap=bag.initial_gap,
    )


def _require_modest(bag: schema_bag.Bag) -> None:
    panels = 0.5 * np.pi * bag.diameter**2
    triangles = panels / (0.25 * np.sqrt(3.0) * bag.element_size**2)
    if triangles > MOST_TRIANGLES:
        raise InputError(
            "E-GEO-011",
            f"the mesh would have about {triangles:.2g} triangles",
            where="bag.element_size, bag.diameter",
            why=f"at most {MOST_TRIANGLES} are allowed, to fit into memory; a length may be in another unit",
            remedy=f"raise bag.element_size to {bag.element_size * np.sqrt(triangles / MOST_TRIANGLES):.2g} m or more",
        )


def _require_apart(vents: schema_bag.Vents) -> None:
    apart = 2.0 * vents.distance * np.sin(np.pi / vents.count) if vents.count > 1 else np.inf
    if apart <= vents.diameter:
        raise InputError(
            "E-GEO-010",
            "the vents overlap",
            where="bag.vents",
            why=f"{vents.count} vents of {vents.diameter:g} m have their centres {apart:.3g} m apart",
            remedy="reduce bag.vents.diameter or bag.vents.count, or raise bag.vents.distance",
        )
