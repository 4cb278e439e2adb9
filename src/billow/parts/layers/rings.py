"""Rings of triangles around a node that cannot touch themselves, so that no search needs to look into them.

Triangles that share a node lie near each other all the time, and touch only where fabric is creased sharply. So the
least distance within the ring around a node, of whatever shares no node, is measured once, with where the nodes of the
ring lay as seen from its middle. As long as any two of them have moved by less than that since, and will, nothing in
the ring can have touched: rings are measured anew only where fabric has turned by a twentieth of a circle or so.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, inlined, kernel, scalar
from billow.geometry.closest_blocks import BLOCK, ROWS, SQUARE, fill, nodes_on_triangles, segments_on_segments

HOPE = 0.8
"""Largest distance within a ring that is hoped for when it is measured again, in its shortest spoke."""


class Rings(NamedTuple):
    """Of each node. rim_begin: (nodes + 1,), rim: numbers of the other nodes of its triangles, one ring after the
    other; fan_begin: (nodes + 1,), fan: those two of each of its triangles, (3 triangles, 2); all int32."""

    rim_begin: np.ndarray
    rim: np.ndarray
    fan_begin: np.ndarray
    fan: np.ndarray

    @classmethod
    def of(cls, triangles: np.ndarray, nodes: int) -> Rings:
        middle = triangles.T.ravel()
        others = np.concatenate([triangles[:, [1, 2]], triangles[:, [2, 0]], triangles[:, [0, 1]]])
        order = np.argsort(middle, kind="stable")
        spokes = np.unique((middle.astype(np.int64) * nodes)[:, None] + others)
        begins = (np.searchsorted(sorted_, np.arange(nodes + 1)) for sorted_ in (spokes // nodes, middle[order]))
        rim_begin, fan_begin = (begin.astype(np.int32) for begin in begins)
        return cls(rim_begin, (spokes % nodes).astype(np.int32), fan_begin, others[order].astype(np.int32))


class Shapes:
    """Rings as they were when they were measured. spoke: from the middle to each node of the rim [m], (rim, 3); apart:
    least distance within each ring [m], (nodes,), negative before the first measurement."""

    def __init__(self, rings: Rings):
        self.spoke, self.apart = np.empty((len(rings.rim), 3)), np.full(len(rings.rim_begin) - 1, -1.0)


def open_rings(
    rings: Rings, shapes: Shapes, ways: np.ndarray, near: float, among: np.ndarray | None = None
) -> np.ndarray:
    """Which rings stay open, (nodes,) bool: within them nothing comes within `near` [m]. ways: of the nodes, their
    places now and at the end, and their skins [m], (nodes, 8), as in `search`. among: which rings are asked about,
    (nodes,) bool, all by default; of others it is not known, and False."""
    is_open = np.empty(len(shapes.apart), np.bool_)
    among = np.ones(len(is_open), np.bool_) if among is None else among
    _open_rings(len(is_open), tuple(rings), ways, near, among, shapes.spoke, shapes.apart, is_open)
    return is_open


def widened(rings: Rings, nodes: np.ndarray) -> np.ndarray:
    """Nodes of a set, (nodes,) bool, and of all rings around them: those in whose rings there is one of the set."""
    wider = nodes.copy()
    _widen(len(nodes), rings.rim_begin, rings.rim, nodes, wider)
    return wider


@kernel
def _widen(n, rim_begin, rim, nodes, wider_out):
    for c in range(n):
        if nodes[c]:
            for i in range(rim_begin[c], rim_begin[c + 1]):
                wider_out[rim[i]] = True


@inlined
def _larger_two(value, first, second):
    return max(value, first), max(second, min(value, first))


@kernel
def _open_rings(n, rings, ways, near, among, spoke, apart, open_out):
    rim_begin, rim = rings[0], rings[1]
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        todo, wanted, m = np.empty(CHUNK, np.int64), np.empty(CHUNK), 0
        for c in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            if not among[c]:
                open_out[c] = False
                continue
            x, y, z = ways[c, 0], ways[c, 1], ways[c, 2]
            p, q, r = ways[c, 3] - x, ways[c, 4] - y, ways[c, 5] - z
            # Farthest ways of two nodes, as seen from the middle of the ring: since it was measured, and from now on.
            first, second, soon, too = ways[c, 6], 0.0, ways[c, 6], 0.0
            moved, shortest = 0.0, np.inf
            for i in range(rim_begin[c], rim_begin[c + 1]):
                j = np.uint64(rim[i])
                sx, sy, sz = ways[j, 0] - x, ways[j, 1] - y, ways[j, 2] - z
                ex, ey, ez = ways[j, 3] - ways[j, 0] - p, ways[j, 4] - ways[j, 1] - q, ways[j, 5] - ways[j, 2] - r
                dx, dy, dz = sx - spoke[i, 0], sy - spoke[i, 1], sz - spoke[i, 2]
                fx, fy, fz = dx + ex, dy + ey, dz + ez
                way, square = ex * ex + ey * ey + ez * ez, dx * dx + dy * dy + dz * dz
                then = max(square, fx * fx + fy * fy + fz * fz)  # convex in time
                first, second = _larger_two(math.sqrt(then) + ways[j, 6], first, second)
                soon, too = _larger_two(math.sqrt(way) + ways[j, 6], soon, too)
                moved, shortest = max(moved, square), min(shortest, sx * sx + sy * sy + sz * sz)
            open_out[c] = near + first + second <= apart[c]
            need = near + soon + too
            most = HOPE * math.sqrt(shortest)
            if apart[c] >= 0.0:
                most = min(most, apart[c] + 2.0 * math.sqrt(moved))
            if not open_out[c] and need <= most:
                todo[m], wanted[m] = c, need
                m += 1
        _measure_rings(todo[:m], rings, ways, spoke, apart)
        for i in range(m):
            open_out[todo[i]] = wanted[i] <= apart[todo[i]]


@scalar
def _measure_rings(todo, rings, ways, spoke_out, apart_out):
    """Least distances within rings, by blocks of pairs."""
    rim_begin, rim, fan_begin, fan = rings
    on, across = np.zeros(ROWS * BLOCK), np.zeros(ROWS * BLOCK)
    of_on, of_across = np.zeros(BLOCK, np.int64), np.zeros(BLOCK, np.int64)
    m, n = 0, 0
    for i in range(len(todo)):
        c = todo[i]
        apart_out[c] = np.inf
        for s in range(rim_begin[c], rim_begin[c + 1]):
            for k in range(3):
                spoke_out[s, k] = ways[rim[s], k] - ways[c, k]
    for i in range(len(todo)):
        c = todo[i]
        for t in range(fan_begin[c], fan_begin[c + 1]):
            a, b = fan[t, 0], fan[t, 1]
            for s in range(rim_begin[c], rim_begin[c + 1]):  # a node and a triangle; a spoke and an edge of the rim
                p = rim[s]
                if p in (a, b):
                    continue
                fill(on, m, ways, p, c, a, b)
                fill(across, n, ways, p, c, a, b)
                of_on[m], of_across[n] = c, c
                m, n = m + 1, n + 1
                if m == BLOCK:
                    nodes_on_triangles(on)
                    m = _take_least(on, of_on, m, apart_out)
                if n == BLOCK:
                    segments_on_segments(across)
                    n = _take_least(across, of_across, n, apart_out)
            for u in range(fan_begin[c], t):  # two edges of the rim
                d, e = fan[u, 0], fan[u, 1]
                if a in (d, e) or b in (d, e):
                    continue
                fill(across, n, ways, a, b, d, e)
                of_across[n] = c
                n += 1
                if n == BLOCK:
                    segments_on_segments(across)
                    n = _take_least(across, of_across, n, apart_out)
    nodes_on_triangles(on)
    segments_on_segments(across)
    _take_least(on, of_on, m, apart_out)
    _take_least(across, of_across, n, apart_out)


@scalar
def _take_least(block, ring, count, apart_out):
    """Distances of a block go to their rings; returns 0, the number of pairs left."""
    for j in range(count):
        apart_out[ring[j]] = min(apart_out[ring[j]], math.sqrt(block[SQUARE + j]))
    return 0
