"""Search for pairs: whatever can come near within a time, if every node keeps to a straight path but for a skin.

A pair is kept if boxes around the paths of its sides meet, and if along the way between its closest points the sides
come nearer than what is near, plus the skins of both, now or at the end: in between they are no nearer, as that is least
of the first side less most of the second, each linear in time. A stack that flies together therefore needs no new list,
however fast it flies, nor do layers that slide.

Boxes around the paths of triangles are sorted into the cells of a grid; of two triangles whose boxes meet, nodes are
held against triangles and edges against edges. A pair belongs to the lower of the two triangles. Pairs of nodes and
triangles come first, then those of edges, each by triangles, those of a triangle in the order of their keys: the order
does not depend on the search.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numba import prange

from billow.base.compiled import inlined, kernel
from billow.geometry.closest_blocks import BLOCK, ROWS, SQUARE, X, Y, Z, fill, nodes_on_triangles, segments_on_segments
from billow.geometry.search_grid import MOST_CELLS, cell_lists, clipped_cell
from billow.parts.layers.distance import along, between
from billow.parts.layers.mesh import TouchMesh
from billow.parts.layers.pairs import EDGES, FIRST

SLICE = 64
"""Triangles that one thread looks at together."""

LEAST_ROOM = 256
"""Of a slice, in pairs, in a first try."""

LEAST_CELL, CELL_IN_BOXES = 1e-4, 1.5
"""Edge of a cell: at least [m], and in mean sizes of the boxes."""

PARALLEL_FROM = 1000
"""Fewest triangles for which a search with all threads pays: it takes about a millisecond."""


class Paths(NamedTuple):
    """Nodes on their way: positions [m] and velocities [m/s], (nodes, 3); skin: how far each may stray [m], (nodes,).
    near: distance that matters [m]; time: how long the pairs have to serve [s]."""

    positions: np.ndarray
    velocities: np.ndarray
    skin: np.ndarray
    near: float
    time: float


class Found(NamedTuple):
    """Pairs in their order: key, nodes, normal and begin as in `Pairs`. looked_at: pairs of triangles whose boxes meet.
    crowd: the most candidates that a slice has, of either kind."""

    key: np.ndarray
    nodes: np.ndarray
    normal: np.ndarray
    begin: np.ndarray
    looked_at: int
    crowd: int


def find_pairs(mesh: TouchMesh, paths: Paths, crowd: int = 0) -> Found:
    """All pairs of which at least one node can move. crowd: about the most that a slice has."""
    n, slices = len(mesh.triangles), -(-len(mesh.triangles) // SLICE)
    box, edge_box, node_box = np.empty((n, 6)), np.empty((len(mesh.edges), 6)), np.empty((len(paths.skin), 6))
    drift = paths.velocities[mesh.edges[:, 0]].mean(axis=0)
    run = "parallel" if n >= PARALLEL_FROM and numba.get_num_threads() > 1 else "serial"
    getattr(_boxes, run)(n, len(mesh.edges), tuple(mesh), tuple(paths), drift, box, edge_box, node_box)
    low, high = box[:, :3].min(axis=0), box[:, 3:].max(axis=0)
    cell = np.maximum(CELL_IN_BOXES * (box[:, 3:] - box[:, :3]).mean(axis=0), LEAST_CELL)
    while True:
        counts = ((high - low) / cell).astype(np.int64) + 1
        if np.prod(counts.astype(float)) <= MOST_CELLS:
            break
        cell = 1.3 * cell
    spans = np.empty((n, 6), np.int32)
    _find_spans(n, box, low, cell, counts, spans)
    first, listed = cell_lists(spans, counts)
    begin, room = np.zeros(2 * n + 1, np.int64), max(LEAST_ROOM, int(1.25 * crowd))
    found, met, rooms = begin[1:].reshape(2, n), np.empty(slices, np.int64), np.empty(slices, np.int64)
    while True:
        key, nodes = np.empty((2, slices, room), np.int64), np.empty((2, slices, room, 4), np.int32)
        normal = np.empty((2, slices, room, 3))
        getattr(_find, run)(
            n, tuple(mesh), tuple(paths), box, edge_box, node_box, spans, counts, first, listed, key, nodes, normal,
            found, met, rooms,
        )  # fmt: skip
        most = int(rooms.max(initial=0))
        if most <= room:
            break
        room = most
    np.cumsum(begin, out=begin)
    total = int(begin[-1])
    found = Found(
        np.empty(total, np.int64), np.empty((total, 4), np.int32), np.empty((total, 3)), begin, int(met.sum()), most
    )
    getattr(_pack, run)(n, key, nodes, normal, tuple(found[:4]))
    return found


@kernel
def _boxes(n, m, mesh, paths, drift, box_out, edge_box_out, node_box):
    """Boxes, low and high corner, around the paths of n triangles, m edges, and nodes, seen by who flies with the
    velocity `drift` [m/s]."""
    triangles, edges = mesh[0], mesh[1]
    positions, velocities, skin, near, time = paths
    for i in prange(len(positions)):
        reach = 0.5 * near + skin[i]
        for k in range(3):
            way = time * (velocities[i, k] - drift[k])
            node_box[i, k] = positions[i, k] + min(0.0, way) - reach
            node_box[i, 3 + k] = positions[i, k] + max(0.0, way) + reach
    for t in prange(n):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for k in range(3):
            box_out[t, k] = min(node_box[a, k], node_box[b, k], node_box[c, k])
            box_out[t, 3 + k] = max(node_box[a, 3 + k], node_box[b, 3 + k], node_box[c, 3 + k])
    for e in prange(m):
        a, b = edges[e, 0], edges[e, 1]
        for k in range(3):
            edge_box_out[e, k] = min(node_box[a, k], node_box[b, k])
            edge_box_out[e, 3 + k] = max(node_box[a, 3 + k], node_box[b, 3 + k])


@kernel
def _find_spans(n, box, origin, cell, counts, spans_out):
    """Cells of each axis that boxes touch, as in `cell_lists`."""
    for t in prange(n):
        for k in range(3):
            spans_out[t, 2 * k] = clipped_cell(box[t, k], origin[k], 1.0 / cell[k], counts[k])
            spans_out[t, 2 * k + 1] = clipped_cell(box[t, 3 + k], origin[k], 1.0 / cell[k], counts[k])


@inlined
def _meet(one, i, other, j):
    """Whether two boxes meet. All is asked at once: which question decides cannot be foreseen."""
    return (
        (one[i, 0] <= other[j, 3]) & (other[j, 0] <= one[i, 3]) & (one[i, 1] <= other[j, 4])
        & (other[j, 1] <= one[i, 4]) & (one[i, 2] <= other[j, 5]) & (other[j, 2] <= one[i, 5])
    )  # fmt: skip


@inlined
def _write(kind, s, count, key, a, b, c, d, key_out, nodes_out):
    """Write a candidate, if there is room."""
    if count < key_out.shape[2]:
        key_out[kind, s, count] = key
        nodes_out[kind, s, count, 0], nodes_out[kind, s, count, 1] = a, b
        nodes_out[kind, s, count, 2], nodes_out[kind, s, count, 3] = c, d


@inlined
def _nodes_on(one, other, mesh, box, node_box, key_out, nodes_out, s, count):
    """Candidates: the nodes for which triangle `one` speaks, and triangle `other`; returns how many a slice has."""
    triangles, own_node_start, own_node, free = mesh[0], mesh[2], mesh[3], mesh[6]
    for i in range(own_node_start[one], own_node_start[one + np.uint64(1)]):
        p = np.uint64(own_node[np.uint64(i)])
        if not _meet(node_box, p, box, other):
            continue
        a, b, c = np.uint64(triangles[other, 0]), np.uint64(triangles[other, 1]), np.uint64(triangles[other, 2])
        if (p != a) & (p != b) & (p != c) & (free[p] | free[a] | free[b] | free[c]):
            _write(0, s, count, np.int64(p) * FIRST + np.int64(other), p, a, b, c, key_out, nodes_out)
            count += 1
    return count


@inlined
def _edges_on(one, other, mesh, edge_box, key_out, nodes_out, s, count):
    """Likewise, of the edges for which two triangles speak."""
    edges, own_edge_start, own_edge, free = mesh[1], mesh[4], mesh[5], mesh[6]
    for i in range(own_edge_start[one], own_edge_start[one + np.uint64(1)]):
        for j in range(own_edge_start[other], own_edge_start[other + np.uint64(1)]):
            e, g = np.uint64(own_edge[np.uint64(i)]), np.uint64(own_edge[np.uint64(j)])
            if not _meet(edge_box, e, edge_box, g):
                continue
            e, g = min(e, g), max(e, g)
            a, b, c, d = np.uint64(edges[e, 0]), np.uint64(edges[e, 1]), np.uint64(edges[g, 0]), np.uint64(edges[g, 1])
            if (a != c) & (a != d) & (b != c) & (b != d) & (free[a] | free[b] | free[c] | free[d]):
                _write(1, s, count, EDGES + np.int64(e) * FIRST + np.int64(g), a, b, c, d, key_out, nodes_out)
                count += 1
    return count


@inlined
def _keep_near(kind, s, first_triangle, end, paths, ends, key, nodes, normal, block):
    """Of a slice's candidates of one kind keep those that may come near; ends: of those of each triangle, which become
    the numbers of those that are kept."""
    positions, velocities, skin, near, time = paths
    t, before, into = first_triangle, 0, 0
    for first in range(0, end, BLOCK):
        count = min(BLOCK, end - first)
        for j in range(count):
            a, b = np.uint64(nodes[kind, s, first + j, 0]), np.uint64(nodes[kind, s, first + j, 1])
            c, d = np.uint64(nodes[kind, s, first + j, 2]), np.uint64(nodes[kind, s, first + j, 3])
            fill(block, j, positions, a, b, c, d)
        if kind == 0:
            nodes_on_triangles(block)
        else:
            segments_on_segments(block)
        for j in range(count):
            while first + j >= ends[kind, t]:
                ends[kind, t], before = into - before, into
                t += 1
            a, b = np.uint64(nodes[kind, s, first + j, 0]), np.uint64(nodes[kind, s, first + j, 1])
            c, d = np.uint64(nodes[kind, s, first + j, 2]), np.uint64(nodes[kind, s, first + j, 3])
            square = block[SQUARE + j]
            per = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
            x, y, z = per * block[X + j], per * block[Y + j], per * block[Z + j]
            if kind == 0:
                reach = near + skin[a] + max(skin[b], skin[c], skin[d])
            else:
                reach = near + max(skin[a], skin[b]) + max(skin[c], skin[d])
            if square > reach * reach:
                at_a = along(positions, a, x, y, z) + time * along(velocities, a, x, y, z)
                at_b = along(positions, b, x, y, z) + time * along(velocities, b, x, y, z)
                at_c = along(positions, c, x, y, z) + time * along(velocities, c, x, y, z)
                at_d = along(positions, d, x, y, z) + time * along(velocities, d, x, y, z)
                if between(kind == 0, at_a, at_b, at_c, at_d) > reach:
                    continue
            key[kind, s, into] = key[kind, s, first + j]
            nodes[kind, s, into, 0], nodes[kind, s, into, 1] = a, b
            nodes[kind, s, into, 2], nodes[kind, s, into, 3] = c, d
            normal[kind, s, into, 0], normal[kind, s, into, 1], normal[kind, s, into, 2] = x, y, z
            into += 1
    return t, before, into


@kernel
def _find(
    n, mesh, paths, box, edge_box, node_box, spans, counts, first, listed, key_out, nodes_out, normal_out, found_out,
    met_out, room_out,
):  # fmt: skip
    """Pairs of each triangle with higher ones, (2, triangles) in found_out, as many of them as a slice has room for;
    what room it should have."""
    for s in prange((n + SLICE - 1) // SLICE):
        on, across, met = 0, 0, 0
        last_triangle = min(n, (s + 1) * SLICE)
        for item in range(s * SLICE, last_triangle):
            t = np.uint64(item)
            x0, y0, z0 = spans[t, 0], spans[t, 2], spans[t, 4]
            for x in range(x0, spans[t, 1] + 1):
                for y in range(y0, spans[t, 3] + 1):
                    row = (x * counts[1] + y) * counts[2]
                    for z in range(z0, spans[t, 5] + 1):
                        here = np.uint64(row + z)
                        last = first[here + np.uint64(1)]
                        for back in range(last - first[here]):
                            u = np.uint64(listed[np.uint64(last - 1 - back)])
                            if u <= t:  # a cell's triangles ascend
                                break
                            if not _meet(box, t, box, u):
                                continue
                            # Two boxes share several cells; the lowest of them counts.
                            if x != max(x0, spans[u, 0]) or y != max(y0, spans[u, 2]) or z != max(z0, spans[u, 4]):
                                continue
                            met += 1
                            on = _nodes_on(t, u, mesh, box, node_box, key_out, nodes_out, s, on)
                            on = _nodes_on(u, t, mesh, box, node_box, key_out, nodes_out, s, on)
                            across = _edges_on(t, u, mesh, edge_box, key_out, nodes_out, s, across)
            found_out[0, item], found_out[1, item] = on, across
        met_out[s], room_out[s] = met, max(on, across)
        if room_out[s] > key_out.shape[2]:
            continue
        block = np.zeros(ROWS * BLOCK)
        for kind in range(2):
            end = on if kind == 0 else across
            t, before, into = _keep_near(
                kind, s, s * SLICE, end, paths, found_out, key_out, nodes_out, normal_out, block
            )
            for rest in range(t, last_triangle):
                found_out[kind, rest], before = into - before, into


@kernel
def _pack(n, key, nodes, normal, found):
    """What slices found, one after the other; the pairs of a triangle in the order of their keys."""
    key_out, nodes_out, normal_out, begin = found
    for s in prange((n + SLICE - 1) // SLICE):
        order = np.empty(key.shape[2], np.int64)
        for kind in range(2):
            into = begin[kind * n + s * SLICE]
            for t in range(kind * n + s * SLICE, kind * n + min(n, (s + 1) * SLICE)):
                low, high = begin[t] - into, begin[t + 1] - into
                for i in range(low, high):
                    j = i
                    while j > low and key[kind, s, order[j - 1]] > key[kind, s, i]:
                        order[j] = order[j - 1]
                        j -= 1
                    order[j] = i
                for i in range(low, high):
                    at = order[i]
                    key_out[into + i] = key[kind, s, at]
                    for k in range(4):
                        nodes_out[into + i, k] = nodes[kind, s, at, k]
                    for k in range(3):
                        normal_out[into + i, k] = normal[kind, s, at, k]
