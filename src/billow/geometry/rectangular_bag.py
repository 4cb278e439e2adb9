"""Rectangular bag: two flat panels sewn at the rim, divided into chambers by seams that join both and leave a gap
(docs/theory.md, Chambers and openings).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.geometry.bag_shapes import DOES_NOT_FIT, BagShape
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.disc_mesh import Hole
from billow.geometry.local_thickness import distance_to_lines, doubled, line_depth
from billow.geometry.rectangle_mesh import (
    LEAST,
    MARGIN,
    NO_ROWS,
    ROUNDING,
    RectangleMesh,
    Ring,
    Row,
    Rows,
    beside,
    even_lines,
    mesh_rectangle,
)
from billow.geometry.surface import Surface

BESIDE_A_SEAM = InputError.declare(
    "E-GEO-046",
    "a fold line at {place:.4g} m comes {near:.3g} mm close to a seam or to another line",
    where="bag.folds",
    why="the elements between would be narrower than {least:.3g} mm and make the step short",
    cause="a fold line beside a seam between chambers, at the end of a gap, or beside the rim",
    remedy="move the line onto the seam or away from it, or reduce bag.element_size",
)


FRONT, REAR, MOUTH = "front", "rear", "mouth"


@dataclass(frozen=True)
class PanelVent(Hole):
    """A round vent, its centre counted from the middle of the bag, and the panel it is cut into."""

    panel: str


@dataclass(frozen=True)
class Gap:
    """What each inner seam leaves open: width [m], and its middle as a fraction of the bag's width, 0 to 1."""

    width: float
    place: float


@dataclass(frozen=True)
class Seam:
    """Seam allowance: width [m] over which fabric lies in `layers` layers."""

    width: float
    layers: float


def rectangular_bag(
    length: float, width: float, element_size: float, mouth_radius: float, initial_gap: float,
    vents: tuple[PanelVent, ...] = (), chambers: int = 1, mouth_chamber: int = 0, gap: Gap | None = None,
    seam: Seam | None = None, mouth_offset: tuple[float, float] = (0.0, 0.0), folds: Rows = NO_ROWS,
) -> BagShape:  # fmt: skip
    """Two panels of length (x) by width (y) [m] about the origin, the rear one in the plane z = 0.

    mouth_radius: of the retainer ring [m], its centre `mouth_offset` [m] from the middle of the mouth chamber's rear
    panel, counted from 0 at the lowest x; nodes on and inside it are fixed. initial_gap: greatest height of the front
    over the rear panel at the start [m]. chambers: of equal length along x; gap: needed if there are several. folds:
    rows of nodes across x and across y.

    Raises InputError E-GEO-010 if the mouth, a vent or a gap does not fit, E-GEO-046 if a row comes too close to a
    seam.
    """
    walls = np.linspace(-0.5 * length, 0.5 * length, chambers + 1)
    gap_ends = _gap_ends(width, element_size, gap) if chambers > 1 else (0.0, 0.0)
    # A gap has a node in its middle: with both ends sewn it could not open otherwise.
    y_stops = {-0.5 * width, 0.5 * width}
    if chambers > 1 or not folds[1]:
        y_stops |= {*gap_ends, 0.5 * sum(gap_ends)}
    y_stops = sorted(y_stops)
    folds = tuple(
        _settled(rows, stops, LEAST * element_size) for rows, stops in zip(folds, (walls, y_stops), strict=True)
    )
    x_lines, y_lines = _x_lines(walls, element_size, folds[0]), even_lines(y_stops, element_size, folds[1])
    mouth = Ring(*mouth_centre(length, chambers, mouth_chamber, mouth_offset), mouth_radius)
    _require_fit(mouth, vents, walls, width, element_size)
    rear_vents = [k for k, vent in enumerate(vents) if vent.panel == REAR]
    front_vents = [k for k, vent in enumerate(vents) if vent.panel == FRONT]
    holes = [vents[k] for k in front_vents], [mouth, *(vents[k] for k in rear_vents)]
    if any(folds):  # panels that bend together have their nodes in the same places
        holes = [own + _rings(other, own, element_size) for own, other in (holes, reversed(holes))]
    held = (*walls[1:-1], *beside(x_lines, folds[0])), beside(y_lines, folds[1])
    front, rear = (mesh_rectangle(x_lines, y_lines, element_size, tuple(h), *held) for h in holes)

    lines = _sewn_lines(length, width, walls, gap_ends)
    sewn = distance_to_lines(rear.points, lines) < 1e-9 * length
    rear_node = np.empty(len(rear.points), dtype=np.int64)
    rear_node[rear.grid[rear.grid >= 0]] = front.grid[rear.grid >= 0]
    rear_node[~sewn] = len(front.points) + np.arange(np.count_nonzero(~sewn))
    flat = np.concatenate([front.points, rear.points[~sewn]])
    depth = distance_to_lines(front.points, lines)
    # A rounded roof over every chamber: its height grows with the distance from the seams and is level along the ridge.
    height = np.zeros(len(flat))
    height[: len(front.points)] = initial_gap * (1.0 - (1.0 - np.minimum(1.0, depth / depth.max())) ** 2)

    names = (FRONT, REAR, MOUTH, *(f"vent_{k + 1}" for k in range(len(vents))))
    part = np.concatenate([np.zeros(len(front.triangles)), np.ones(len(rear.triangles))]).astype(np.int64)
    for k, patch in zip(front_vents, front.patches[: len(front_vents)], strict=True):
        part[patch] = 3 + k
    for k, patch in zip([-1, *rear_vents], rear.patches[: 1 + len(rear_vents)], strict=True):
        part[len(front.triangles) + patch] = 3 + k
    panels = np.concatenate([front.triangles, rear_node[rear.triangles][:, [0, 2, 1]]])
    behind = np.searchsorted(walls[1:-1], flat[panels].mean(axis=1)[:, 0])
    openings = [_opening(front, rear, rear_node, wall, gap_ends) for wall in walls[1:-1]]
    counts = [len(panels), *map(len, openings)]
    triangles = np.concatenate([panels, *openings])
    part = np.concatenate([part, np.repeat(len(names) + np.arange(chambers - 1), counts[1:])])
    room = Chambers(
        ("bag",) if chambers == 1 else tuple(f"chamber_{k + 1}" for k in range(chambers)),
        np.concatenate([behind, np.repeat(np.arange(chambers - 1), counts[1:])]).astype(np.int32),
        np.concatenate([np.full(len(panels), OUTSIDE), np.repeat(np.arange(1, chambers), counts[1:])]).astype(np.int32),
    )
    names += tuple(f"opening_{k + 1}" for k in range(chambers - 1))
    surface = Surface.build(triangles, part, names, len(flat), chambers=room)
    reference = flat[triangles]
    reference[len(panels) :] = 0.0
    fixed = np.zeros(len(flat), dtype=bool)
    fixed[surface.triangles[surface.triangles_of(MOUTH)]] = True
    shape = BagShape(
        surface, np.column_stack([flat, height]), reference, fixed, mouth_centre=np.array([mouth.x, mouth.y, 0.0]),
        seen_from_inside=(REAR,),
    )  # fmt: skip
    return doubled(shape, (FRONT, REAR), line_depth(lines, seam.width), seam.layers) if seam else shape


