"""Triangulation of a flat disc for folding: a grid with rows of nodes on the fold lines inside, nodes on the rim where
they end, Delaunay triangles (docs/folding.md)."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.geometry.disc_mesh import Hole
from billow.geometry.disc_rim import ALONG_THE_RIM, LEAST, DiscRim, Line
from billow.geometry.forced_edges import with_edges
from billow.geometry.rectangle_mesh import ROUNDING, ClosedHole, Rows, beside, even_lines, mesh_rectangle, outline
from billow.geometry.triangulation import smoothed, sorted_edges, triangulate

BESIDE_A_HOLE = InputError.declare(
    "E-GEO-049",
    "a fold line at {place:.4g} m from the middle comes too close to a vent or ring",
    where="bag.folds",
    why="a vent, the stitch line of straps or the mouth reaches {reach:.3g} mm into the elements beside the crease, "
    "which have to be alike in all layers of the stack",
    cause="a stack that is folded once more where a vent or ring lies",
    remedy="move the line or the vent by {reach:.3g} mm, reduce bag.element_size, or fold in the other order",
)

CLEARANCE = 0.6
"""Distance kept between the rim and the grid, in edges; and half the longest piece of a line beside the rim."""
SMOOTHED = 3.0
"""How far from the rim the grid gives way to its shape, in edges."""
WIDEST = 1.6
"""Width of an element beside a row, at most, in edges."""
APART = 0.45
"""Distance kept between the rim's nodes and others, and between holes and strips, in edges."""


