"""Triangulation of a flat rectangle: a grid with alternating diagonals, re-meshed around round holes and rings only
(docs/theory.md, Ready-made bags).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from billow.geometry.disc_mesh import CLEARANCE, Hole, circle, hole_polygon
from billow.geometry.triangulation import smoothed, triangulate

MARGIN = 1.6
"""Distance that a hole or ring needs from the nearest line that must stay as it is, in edges."""


class Ring(Hole):
    """A circle on which nodes must lie, with fabric inside too: a retainer ring."""


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
    x_lines: np.ndarray, y_lines: np.ndarray, size: float, shapes: tuple[Hole, ...] = (), walls: tuple[float, ...] = ()
) -> RectangleMesh:
    """Mesh the rectangle between the first and last of ascending grid lines [m], with edges of about `size` [m].

    shapes: to be meshed into it, each at least its radius and MARGIN edges away from the rim and from walls
    (the caller must check this). Holes get a polygon of the hole's area and no nodes inside. walls: those of x_lines
    whose nodes must stay where they are.
    """
    columns, rows = len(x_lines), len(y_lines)
    x, y = (g.ravel() for g in np.meshgrid(x_lines, y_lines, indexing="ij"))
    points = np.column_stack([x, y])
    triangles, cell = _split_cells(columns, rows)
    kept = np.ones(len(points), dtype=bool)
    for block in _blocks(x_lines, y_lines, size, shapes, np.searchsorted(x_lines, np.array(walls) - 1e-3 * size)):
        points, kept, triangles, cell = _remesh(points, kept, triangles, cell, block, rows, size)
    number = np.cumsum(kept) - 1
    grid = np.where(kept[: columns * rows], number[: columns * rows], -1).reshape(columns, rows)
    points, triangles = points[kept], number[triangles]
    triangles = triangles[np.lexsort(triangles.T[::-1])]
    centroid = points[triangles].mean(axis=1)
    patches = tuple(np.flatnonzero(np.hypot(centroid[:, 0] - s.x, centroid[:, 1] - s.y) < s.radius) for s in shapes)
    return RectangleMesh(points, triangles, grid, patches)


def even_lines(stops: list[float], size: float) -> np.ndarray:
    """Ascending lines [m] through all stops, about `size` apart and even in number of intervals."""
    spans = np.array(list(itertools.pairwise(stops)))
    lengths = spans[:, 1] - spans[:, 0]
    counts = np.maximum(1, np.round(lengths / size)).astype(int)
    if counts.sum() % 2:
        counts[np.argmax(lengths / counts)] += 1
    return np.concatenate(
        [*(np.linspace(a, b, n + 1)[:-1] for (a, b), n in zip(spans, counts, strict=True)), stops[-1:]]
    )


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


def _blocks(x_lines, y_lines, size, shapes, walls) -> list[_Block]:
    """Rectangles of cells around the shapes; overlapping ones are joined. They end at walls (indices of x_lines) and
    exclude the outermost cells."""
    blocks: list[_Block] = []
    for shape in shapes:
        reach = _outline(shape, size)[1] + 2.5 * size
        i0, i1 = _span(x_lines, shape.x - reach, shape.x + reach)
        j0, j1 = _span(y_lines, shape.y - reach, shape.y + reach)
        i0 = max(i0, *walls[x_lines[walls] < shape.x], 1)
        i1 = min(i1, *walls[x_lines[walls] > shape.x], len(x_lines) - 2)
        block = _Block(i0, j0, i1, j1, [shape])
        while touching := [b for b in blocks if b.overlaps(block)]:
            for other in touching:
                blocks.remove(other)
                block = block.joined(other)
        blocks.append(block)
    return blocks


def _span(lines: np.ndarray, low: float, high: float) -> tuple[int, int]:
    first = int(np.searchsorted(lines, low, side="right")) - 1
    last = int(np.searchsorted(lines, high, side="left"))
    return max(first, 1), min(last, len(lines) - 2)


def _outline(shape: Hole, size: float) -> tuple[int, float]:
    """Corners and circumradius [m] of a shape's polygon."""
    count, polygon = hole_polygon(shape.radius, size)
    return count, shape.radius if isinstance(shape, Ring) else polygon


def _remesh(points, kept, triangles, cell, block: _Block, rows: int, size: float):
    """Triangulate a block anew, with the polygons of its shapes in it."""
    i, j = (g.ravel() for g in np.meshgrid(
        np.arange(block.i0, block.i1 + 1), np.arange(block.j0, block.j1 + 1), indexing="ij"
    ))  # fmt: skip
    inner = (i > block.i0) & (i < block.i1) & (j > block.j0) & (j < block.j1)
    node = i * rows + j
    clear = np.ones(len(node), dtype=bool)
    outlines = []
    for shape in block.shapes:
        count, polygon = _outline(shape, size)
        outlines.append(circle(polygon, count, shape.x, shape.y))
        away = np.hypot(points[node, 0] - shape.x, points[node, 1] - shape.y) - shape.radius
        clear &= (away > CLEARANCE * size) | (isinstance(shape, Ring) & (away < -CLEARANCE * size))
    kept = kept.copy()
    kept[node[inner & ~clear]] = False
    stays = ~inner | clear
    own = np.concatenate([node[stays], np.arange(len(points), len(points) + sum(map(len, outlines)))])
    points, kept = np.concatenate([points, *outlines]), np.concatenate([kept, np.ones(len(own) - stays.sum(), bool)])
    movable = np.zeros(len(own), dtype=bool)
    movable[: stays.sum()] = inner[stays]
    points[own] = smoothed(points[own], movable)
    outside = ~((cell[:, 0] >= block.i0) & (cell[:, 0] < block.i1) & (cell[:, 1] >= block.j0) & (cell[:, 1] < block.j1))
    made = own[triangulate(points[own])]
    triangles = np.concatenate([triangles[outside], made])
    return points, kept, triangles, np.concatenate([cell[outside], np.full((len(made), 2), -1)])