def mouth_centre(length: float, chambers: int, chamber: int, offset: tuple[float, float]) -> tuple[float, float]:
    """Centre (x, y) [m] of a mouth `offset` [m] from the middle of a chamber, counted from 0 at the lowest x."""
    walls = np.linspace(-0.5 * length, 0.5 * length, chambers + 1)
    return float(0.5 * (walls[chamber] + walls[chamber + 1]) + offset[0]), offset[1]


def _x_lines(walls: np.ndarray, size: float, rows: tuple[Row, ...]) -> np.ndarray:
    """Grid lines along x [m]: an even number of cells in every chamber, so that each of its corners is whole."""
    chambers = len(walls) - 1
    if not rows:
        cells = 2 * max(1, round(0.5 * (walls[-1] - walls[0]) / chambers / size)) * chambers
        return np.linspace(walls[0], walls[-1], cells + 1)
    each = [
        even_lines([a, b], size, tuple(row for row in rows if a < row.place < b)) for a, b in itertools.pairwise(walls)
    ]
    return np.concatenate([*(lines[:-1] for lines in each), walls[-1:]])


def _rings(holes: list[Hole], own: list[Hole], size: float) -> list[Hole]:
    """Rings of nodes around the places of holes in the other panel, where the panel's own leave room."""
    return [
        Ring(hole.x, hole.y, hole.radius)
        for hole in holes
        if all(np.hypot(hole.x - o.x, hole.y - o.y) >= hole.radius + o.radius + MARGIN * size for o in own)
    ]


def _settled(rows: tuple[Row, ...], stops: Iterable[float], least: float) -> tuple[Row, ...]:
    """The rows, on a stop where they differ from it by rounding."""
    settled: list[Row] = []
    for row in rows:
        others = np.array([*stops, *(other.place for other in settled)])
        nearest = float(others[np.abs(others - row.place).argmin()])
        near = abs(nearest - row.place)
        if ROUNDING < near < least:
            raise BESIDE_A_SEAM(place=row.place, near=1e3 * near, least=1e3 * least)
        settled.append(row._replace(place=nearest) if near <= ROUNDING else row)
    return tuple(settled)


