"""Triangulation of a flat rectangle: a grid with alternating diagonals, re-meshed around round holes and rings only
(docs/theory.md, Ready-made bags).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from billow.geometry.disc_mesh import CLEARANCE, Hole, circle, hole_polygon
from billow.geometry.forced_edges import with_edges
from billow.geometry.triangulation import smoothed, triangulate

SPREAD = 0.6
"""Width that an element has anyway, in edges; only wider ones need to be asked for."""
LEAST = 0.5
"""Narrowest element, in edges."""
ROUNDING = 1e-9
"""Distance [m] from which on two lines are two."""
MARGIN = 1.6
"""Distance that a hole or ring needs from the nearest line that must stay as it is, in edges."""


class Row(NamedTuple):
    """A row of nodes on a fold line: where [m], and the least width of the elements beside it [m]."""

    place: float
    beside: float


Rows = tuple[tuple[Row, ...], tuple[Row, ...]]
"""Across x and across y."""
NO_ROWS: Rows = ((), ())


class Ring(Hole):
    """A circle on which nodes must lie, with fabric inside too: a retainer ring."""


class ClosedHole(Hole):
    """The place of a hole of the other panel: the same polygon, with fabric inside."""


@dataclass(frozen=True)
class RectangleMesh:
    """points: [m], (n, 2). triangles: (m, 3) int64, counter-clockwise. grid: (columns, rows) int64, the point at each
    crossing of grid lines, -1 where a hole removed it. patches: triangles inside each ring or hole, in the order they
    were given."""

    points: np.ndarray
    triangles: np.ndarray
    grid: np.ndarray
    patches: tuple[np.ndarray, ...]


def mesh_rectangle(
    x_lines: np.ndarray, y_lines: np.ndarray, size: float, shapes: tuple[Hole, ...] = (),
    walls: tuple[float, ...] = (), y_walls: tuple[float, ...] = (),
) -> RectangleMesh:  # fmt: skip
    """Mesh the rectangle between the first and last of ascending grid lines [m], with edges of about `size` [m].

    shapes: to be meshed into it, each at least its radius and MARGIN edges away from the rim and from walls
    (the caller must check this). Holes get a polygon of the hole's area and no nodes inside. walls, y_walls: those of
    x_lines and y_lines whose nodes must stay where they are.
    """
    columns, rows = len(x_lines), len(y_lines)
    x, y = (g.ravel() for g in np.meshgrid(x_lines, y_lines, indexing="ij"))
    points = np.column_stack([x, y])
    triangles, cell = _split_cells(columns, rows)
    kept = np.ones(len(points), dtype=bool)
    held = [np.searchsorted(lines, np.array(w) - 1e-3 * size) for lines, w in ((x_lines, walls), (y_lines, y_walls))]
    for block in _blocks(x_lines, y_lines, size, shapes, *held):
        points, kept, triangles, cell = _remesh(points, kept, triangles, cell, block, rows, size, *held)
    number = np.cumsum(kept) - 1
    grid = np.where(kept[: columns * rows], number[: columns * rows], -1).reshape(columns, rows)
    points, triangles = points[kept], number[triangles]
    triangles = triangles[np.lexsort(triangles.T[::-1])]
    centroid = points[triangles].mean(axis=1)
    patches = tuple(np.flatnonzero(np.hypot(centroid[:, 0] - s.x, centroid[:, 1] - s.y) < s.radius) for s in shapes)
    return RectangleMesh(points, triangles, grid, patches)


def even_lines(stops: list[float], size: float, rows: tuple[Row, ...] = ()) -> np.ndarray:
    """Ascending lines [m] through all stops and rows, about `size` apart and even in number of intervals. Beside a row
    intervals are at least as wide as it asks; rows lie between the stops and leave each other that room."""
    room = {row.place: row.beside for row in rows if row.beside > SPREAD * size}
    stops = sorted({*stops, *(row.place for row in rows)})
    spans = list(itertools.pairwise(stops))
    stops = sorted({*stops, *(line for a, b in spans for line in _room_beside(a, b, room, size))})
    spans = np.array(list(itertools.pairwise(stops)))
    lengths = spans[:, 1] - spans[:, 0]
    counts = np.maximum(1, np.round(lengths / size)).astype(int)
    whole = np.array([a in room or b in room for a, b in spans], dtype=bool)
    counts[whole] = 1
    if counts.sum() % 2:
        counts[np.argmax(np.where(whole, 0.0, lengths) / counts)] += 1
    return np.concatenate(
        [*(np.linspace(a, b, n + 1)[:-1] for (a, b), n in zip(spans, counts, strict=True)), stops[-1:]]
    )


def _room_beside(a: float, b: float, room: dict[float, float], size: float) -> Iterator[float]:
    """The lines next to a and b [m] that keep the room they ask for [m]; what is left between them is no sliver."""
    first, last = room.get(a, 0.0), room.get(b, 0.0)
    if b - a - first - last > LEAST * size:
        yield from [a + first] * bool(first) + [b - last] * bool(last)
    elif first and last:
        yield a + (b - a) * first / (first + last)


def beside(lines: np.ndarray, rows: tuple[Row, ...]) -> tuple[float, ...]:
    """The rows and the grid lines next to them [m]: creases bend between these, alike in both panels."""
    at = np.searchsorted(lines, np.array([row.place for row in rows]) - ROUNDING)
    return tuple(lines[np.unique(np.concatenate([at - 1, at, at + 1]))]) if rows else ()


def _split_cells(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Two triangles a cell, and the cell (column, row) of each."""
    i, j = (g.ravel() for g in np.meshgrid(np.arange(columns - 1), np.arange(rows - 1), indexing="ij"))
    a = i * rows + j
    b, c, d = a + rows, a + rows + 1, a + 1
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(even, np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    return np.concatenate([first, second]), np.tile(np.column_stack([i, j]), (2, 1))


@dataclass
class _Block:
    """Cells from (i0, j0) up to, not including, (i1, j1), and the shapes inside."""

    i0: int
    j0: int
    i1: int
    j1: int
    shapes: list[Hole]

    def overlaps(self, other: _Block) -> bool:
        return self.i0 < other.i1 and other.i0 < self.i1 and self.j0 < other.j1 and other.j0 < self.j1

    def joined(self, other: _Block) -> _Block:
        return _Block(
            min(self.i0, other.i0), min(self.j0, other.j0), max(self.i1, other.i1), max(self.j1, other.j1),
            [*self.shapes, *other.shapes],
        )  # fmt: skip


def _blocks(x_lines, y_lines, size, shapes, x_walls, y_walls) -> list[_Block]:
    """Rectangles of cells around the shapes; overlapping ones are joined. They end at walls (indices of x_lines and of
    y_lines) and exclude the outermost cells."""
    blocks: list[_Block] = []
    for shape in shapes:
        reach = outline(shape, size)[1] + 2.5 * size
        need = shape.radius + 0.999 * MARGIN * size
        i0, i1 = _span(x_lines, shape.x, reach, x_walls, need)
        j0, j1 = _span(y_lines, shape.y, reach, y_walls, need)
        block = _Block(i0, j0, i1, j1, [shape])
        while touching := [b for b in blocks if b.overlaps(block)]:
            for other in touching:
                blocks.remove(other)
                block = block.joined(other)
        blocks.append(block)
    return blocks


def _span(lines: np.ndarray, middle: float, reach: float, walls: np.ndarray, need: float) -> tuple[int, int]:
    """Indices of the lines that enclose what reaches so far from the middle [m]: between the walls next to it, unless
    they are nearer than it needs [m], and within the outermost lines."""
    first = int(np.searchsorted(lines, middle - reach, side="right")) - 1
    last = int(np.searchsorted(lines, middle + reach, side="left"))
    first = max(first, *walls[lines[walls] <= middle - need], 1)
    return int(first), int(min(last, *walls[lines[walls] >= middle + need], len(lines) - 2))


def _along(node, stays, rows: int, x_walls, y_walls) -> np.ndarray:
    """Edges between neighbours on lines that must stay, (n, 2), numbers within the block. node: of the grid, and which
    of them stay, both in the order of the block."""
    place = np.full(node.max() + rows + 2, -1)
    place[node[stays]] = np.arange(np.count_nonzero(stays))
    on_x, on_y = np.isin(node // rows, x_walls), np.isin(node % rows, y_walls)
    ends = np.concatenate([np.column_stack([node, node + 1])[on_x], np.column_stack([node, node + rows])[on_y]])
    edges = place[ends]
    return edges[(edges >= 0).all(axis=1)]


def outline(shape: Hole, size: float) -> tuple[int, float]:
    """Corners and circumradius [m] of a shape's polygon."""
    count, polygon = hole_polygon(shape.radius, size)
    return count, shape.radius if isinstance(shape, Ring) else polygon


def _remesh(points, kept, triangles, cell, block: _Block, rows: int, size: float, x_walls, y_walls):
    """Triangulate a block anew, with the polygons of its shapes in it."""
    i, j = (g.ravel() for g in np.meshgrid(
        np.arange(block.i0, block.i1 + 1), np.arange(block.j0, block.j1 + 1), indexing="ij"
    ))  # fmt: skip
    inner = (i > block.i0) & (i < block.i1) & (j > block.j0) & (j < block.j1)
    node = i * rows + j
    clear = np.ones(len(node), dtype=bool)
    outlines = []
    for shape in block.shapes:
        count, polygon = outline(shape, size)
        outlines.append(circle(polygon, count, shape.x, shape.y))
        away = np.hypot(points[node, 0] - shape.x, points[node, 1] - shape.y) - shape.radius
        clear &= (away > CLEARANCE * size) | (isinstance(shape, Ring | ClosedHole) & (away < -CLEARANCE * size))
    kept = kept.copy()
    kept[node[inner & ~clear]] = False
    stays = ~inner | clear
    own = np.concatenate([node[stays], np.arange(len(points), len(points) + sum(map(len, outlines)))])
    points, kept = np.concatenate([points, *outlines]), np.concatenate([kept, np.ones(len(own) - stays.sum(), bool)])
    movable = np.zeros(len(own), dtype=bool)
    movable[: stays.sum()] = (inner & ~np.isin(i, x_walls) & ~np.isin(j, y_walls))[stays]
    points[own] = smoothed(points[own], movable)
    outside = ~((cell[:, 0] >= block.i0) & (cell[:, 0] < block.i1) & (cell[:, 1] >= block.j0) & (cell[:, 1] < block.j1))
    made = own[with_edges(points[own], triangulate(points[own]), _along(node, stays, rows, x_walls, y_walls))]
    triangles = np.concatenate([triangles[outside], made])
    return points, kept, triangles, np.concatenate([cell[outside], np.full((len(made), 2), -1)])
