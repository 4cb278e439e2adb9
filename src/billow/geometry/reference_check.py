"""How a start shape fits the flat cut it is measured against, panel by panel, before a run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.geometry.bag_shapes import BagShape
from billow.geometry.flat_cut import signed_areas
from billow.geometry.surface import Surface

PARTLY_MIRRORED = InputError.declare(
    "E-GEO-036",
    "{percent:.3g} % of part {part} is mirrored in the flat cut ({count} triangles)",
    why="fabric that is folded over itself cannot be cut, and its warp would be mirrored there",
    cause="start and reference list the corners of a triangle in different orders, or a flat piece overlaps itself",
    remedy="check that start and reference list the same triangles with the same order of corners",
)
MIRRORED = InputError.declare(
    "E-GEO-037",
    "panel {part} is mirrored: its flat cut is drawn as seen from {drawn}",
    where="bag.parts, part {part}",
    why="it is said to be seen from {said}, and its warp runs at an angle, which would count the wrong way",
    remedy='mirror its flat cut, or write seen_from = "{drawn}" and count the angle in the drawing',
)

NOTICED = 0.02
"""Edges that differ by more than this from their cut length count as stretched or compressed."""

COLLAPSED = 1e-3
"""A triangle with less than this share of its flat area has collapsed: it has no normal, and gas cannot push it."""


@dataclass(frozen=True)
class Panel:
    """A part of fabric at the start.

    stretched, compressed, collapsed: shares of its triangles, by number [-]. shortest, longest: smallest and largest
    ratio of an edge to its cut length [-]; shortest_at, longest_at, collapsed_at: a triangle of the surface where.
    from_inside: whether the flat cut's triangles run clockwise.
    """

    name: str
    triangles: int
    flat_area: float
    stretched: float
    compressed: float
    collapsed: float
    shortest: float
    longest: float
    shortest_at: int
    longest_at: int
    collapsed_at: int
    from_inside: bool


def panels(surface: Surface, positions: np.ndarray, elements: np.ndarray, flat: np.ndarray) -> Iterator[Panel]:
    """One `Panel` for each part. positions: [m], (nodes, 3). elements: (n,), triangles of fabric. flat: [m], (n, 3, 2),
    their corners in the flat cut."""
    corners = positions[surface.triangles[elements]]
    ratio = _edges(corners) / np.maximum(_edges(flat), 1e-300)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    signed = signed_areas(flat)
    gone = area < COLLAPSED * np.abs(signed)
    for part in np.unique(surface.part[elements]):
        mine = np.flatnonzero(surface.part[elements] == part)
        low, high = ratio[mine].min(axis=1), ratio[mine].max(axis=1)
        yield Panel(
            name=surface.part_names[part],
            triangles=len(mine),
            flat_area=float(np.abs(signed[mine]).sum()),
            stretched=float((high > 1.0 + NOTICED).mean()),
            compressed=float((low < 1.0 - NOTICED).mean()),
            collapsed=float(gone[mine].mean()),
            shortest=float(low.min()),
            longest=float(high.max()),
            shortest_at=int(elements[mine[low.argmin()]]),
            longest_at=int(elements[mine[high.argmax()]]),
            collapsed_at=int(elements[mine[gone[mine].argmax()]]),
            from_inside=bool(signed[mine].sum() < 0.0),
        )


def place(surface: Surface, positions: np.ndarray, triangle: int) -> str:
    """A triangle as a message names it."""
    centre = ", ".join(f"{v:.4g}" for v in positions[surface.triangles[triangle]].mean(axis=0))
    return f"triangle {triangle} at ({centre}) m, part {surface.part_names[surface.part[triangle]]}"


def require_unmirrored(shape: BagShape, warp_angles: dict[str, float]) -> None:
    """Require that no panel is mirrored against its flat cut. warp_angles: [rad], of parts where it is not zero.

    Raises InputError E-GEO-036 if some triangles of a panel run the other way than the rest: its flat cut is folded
    over itself. Raises E-GEO-037 if a whole panel is drawn from the other side than stated and its warp is oblique: the
    angle would be counted in the wrong direction.
    """
    surface = shape.surface
    signed = signed_areas(shape.reference)
    for part, (name, kind) in enumerate(zip(surface.part_names, surface.part_kinds, strict=True)):
        mine = np.flatnonzero(surface.part == part)
        if kind != "fabric" or not len(mine):
            continue
        inside = signed[mine].sum() < 0.0
        odd = mine[(signed[mine] < 0.0) != inside]
        if len(odd):
            where = place(surface, shape.positions, int(odd[0]))
            raise PARTLY_MIRRORED(where=where, percent=100 * len(odd) / len(mine), part=name, count=len(odd))
        slant = abs(np.sin(2.0 * warp_angles.get(name, 0.0))) > 1e-9
        if slant and inside != (name in shape.seen_from_inside):
            drawn, said = ("inside", "outside") if inside else ("outside", "inside")
            raise MIRRORED(part=name, drawn=drawn, said=said)


def _edges(corners: np.ndarray) -> np.ndarray:
    """Lengths of a triangle's edges, (n, 3), from its corners (n, 3, 2 or 3)."""
    return np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
