"""Strips of a folded bag, each a part of both panels, closed by virtual walls: from fold line to fold line, and tiles
of the flat cut where a bag is rolled, or was folded elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.geometry.bag_shapes import BagShape
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.flat_cut import flat_area
from billow.geometry.folding.curve import Spiral
from billow.geometry.folding.fold_plan import FoldPlan
from billow.geometry.folding.parting import parted

ON_LINE = 1e-6
"""Distance [m] from a line on the flat bag up to which a node lies on it."""

ELEMENTS = 2.5
"""Elements along a tile, at least: the walls of its two ends keep apart."""


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


def find_strips(plan: FoldPlan, folded: BagShape, tile: float) -> Strips:
    """The strips of a bag of one chamber; folded: as the plan's map leaves it; tile: length of a strip of what is
    rolled [m], about. A tuck makes none: between its creases and the rim are two sleeves of gas, with the surroundings
    between them, and a wall from panel to panel would take those for gas."""
    flat = plan.unfolded(folded.positions)[:, :2]
    corners, missing, lines = _corners(folded, flat), [], ([], [])
    for axis in (0, 1):
        for row in plan.rows(axis, tucked=False):
            if _lie_across(corners[:, :, axis], row.place):
                missing.append(f"the line at {row.place:.4g} m across {'xy'[axis]}, which elements lie across")
            else:
                lines[axis].append(row.place)
        for stage in plan.stages:
            for piece in stage.curve.pieces if stage.across == axis else ():
                if isinstance(piece, Spiral):
                    ends = sorted(plan.mouth[axis] + end for end in (piece.begin, piece.end))
                    lines[axis].extend(_tiled(*ends, tile, corners[:, :, axis]))
        lines[axis].sort()
    return _strips(folded, flat, lines, missing, "all fold lines")


def find_tiles(shape: BagShape, tile: float) -> Strips | None:
    """Tiles of about this length [m] of a bag of one chamber that was folded elsewhere; None where its panels were not
    cut one upon the other, so that nothing says which of their places belong together."""
    triangles, flat = shape.surface.triangles, np.zeros((len(shape.positions), 2))
    flat[triangles.ravel()] = shape.reference.reshape(-1, 2)
    if np.abs(flat[triangles] - shape.reference).max() > ON_LINE:
        return None
    corners = _corners(shape, flat)
    lines = tuple(
        _tiled(corners[..., axis].min(), corners[..., axis].max(), tile, corners[..., axis]) for axis in (0, 1)
    )
    return _strips(shape, flat, lines, [], "all tiles")


def _corners(shape: BagShape, flat: np.ndarray) -> np.ndarray:
    return flat[shape.surface.triangles[shape.surface.chambers.behind != OUTSIDE]]


def _lie_across(corners: np.ndarray, place: float) -> int:
    """Number of triangles on both sides of a line; corners: their places across it [m], (n, 3)."""
    return int(((corners.min(axis=1) < place - ON_LINE) & (corners.max(axis=1) > place + ON_LINE)).sum())


def _tiled(low: float, high: float, tile: float, corners: np.ndarray) -> list[float]:
    """Places of lines from `low` to `high` [m] about a tile apart, each at a row of nodes if there is one near."""
    element = float(np.median(np.ptp(corners, axis=1)))
    count = max(1, round((high - low) / max(tile, ELEMENTS * element)))
    first, last = corners.min() + element, corners.max() - element  # no line along the rim
    nodes, found = np.unique(np.round(corners, 7)), []
    for place in np.linspace(low, high, count + 1):
        near = nodes[np.abs(nodes - place) < 0.5 * element]
        best = min((place, *near), key=lambda at: (_lie_across(corners, at), abs(at - place)))
        if first < best < last:
            found.append(float(best))
    return found


def _strips(
    shape: BagShape, flat: np.ndarray, lines: tuple[list[float], list[float]], missing: list[str], all_of_it: str
) -> Strips:
    triangles, bag = shape.surface.triangles.astype(np.int64), shape.surface.chambers
    found = parted(triangles, bag, flat, lines)
    if found is None:
        missing, found = [*missing, f"{all_of_it}, between which the bag is not closed"], (triangles, bag)
    elif not (found[1].volumes(found[0], shape.positions) > 0.0).all():
        missing, found = [*missing, f"{all_of_it}, of which some enclose no gas"], (triangles, bag)
    return Strips(found[0].astype(np.uint32), found[1], flat_area(shape.reference), tuple(missing))
