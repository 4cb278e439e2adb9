"""A driver bag moved from the sizes it was meshed for to others."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from billow.geometry.bag_shapes import BagShape
from billow.geometry.morph import Ring, moved
from billow.geometry.surface import Surface


@dataclass(frozen=True)
class DriverSizes:
    """Sizes of a driver bag [m], as `driver_bag` takes them."""

    diameter: float
    mouth_radius: float
    vent_diameter: float
    vent_radius: float
    stitch_radius: float


def resized(shape: BagShape, before: DriverSizes, after: DriverSizes, initial_gap: float) -> BagShape:
    """A flat driver bag of the same nodes and triangles with other sizes; initial_gap: as `driver_bag` takes it.

    Raises InputError E-GEO-070 if a triangle would turn over or get too sharp.
    """
    surface, flat = shape.surface, shape.positions[:, :2]
    origin = np.zeros(2)
    front, rear = (_nodes(surface, part) for part in ("front", "rear"))
    rim = np.intersect1d(front, rear)
    rings = [
        Ring(rim, origin, origin, after.diameter / before.diameter),
        Ring(_nodes(surface, "mouth"), origin, origin, after.mouth_radius / before.mouth_radius),
    ]
    if shape.straps:
        stitch = front[np.abs(np.hypot(*flat[front].T) - before.stitch_radius) < 1e-9]
        rings.append(Ring(stitch, origin, origin, after.stitch_radius / before.stitch_radius))
    for vent in (name for name in surface.part_names if name.startswith("vent_")):
        nodes = _nodes(surface, vent)
        centre = flat[nodes].mean(axis=0)
        place = centre * (after.vent_radius / before.vent_radius)
        rings.append(Ring(nodes, centre, place, after.vent_diameter / before.vent_diameter))
    points = moved(flat, surface.triangles.astype(np.int64), rings)
    height = initial_gap * (1.0 - np.sum(points**2, axis=1) / (0.5 * after.diameter) ** 2)
    above = np.zeros(len(points), bool)
    above[front] = True
    above[rim] = False
    positions = np.column_stack([points, np.where(above, height, 0.0)])
    return replace(shape, positions=positions, reference=points[surface.triangles])


def _nodes(surface: Surface, part: str) -> np.ndarray:
    """Nodes of a part, in order."""
    return np.unique(surface.triangles[surface.triangles_of(part)]).astype(np.int64)
