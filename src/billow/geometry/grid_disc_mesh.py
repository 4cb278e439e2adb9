"""Triangulation of a flat disc for folding: a grid with rows of nodes on the fold lines inside, nodes on the rim where
they end, Delaunay triangles (docs/folding.md)."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.geometry.disc_mesh import Hole
from billow.geometry.rectangle_mesh import ROUNDING, Rows, beside, even_lines, mesh_rectangle
from billow.geometry.triangulation import smoothed, sorted_edges, triangulate

ALONG_THE_RIM = InputError.declare(
    "E-GEO-048",
    "a fold line at {place:.4g} m from the middle cannot be meshed at the rim",
    where="bag.folds",
    why="it meets the rim at ({x:.4g}, {y:.4g}) m, where another line ends or the line runs along the rim",
    cause="a panel that is as narrow as an element at the rim, or two lines that meet there",
    remedy="move the line, or reduce bag.element_size",
)

CLEARANCE = 0.6
"""Distance kept between the rim and the grid, in edges; and half the longest piece of a line beside the rim."""
SMOOTHED = 3.0
"""How far from the rim the grid gives way to its shape, in edges."""
LEAST = 0.4
"""Shortest edge of the rim, in edges."""

Line = tuple[int, float]
"""A line across an axis (0 is x, 1 is y), and its place on the axis [m]."""


@dataclass(frozen=True)
class GridDisc:
    """points: [m], (n, 2), those of the outer rim first, `rim` of them. triangles: (m, 3) int64, counter-clockwise.
    patches: triangles inside each hole or ring, in the order they were given."""

    points: np.ndarray
    rim: int
    triangles: np.ndarray
    patches: list[np.ndarray]


def mesh_grid_disc(radius: float, size: float, rows: Rows, shapes: tuple[Hole, ...]) -> GridDisc:
    """Mesh a disc of `radius` [m] with edges of about `size` [m], rows across x and across y, and holes and rings.

    Rows and the grid lines beside them run straight to the rim. Raises InputError E-GEO-048 if a row does not reach
    the rim along edges.
    """
    lines = [even_lines([-radius, radius], size, own) for own in rows]
    held = [beside(line, own) for line, own in zip(lines, rows, strict=True)]
    inner = mesh_rectangle(*lines, size, shapes, *held).points
    straight, rim = _rim(radius, size, rows, held)
    away = radius - np.hypot(*inner.T)
    inner, away = inner[away > CLEARANCE * size], away[away > CLEARANCE * size]
    still = away > SMOOTHED * size
    on_line, on_row = np.zeros((2, len(inner)), dtype=bool)
    for axis, place in straight:
        own = np.abs(inner[:, axis] - place) < ROUNDING
        on_line |= own
        on_row |= own & any(abs(place - row.place) < ROUNDING for row in rows[axis])
    for shape in shapes:
        still |= np.hypot(inner[:, 0] - shape.x, inner[:, 1] - shape.y) < shape.radius + SMOOTHED * size
    clear, added = np.ones(len(inner), dtype=bool), []
    pieces = [(line, piece) for line in straight for piece in _to_the_rim(inner, radius, size, line)]
    for (axis, place), (a, b) in pieces:
        # An edge between a and b is one of Delaunay's if nothing lies in the circle over it.
        own = np.abs(inner[:, axis] - place) < ROUNDING
        clear &= on_row | own | (np.hypot(*(inner - 0.5 * (a + b)).T) > 0.5 * np.linalg.norm(b - a) + 0.1 * size)
        if not (np.abs(inner - a).max(axis=1) < ROUNDING).any():
            added.append(a)
    points = np.concatenate([rim, inner[clear], np.reshape(added, (-1, 2))])
    movable = np.zeros(len(points), dtype=bool)
    movable[len(rim) : len(rim) + clear.sum()] = ~(still | on_line)[clear]
    points = smoothed(points, movable)
    triangles = triangulate(points)
    _require_rows(points, triangles, rows)
    centre = points[triangles].mean(axis=1)
    patches = [np.flatnonzero(np.hypot(centre[:, 0] - s.x, centre[:, 1] - s.y) < s.radius) for s in shapes]
    return GridDisc(points, len(rim), triangles, patches)


def _ends(radius: float, line: Line) -> np.ndarray:
    """Where a line meets the rim [m], (2, 2)."""
    axis, place = line
    half = np.sqrt(radius**2 - place**2)
    return np.roll([[place, -half], [place, half]], axis, axis=1)


def _rim(radius: float, size: float, rows: Rows, held: list[tuple[float, ...]]) -> tuple[list[Line], np.ndarray]:
    """The lines that end at nodes of the rim, rows and as many beside them as leave each other room, and the rim's
    points [m], evenly spaced between these nodes."""
    straight: list[Line] = []
    angles: list[float] = []
    wanted = [(axis, row.place, True) for axis, own in enumerate(rows) for row in own]
    wanted += [(axis, place, False) for axis, own in enumerate(held) for place in own]
    for axis, place, needed in wanted:
        if any(axis == other and abs(place - there) < ROUNDING for other, there in straight):
            continue
        if not needed and radius - abs(place) < size:
            continue
        ends = _ends(radius, (axis, place))
        own = np.arctan2(ends[:, 1], ends[:, 0])
        gaps = np.abs(np.angle(np.exp(1j * np.subtract.outer(own, angles or [own[0] + np.pi]))))
        if gaps.min() * radius < LEAST * size:
            if needed:
                x, y = ends[np.argmin(gaps.min(axis=1))]
                raise ALONG_THE_RIM(place=place, x=x, y=y)
            continue
        straight.append((axis, place))
        angles += own.tolist()
    stops = np.sort(np.array(angles))
    spans = zip(stops, np.append(stops[1:], stops[0] + 2.0 * np.pi), strict=True)
    spaced = [np.linspace(a, b, max(1, round((b - a) * radius / size)) + 1)[:-1] for a, b in spans]
    angle = np.concatenate(spaced)
    return straight, radius * np.column_stack([np.cos(angle), np.sin(angle)])


def _to_the_rim(inner: np.ndarray, radius: float, size: float, line: Line) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The pieces of a line between its last points on the grid and the rim [m], none longer than twice CLEARANCE
    edges."""
    axis, place = line
    on_line = inner[np.abs(inner[:, axis] - place) < ROUNDING]
    for sign, end in zip((-1.0, 1.0), _ends(radius, line), strict=True):
        last = on_line[np.argmax(sign * on_line[:, 1 - axis])] if len(on_line) else np.roll([place, 0.0], axis)
        stations = np.linspace(last, end, int(np.ceil(np.linalg.norm(end - last) / (2.0 * CLEARANCE * size))) + 1)
        yield from itertools.pairwise(stations)


def _require_rows(points: np.ndarray, triangles: np.ndarray, rows: Rows) -> None:
    """Require that every row reaches the rim along edges."""
    edges = {tuple(edge) for edge in np.unique(sorted_edges(triangles), axis=0).tolist()}
    for axis, own in enumerate(rows):
        for row in own:
            on_row = np.flatnonzero(np.abs(points[:, axis] - row.place) < ROUNDING)
            path = on_row[np.argsort(points[on_row, 1 - axis])]
            for pair in (path[:2], path[-2:]):
                if tuple(sorted(pair.tolist())) not in edges:
                    x, y = points[pair].mean(axis=0)
                    raise ALONG_THE_RIM(place=row.place, x=x, y=y)
