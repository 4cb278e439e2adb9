"""Strips of a folded bag: its fold lines part the chamber into strips of two panels, closed by virtual walls that reach
from the one panel's row of nodes to the other's."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from billow.geometry.bag_shapes import BagShape
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.flat_cut import flat_area, signed_areas
from billow.geometry.folding.curve import Spiral
from billow.geometry.folding.fold_plan import FoldPlan

ON_LINE = 1e-6
"""Distance [m] from a fold line on the flat bag up to which a node lies on it."""


@dataclass(frozen=True)
class Strips:
    """triangles: (bag + virtual, 3) uint32, those of the bag and after them those of the walls between strips.
    chambers: which strip lies on either side of each. area: of the bag's as cut [m^2], (bag,). missing: fold lines, in
    words, at which there is no wall."""

    triangles: np.ndarray
    chambers: Chambers
    area: np.ndarray
    missing: tuple[str, ...]

    @property
    def count(self) -> int:
        return self.chambers.count


def find_strips(plan: FoldPlan, folded: BagShape) -> Strips:
    """The strips of a bag of one chamber; folded: as the plan's map leaves it."""
    flat = plan.unfolded(folded.positions)[:, :2]
    triangles, bag = folded.surface.triangles.astype(np.int64), folded.surface.chambers
    corners = flat[triangles[bag.behind != OUTSIDE]]
    lines, missing = ([], []), []
    for axis in (0, 1):
        for row in plan.rows(axis):
            along = corners[:, :, axis] - row.place
            if ((along.min(axis=1) < -ON_LINE) & (along.max(axis=1) > ON_LINE)).any():
                missing.append(f"the line at {row.place:.4g} m across {'xy'[axis]}, which elements lie across")
            else:
                lines[axis].append(row.place)
    for stage in plan.stages:
        if any(isinstance(piece, Spiral) for piece in stage.curve.pieces):
            missing.append(f"the roll across {'xy'[stage.across]}")
    parted = _parted(triangles, bag, flat, lines)
    if not _is_closed(*parted):
        missing.append("all fold lines, between which the bag is not closed")
        parted = triangles, bag
    return Strips(parted[0].astype(np.uint32), parted[1], flat_area(folded.reference), tuple(missing))


def _parted(
    triangles: np.ndarray, bag: Chambers, flat: np.ndarray, lines: tuple[list[float], list[float]]
) -> tuple[np.ndarray, Chambers]:
    """Triangles, of the bag and then virtual, and the strips on either side of each. lines: across x and y, [m]."""
    inside = bag.behind != OUTSIDE
    middle = flat[triangles[inside]].mean(axis=1)
    place = [np.searchsorted(lines[axis], middle[:, axis]) for axis in (0, 1)]
    _, strip = np.unique(place[0] * (len(lines[1]) + 1) + place[1], return_inverse=True)
    of = np.full(len(triangles), OUTSIDE, np.int32)
    of[inside] = strip
    walls = _walls(triangles, of, flat)
    virtual = [corner for wall in walls.values() for corner in wall]
    sides = np.array([pair for pair, wall in walls.items() for _ in wall], np.int32).reshape(-1, 2)
    names = tuple(f"strip_{k + 1}" for k in range(strip.max() + 1))
    behind, ahead = np.concatenate([of, sides[:, 0]]), np.concatenate([np.full_like(of, OUTSIDE), sides[:, 1]])
    return np.concatenate([triangles, np.array(virtual, np.int64).reshape(-1, 3)]), Chambers(names, behind, ahead)


def _walls(triangles: np.ndarray, of: np.ndarray, flat: np.ndarray) -> dict[tuple[int, int], list]:
    """Triangles of the wall between each two strips, lower number first, normals from the first to the second.

    Where the fabric goes on in another strip, its edges are the rims of a wall: those of the front panel above, those
    of the rear one below. triangles: (n, 3); of: strip of each, or OUTSIDE; flat: where nodes lie on the flat bag [m],
    (nodes, 2).
    """
    facing = signed_areas(flat[triangles]) > 0.0
    owner = {(a, b): t for t in np.flatnonzero(of != OUTSIDE) for a, b in _edges(triangles[t])}
    rims: dict[tuple[int, int], tuple[list, list]] = defaultdict(lambda: ([], []))
    for (a, b), t in owner.items():
        other = owner[b, a]
        if of[t] < of[other]:
            rims[int(of[t]), int(of[other])][0 if facing[t] else 1].append((a, b))
    walls = {}
    for pair, (front, rear) in sorted(rims.items()):
        ends = flat[np.ravel(front)]
        axis = int(np.argmax(np.ptp(ends, axis=0)))
        above, below = (sorted(set(np.ravel(edges).tolist()), key=lambda n: flat[n, axis]) for edges in (front, rear))
        wall = _between(above, below, flat[:, axis])
        if (above[0], above[1]) in front:  # the first strip goes along its rim so; its wall has to come back
            wall = [(a, c, b) for a, b, c in wall]
        walls[pair] = wall
    return walls


def _edges(corners: np.ndarray) -> list[tuple[int, int]]:
    a, b, c = corners.tolist()
    return [(a, b), (b, c), (c, a)]


def _between(above: list[int], below: list[int], at: np.ndarray) -> list[tuple[int, int, int]]:
    """Triangles between two rows of nodes in ascending order of `at`, which may share their ends."""
    found, i, j = [], 0, 0
    while i + 1 < len(above) or j + 1 < len(below):
        forth = j + 1 == len(below) or (i + 1 < len(above) and at[above[i + 1]] <= at[below[j + 1]])
        found.append((above[i], above[i + 1], below[j]) if forth else (above[i], below[j + 1], below[j]))
        i, j = i + forth, j + (not forth)
    return [corners for corners in found if len(set(corners)) == 3]


def _is_closed(triangles: np.ndarray, chambers: Chambers) -> bool:
    for strip in range(chambers.count):
        edges = [edge for corners in chambers.boundary(strip, triangles) for edge in _edges(corners)]
        once = set(edges)
        if len(once) < len(edges) or any(edge[::-1] not in once for edge in edges):
            return False
    return True