def _gap_ends(width: float, size: float, gap: Gap) -> tuple[float, float]:
    """Ends of the gap along y [m], moved to the rim where the remaining seam would be shorter than an element."""
    length = min(gap.width, width)
    low = np.clip(width * (gap.place - 0.5) - 0.5 * length, -0.5 * width, 0.5 * width - length)
    if low + 0.5 * width < size:
        low = -0.5 * width
    if 0.5 * width - (low + length) < size:
        low, length = (low, 0.5 * width - low) if low == -0.5 * width else (0.5 * width - length, length)
    return float(low), float(low + length) if low + length < 0.5 * width else 0.5 * width


def _sewn_lines(length: float, width: float, walls: np.ndarray, gap_ends: tuple[float, float]) -> np.ndarray:
    """Ends of all straight seams, rim included, [m], (n, 2, 2)."""
    x, y = 0.5 * length, 0.5 * width
    lines = [[(-x, -y), (x, -y)], [(x, -y), (x, y)], [(x, y), (-x, y)], [(-x, y), (-x, -y)]]
    for wall in walls[1:-1]:
        lines += [[(wall, a), (wall, b)] for a, b in ((-y, gap_ends[0]), (gap_ends[1], y)) if b - a > 1e-9 * width]
    return np.array(lines)


def _opening(front: RectangleMesh, rear: RectangleMesh, rear_node, wall: float, gap_ends) -> np.ndarray:
    """Triangles that close the gap in a seam at x = wall, normals towards larger x, (n, 3)."""
    on_line = np.abs(front.points[front.grid[:, 0], 0] - wall).argmin()
    y = front.points[front.grid[on_line], 1]
    rows = np.flatnonzero((y > gap_ends[0] - 1e-9) & (y < gap_ends[1] + 1e-9))
    upper, lower = front.grid[on_line, rows], rear_node[rear.grid[on_line, rows]]
    triangles = []
    for k, (i, j) in enumerate(itertools.pairwise(range(len(rows)))):
        corners = [(lower[i], lower[j], upper[j]), (lower[i], upper[j], upper[i])]
        if k % 2:
            corners = [(lower[i], lower[j], upper[i]), (lower[j], upper[j], upper[i])]
        triangles += [c for c in corners if len(set(c)) == 3]
    return np.array(triangles)


def _require_fit(mouth: Ring, vents: tuple[PanelVent, ...], walls: np.ndarray, width: float, size: float) -> None:
    def room(x, y):
        return min(float(np.abs(walls - x).min()), 0.5 * width - abs(y))

    need = mouth.radius + MARGIN * size
    if room(mouth.x, mouth.y) < need:
        raise DOES_NOT_FIT(
            what="the inflator mouth does not fit into its chamber",
            key="mouth_radius",
            why=f"it needs {need:.3g} m from its centre to the nearest seam and has {room(mouth.x, mouth.y):.3g} m",
            remedy="reduce bag.mouth_radius or bag.element_size, or make the bag larger",
        )
    for k, vent in enumerate(vents):
        inside = walls[0] < vent.x < walls[-1] and abs(vent.y) < 0.5 * width
        need = vent.radius + MARGIN * size
        if not inside or room(vent.x, vent.y) < need:
            raise DOES_NOT_FIT(
                part=f"vent {k + 1}",
                key="vents",
                why=f"at ({vent.x:.3g}, {vent.y:.3g}) m it needs {need:.3g} m to the nearest seam and has "
                f"{max(0.0, room(vent.x, vent.y)) if inside else 0.0:.3g} m",
                remedy="reduce bag.vents.diameter or bag.element_size, or move the vent",
            )
        others = [(o.x, o.y, o.radius, "another vent") for o in vents[:k] if o.panel == vent.panel]
        others += [(mouth.x, mouth.y, mouth.radius, "the mouth")] if vent.panel == REAR else []
        for x, y, radius, name in others:
            apart = float(np.hypot(vent.x - x, vent.y - y))
            if apart < vent.radius + radius + MARGIN * size:
                raise DOES_NOT_FIT(
                    what=f"vent {k + 1} overlaps {name}",
                    key="vents",
                    why=f"their centres lie {apart:.3g} m apart and need {vent.radius + radius + MARGIN * size:.3g} m",
                    remedy="reduce bag.vents.diameter or bag.element_size, or move the vent",
                )
