"""Where a surface passes through itself: edges that cross triangles with which they share no node."""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar
from billow.geometry.search_grid import SearchGrid, clipped_cell
from billow.geometry.surface import Surface
from billow.geometry.triangle import cross

INTERIOR = 1e-9
"""Least share of an edge on either side of a triangle, and least area coordinate of the place where it passes: what
only touches does not cross. Rounding of positions is a thousandth of it."""

FARTHEST = 1e3
"""Distance of a node from the origin [m] from which on there is no surface any more."""


def edges_of(triangles: np.ndarray) -> np.ndarray:
    """Edges of triangles (n, 3), each once, lower node first, ascending: (edges, 2) int64."""
    corners = np.asarray(triangles, np.int64)
    ends = np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
    nodes = int(corners.max(initial=0)) + 1
    return np.column_stack(np.divmod(np.unique(ends[:, 0] * nodes + ends[:, 1]), nodes))


class CrossingCount:
    """Counts where fabric and mouths of a surface pass through each other; vents and openings are holes."""

    def __init__(self, surface: Surface):
        self._surface = surface
        self._triangles = surface.triangles[surface.solid]
        self._edges = edges_of(self._triangles)

    def per_triangle(self, positions: np.ndarray) -> np.ndarray:
        """How many edges pass through each triangle of the surface, (triangles,) int64. positions: [m], (nodes, 3).
        ValueError as `crossings`."""
        found = np.zeros(self._surface.triangle_count, np.int64)
        found[self._surface.solid] = crossings(self._triangles, self._edges, positions)
        return found

    def total(self, positions: np.ndarray) -> float:
        """Number of crossings; NaN for positions that are those of no surface."""
        try:
            return float(self.per_triangle(positions).sum())
        except ValueError:
            return math.nan


def crossings(triangles: np.ndarray, edges: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """How many edges pass through each triangle, (triangles,) int64.

    triangles: (triangles, 3); edges: (edges, 2), by their nodes; positions: [m], (nodes, 3). What shares a node,
    touches or lies in one plane does not cross. Raises ValueError if a position is not finite, or too far away to
    belong to a bag.
    """
    if not np.abs(positions).max(initial=0.0) < FARTHEST:
        raise ValueError("the positions are not those of a surface")
    if not len(edges):
        return np.zeros(len(triangles), np.int64)
    grid = SearchGrid.build(triangles, positions, positions)
    corners = positions[triangles]
    boxes = np.hstack([corners.min(axis=1), corners.max(axis=1)])
    n = len(edges)
    counts = np.empty(-(-n // CHUNK), np.int64)
    room = 0
    while True:
        found = np.empty((len(counts), room), np.int64)
        _find(
            n, edges, triangles, positions, boxes, grid.origin, grid.cell, grid.counts, grid.first, grid.listed,
            grid.margin, counts, found,
        )  # fmt: skip
        if counts.max() <= room:
            break
        room = int(counts.max())
    hit = [row[:count] for row, count in zip(found, counts, strict=True)]
    return np.bincount(np.concatenate(hit), minlength=len(triangles))


@scalar
def _passes(positions, p, q, a, b, c):
    """Where an edge from node p to q passes through the triangle a, b, c, as its share [-]; -1 where it does not."""
    ax, ay, az = positions[a, 0], positions[a, 1], positions[a, 2]
    ux, uy, uz = positions[b, 0] - ax, positions[b, 1] - ay, positions[b, 2] - az
    vx, vy, vz = positions[c, 0] - ax, positions[c, 1] - ay, positions[c, 2] - az
    sx, sy, sz = positions[p, 0] - ax, positions[p, 1] - ay, positions[p, 2] - az
    dx, dy, dz = positions[q, 0] - positions[p, 0], positions[q, 1] - positions[p, 1], positions[q, 2] - positions[p, 2]
    # Moeller and Trumbore, J. Graphics Tools 2 (1997) 21.
    hx, hy, hz = cross(dx, dy, dz, vx, vy, vz)
    volume = ux * hx + uy * hy + uz * hz
    sizes = (dx * dx + dy * dy + dz * dz) * (ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz)
    if volume * volume <= INTERIOR * INTERIOR * INTERIOR * sizes:  # in one plane, or without area
        return -1.0
    second = (sx * hx + sy * hy + sz * hz) / volume
    if second < INTERIOR or second > 1.0 - INTERIOR:
        return -1.0
    kx, ky, kz = cross(sx, sy, sz, ux, uy, uz)
    third = (dx * kx + dy * ky + dz * kz) / volume
    if third < INTERIOR or second + third > 1.0 - INTERIOR:
        return -1.0
    share = (vx * kx + vy * ky + vz * kz) / volume
    if share < INTERIOR or share > 1.0 - INTERIOR:
        return -1.0
    return share


@kernel
def _find(n, edges, triangles, positions, boxes, origin, cell, counts, first, listed, margin, count_out, found_out):
    """Triangles that edges cross, by chunks of edges: how many, and as many of them as there is room for.

    An edge is cut into pieces no longer than twice the margin, so that the cell of a piece's middle lists every
    triangle that the piece can pass through; where it passes decides which piece it is, so that it counts once. boxes:
    around the triangles, lower and upper corner, (triangles, 6).
    """
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        count = 0
        for e in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            p, q = edges[e, 0], edges[e, 1]
            px, py, pz = positions[p, 0], positions[p, 1], positions[p, 2]
            qx, qy, qz = positions[q, 0], positions[q, 1], positions[q, 2]
            dx, dy, dz = qx - px, qy - py, qz - pz
            lx, ly, lz, hx, hy, hz = min(px, qx), min(py, qy), min(pz, qz), max(px, qx), max(py, qy), max(pz, qz)
            pieces = int(np.sqrt(dx * dx + dy * dy + dz * dz) / (2.0 * margin)) + 1
            for piece in range(pieces):
                middle = (piece + 0.5) / pieces
                x = clipped_cell(px + middle * dx, origin[0], 1.0 / cell, counts[0])
                y = clipped_cell(py + middle * dy, origin[1], 1.0 / cell, counts[1])
                z = clipped_cell(pz + middle * dz, origin[2], 1.0 / cell, counts[2])
                here = (x * counts[1] + y) * counts[2] + z
                for i in range(first[here], first[here + 1]):
                    t = listed[i]
                    if hx < boxes[t, 0] or hy < boxes[t, 1] or hz < boxes[t, 2]:
                        continue
                    if lx > boxes[t, 3] or ly > boxes[t, 4] or lz > boxes[t, 5]:
                        continue
                    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
                    if p in (a, b, c) or q in (a, b, c):
                        continue
                    share = _passes(positions, p, q, a, b, c)
                    if share >= 0.0 and min(pieces - 1, int(share * pieces)) == piece:
                        if count < found_out.shape[1]:
                            found_out[chunk, count] = t
                        count += 1
        count_out[chunk] = count