@dataclass(frozen=True)
class GridDisc:
    """points: [m], (n, 2), those of the outer rim first, `rim` of them. triangles: (m, 3) int64, counter-clockwise.
    patches: triangles inside each hole or ring, in the order they were given."""

    points: np.ndarray
    rim: int
    triangles: np.ndarray
    patches: list[np.ndarray]

    def opened(self, count: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
        """Points, triangles and patches of the same mesh without nodes inside the first `count` patches."""
        if not count:
            return self.points, self.triangles, []
        others = np.ones(len(self.triangles), dtype=bool)
        others[np.concatenate(self.patches[:count])] = False
        kept = np.zeros(len(self.points), dtype=bool)
        kept[self.triangles[others]] = True
        number, made = np.cumsum(kept) - 1, []
        for patch in self.patches[:count]:
            polygon = np.unique(self.triangles[patch])
            polygon = polygon[kept[polygon]]
            made.append(polygon[triangulate(self.points[polygon])])
        ends = np.cumsum([others.sum(), *map(len, made)])
        patches = [np.arange(a, b) for a, b in itertools.pairwise(ends)]
        return self.points[kept], number[np.concatenate([self.triangles[others], *made])], patches


def mesh_grid_disc(
    radius: float, size: float, rows: Rows, shapes: tuple[Hole, ...], first: int | None = None
) -> GridDisc:
    """Mesh a disc of `radius` [m] with edges of about `size` [m], rows across x and across y, and holes and rings.

    Rows and the grid lines beside them run straight to the rim. first: the axis across which a whole stack is folded;
    between its rows and the lines beside them there are no other nodes, so that all layers of the stack bend alike.
    Raises InputError E-GEO-048 if a row does not reach the rim along edges, E-GEO-049 if a hole or ring is in the way.
    """
    lines = [
        even_lines([-radius, *(_partners(radius, size, rows, axis) if axis == first else ()), radius], size, own)
        for axis, own in enumerate(rows)
    ]
    held = [beside(line, own) for line, own in zip(lines, rows, strict=True)]
    rim = DiscRim(radius, size, first, [] if first is None else _strips(lines[first], rows[first]))
    _require_clear(rim, size, shapes)
    inner = mesh_rectangle(*lines, size, shapes, *held).points
    for axis in (first, 1 - first) if first is not None else (0, 1):
        for row in rows[axis]:
            rim.meet((axis, row.place), row.place)
        for low, place, high in rim.strips if axis == first else ():
            rim.meet((axis, low), place)
            rim.meet((axis, high), place)
    for axis, own in enumerate(held):
        for place in own:
            rim.meet((axis, place))
    on_rim = rim.closed()

    away = radius - np.hypot(*inner.T)
    on = {line: np.abs(inner[:, line[0]] - line[1]) < ROUNDING for line in rim.ends}
    on_line = np.any(list(on.values()), axis=0)
    exact = [line for line in rim.ends if line[0] == first and any(line[1] in strip for strip in rim.strips)]
    on_exact = np.any([on[line] for line in exact] or [np.zeros(len(inner), bool)], axis=0)
    crossed = [(axis, row.place) for axis, own in enumerate(rows) for row in own]
    on_row = np.any([on[line] for line in crossed], axis=0)
    crossing = on_exact & np.any([on[line] for line in crossed if line[0] != first] or [on_row], axis=0)
    near = np.min(np.linalg.norm(inner[:, None] - on_rim[None], axis=2), axis=1)
    clear = (away > CLEARANCE * size) & (on_line | (near > APART * size))
    if first is not None:
        clear |= crossing & (away > 0.0) & (near > ROUNDING)
    inner, away, near = inner[clear], away[clear], near[clear]
    on = {line: own[clear] for line, own in on.items()}
    on_line, on_row, on_exact = on_line[clear], on_row[clear], on_exact[clear]
    still = (away > SMOOTHED * size) | on_line
    for shape in shapes:
        still |= np.hypot(inner[:, 0] - shape.x, inner[:, 1] - shape.y) < shape.radius + SMOOTHED * size
    clear, added = np.ones(len(inner), dtype=bool), []
    for line, own in on.items():
        for a, b in _to_the_rim(inner[own], on_rim[rim.ends[line]], size, line):
            # An edge between a and b is one of Delaunay's if nothing lies in the circle over it.
            clear &= (
                on_row
                | on_exact
                | own
                | (np.hypot(*(inner - 0.5 * (a + b)).T) > 0.5 * np.linalg.norm(b - a) + 0.1 * size)
            )
            if not (np.abs(inner - a).max(axis=1) < ROUNDING).any():
                added.append(a)
    added = np.reshape(added, (-1, 2))
    foreign = rim.in_strip(added, APART * size)
    points = np.concatenate([on_rim, inner[clear], added[~foreign]])
    movable = np.zeros(len(points), dtype=bool)
    movable[len(on_rim) : len(on_rim) + clear.sum()] = ~still[clear]
    points = smoothed(points, movable)
    wanted = [
        _around(np.arange(len(on_rim))),
        *(_around(_on(points, shape, size)) for shape in shapes if isinstance(shape, ClosedHole)),
        *(_along(points, line) for line in dict.fromkeys([*exact, *crossed])),
    ]
    triangles = with_edges(points, triangulate(points), np.concatenate(wanted))
    triangles = triangles[~_outside(triangles, len(on_rim))]
    triangles = triangles[np.lexsort(triangles.T[::-1])]
    _require_rows(points, triangles, rows)
    patches = [_inside(points, triangles, shape, size) for shape in shapes]
    return GridDisc(points, len(on_rim), triangles, patches)


def _partners(radius: float, size: float, rows: Rows, axis: int) -> list[float]:
    """Places on an axis where rows across the other axis meet the rim beside a row of this one [m]: a line there ends
    with them."""
    own = np.array([row.place for row in rows[axis]])
    room = np.array([max(LEAST * size, row.beside) for row in rows[axis]])
    found: list[float] = []
    for row in rows[1 - axis]:
        half = float(np.sqrt(max(radius**2 - row.place**2, 0.0)))
        for there in (-half, half):
            away = np.abs(own - there)
            apart = np.abs(np.array([*found, np.inf]) - there).min() > LEAST * size
            if len(own) and apart and (away > room).all() and away.min() < WIDEST * size:
                found.append(there)
    return found


def _strips(lines: np.ndarray, rows) -> list[tuple[float, float, float]]:
    at = np.searchsorted(lines, np.array([row.place for row in rows]) - ROUNDING)
    return [tuple(float(lines[k + side]) for side in (-1, 0, 1)) for k in at]


def _require_clear(rim: DiscRim, size: float, shapes: tuple[Hole, ...]) -> None:
    for shape in shapes:
        middle = (shape.x, shape.y)[rim.first or 0]
        reach = outline(shape, size)[1] + APART * size
        for low, place, high in rim.strips:
            into = min(high - (middle - reach), middle + reach - low)
            if into > 0.0:
                raise BESIDE_A_HOLE(place=place, reach=1e3 * into)


def _to_the_rim(
    on_line: np.ndarray, ends: np.ndarray, size: float, line: Line
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The pieces of a line between its last points on the grid, `on_line`, and the rim [m], none longer than twice
    CLEARANCE edges."""
    axis, place = line
    for sign, end in zip((-1.0, 1.0), ends, strict=True):
        last = on_line[np.argmax(sign * on_line[:, 1 - axis])] if len(on_line) else np.roll([place, 0.0], axis)
        stations = np.linspace(last, end, int(np.ceil(np.linalg.norm(end - last) / (2.0 * CLEARANCE * size))) + 1)
        yield from itertools.pairwise(stations)


def _around(nodes: np.ndarray) -> np.ndarray:
    """Edges from each node of a closed line to the next, (n, 2)."""
    return np.column_stack([nodes, np.roll(nodes, -1)])


def _on(points: np.ndarray, shape: Hole, size: float) -> np.ndarray:
    """Nodes of a shape's outline, in order."""
    away = points - (shape.x, shape.y)
    found = np.flatnonzero(np.abs(np.hypot(*away.T) - outline(shape, size)[1]) < ROUNDING)
    return found[np.argsort(np.arctan2(away[found, 1], away[found, 0]))]


def _inside(points: np.ndarray, triangles: np.ndarray, shape: Hole, size: float) -> np.ndarray:
    """Triangles within a shape's outline."""
    away = np.hypot(*(points - (shape.x, shape.y)).T)
    return np.flatnonzero((away[triangles] < outline(shape, size)[1] + ROUNDING).all(axis=1))


def _along(points: np.ndarray, line: Line) -> np.ndarray:
    """Edges between neighbours on a line from one end to the other, (n, 2)."""
    axis, place = line
    on_line = np.flatnonzero(np.abs(points[:, axis] - place) < ROUNDING)
    path = on_line[np.argsort(points[on_line, 1 - axis])]
    return np.column_stack([path[:-1], path[1:]])


def _outside(triangles: np.ndarray, rim: int) -> np.ndarray:
    """Whether triangles lie outside a rim that is not convex: its nodes follow each other the other way round."""
    a, b, c = np.sort(triangles, axis=1).T
    turned = (triangles == np.column_stack([a, b, c])).all(axis=1)
    turned |= (triangles == np.column_stack([b, c, a])).all(axis=1)
    turned |= (triangles == np.column_stack([c, a, b])).all(axis=1)
    return (triangles < rim).all(axis=1) & ~turned


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
