"""Search for pairs: whatever can come near within a time, if every node keeps to a straight path but for a skin.

A pair is kept if boxes around the paths of its sides meet, and if along the way between its closest points the sides
come nearer than what is near, plus the skins of both, now or at the end (`distance`). A stack that flies together
therefore needs no new list, however fast it flies, nor do layers that slide.

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
from billow.parts.layers.pairs import EDGES, FIRST, Room

SLICE = 64
"""Triangles that one thread looks at together."""

LEAST_ROOM, SPARE = 256, 1.5
"""Of a slice, in pairs, in a first try; and the factor by which room is more than what was missing."""

LEAST_CELL, CELL_IN_BOXES = 1e-4, 1.5
"""Edge of a cell: at least [m], and in mean sizes of the boxes."""

NOWHERE = (math.inf, math.inf, math.inf, -math.inf, -math.inf, -math.inf)
"""A box that meets no other."""

PARALLEL_FROM = 1000
"""Fewest triangles for which a search with all threads pays: it takes about a millisecond."""


class Paths(NamedTuple):
    """Nodes on their way: positions [m] and velocities [m/s], (nodes, 3); skin: how far each may stray [m], (nodes,).
    near: distance of a node and a triangle that matters [m]; edges_near: of two edges, which is no more [m]; time: how
    long the pairs have to serve [s]."""

    positions: np.ndarray
    velocities: np.ndarray
    skin: np.ndarray
    near: float
    edges_near: float
    time: float


class Found(NamedTuple):
    """Pairs in their order: key, nodes, normal and begin as in `Pairs`. looked_at: pairs of triangles whose boxes
    meet."""

    key: np.ndarray
    nodes: np.ndarray
    normal: np.ndarray
    begin: np.ndarray
    looked_at: int


def find_pairs(mesh: TouchMesh, paths: Paths, room: Room | None = None) -> tuple[Found, Room]:
    """All pairs of which at least one node can move, and the room that they took, for the next search."""
    n, slices = len(mesh.triangles), -(-len(mesh.triangles) // SLICE)
    box, edge_box, node_box = np.empty((n, 6)), np.empty((len(mesh.edges) + 1, 6)), np.empty((len(paths.skin) + 1, 6))
    edge_box[-1], node_box[-1] = NOWHERE, NOWHERE
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
    begin, room = np.zeros(2 * n + 1, np.int64), room or Room.of(slices, LEAST_ROOM)
    found, met, rooms = begin[1:].reshape(2, n), np.empty(slices, np.int64), np.empty(slices, np.int64)
    while True:
        getattr(_find, run)(
            n, tuple(mesh), tuple(paths), box, edge_box, node_box, spans, counts, first, listed, room.one, room.other,
            room.normal, found, met, rooms,
        )  # fmt: skip
        most = int(rooms.max(initial=0))
        if most < room.one.shape[2]:  # one place is left over, for what does not count
            break
        room = Room.of(slices, int(SPARE * most) + 1)
    np.cumsum(begin, out=begin)
    total = int(begin[-1])
    pairs = Found(
        np.empty(total, np.int64), np.empty((total, 4), np.int32), np.empty((total, 3)), begin, int(met.sum())
    )
    getattr(_pack, run)(n, tuple(mesh), room.one, room.other, room.normal, tuple(pairs[:4]))
    return pairs, room


@kernel
def _boxes(n, m, mesh, paths, drift, box_out, edge_box_out, node_box):
    """Boxes, low and high corner, around the paths of n triangles, m edges, and nodes, seen by who flies with the
    velocity `drift` [m/s]."""
    triangles, edges = mesh[0], mesh[1]
    positions, velocities, skin, near, edges_near, time = paths
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
            edge_box_out[e, k] = min(node_box[a, k], node_box[b, k]) + 0.5 * (near - edges_near)
            edge_box_out[e, 3 + k] = max(node_box[a, 3 + k], node_box[b, 3 + k]) - 0.5 * (near - edges_near)


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
def _nodes_on(one, other, own_node, box, node_box, first_out, second_out, s, count):
    """Candidates: the nodes for which triangle `one` speaks, and triangle `other`; returns how many a slice has."""
    for i in range(own_node.shape[1]):
        p, slot = np.uint64(own_node[one, i]), min(count, first_out.shape[2] - 1)
        first_out[0, s, slot], second_out[0, s, slot] = p, other
        count += _meet(node_box, p, box, other)
    return count


@inlined
def _edges_on(one, other, own_edge, edge_box, first_out, second_out, s, count):
    """Likewise, of the edges for which two triangles speak."""
    for i in range(own_edge.shape[1]):
        for j in range(own_edge.shape[1]):
            e, g = np.uint64(own_edge[one, i]), np.uint64(own_edge[other, j])
            slot = min(count, first_out.shape[2] - 1)
            first_out[1, s, slot], second_out[1, s, slot] = e, g
            count += _meet(edge_box, e, edge_box, g)
    return count


@inlined
def _members(kind, one, other, triangles, edges):
    """Nodes of a pair."""
    if kind == 0:
        return one, triangles[other, 0], triangles[other, 1], triangles[other, 2]
    return edges[one, 0], edges[one, 1], edges[other, 0], edges[other, 1]


@inlined
def _keep_near(kind, s, triangle, end, mesh, paths, ends, one, other, normal, block):
    """Of a slice's candidates of one kind keep those that may come near; ends: of those of each triangle, from
    `triangle` on, which become the numbers of those that are kept."""
    triangles, edges, free = mesh[0], mesh[1], mesh[4]
    positions, velocities, skin, near, edges_near, time = paths
    t, before, into, at = triangle, 0, 0, 0
    members, place = np.empty((BLOCK, 4), np.int32), np.empty(BLOCK, np.int64)
    while at < end:
        count = 0
        while at < end and count < BLOCK:
            first, second = one[kind, s, at], other[kind, s, at]
            if kind == 1:
                first, second = min(first, second), max(first, second)
                one[kind, s, at], other[kind, s, at] = first, second
            m, n, o, p = _members(kind, first, second, triangles, edges)
            a, b, c, d = np.uint64(m), np.uint64(n), np.uint64(o), np.uint64(p)
            shared = (a == c) | (a == d) | ((a == b) if kind == 0 else ((b == c) | (b == d)))
            if not shared and (free[a] | free[b] | free[c] | free[d]):
                members[count, 0], members[count, 1], members[count, 2], members[count, 3] = m, n, o, p
                place[count] = at
                fill(block, count, positions, a, b, c, d)
                count += 1
            at += 1
        if kind == 0:
            nodes_on_triangles(block)
        else:
            segments_on_segments(block)
        for j in range(count):
            while place[j] >= ends[kind, t]:
                ends[kind, t], before = into - before, into
                t += 1
            a, b = np.uint64(members[j, 0]), np.uint64(members[j, 1])
            c, d = np.uint64(members[j, 2]), np.uint64(members[j, 3])
            square = block[SQUARE + j]
            per = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
            x, y, z = per * block[X + j], per * block[Y + j], per * block[Z + j]
            if kind == 0:
                reach = near + skin[a] + max(skin[b], skin[c], skin[d])
            else:
                reach = edges_near + max(skin[a], skin[b]) + max(skin[c], skin[d])
            if square > reach * reach:
                at_a = along(positions, a, x, y, z) + time * along(velocities, a, x, y, z)
                at_b = along(positions, b, x, y, z) + time * along(velocities, b, x, y, z)
                at_c = along(positions, c, x, y, z) + time * along(velocities, c, x, y, z)
                at_d = along(positions, d, x, y, z) + time * along(velocities, d, x, y, z)
                if between(kind == 0, at_a, at_b, at_c, at_d) > reach:
                    continue
            one[kind, s, into], other[kind, s, into] = one[kind, s, place[j]], other[kind, s, place[j]]
            normal[kind, s, into, 0], normal[kind, s, into, 1], normal[kind, s, into, 2] = x, y, z
            into += 1
    return t, before, into


@kernel
def _find(
    n, mesh, paths, box, edge_box, node_box, spans, counts, first, listed, one, other, normal_out, found_out,
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
                            on = _nodes_on(t, u, mesh[2], box, node_box, one, other, s, on)
                            on = _nodes_on(u, t, mesh[2], box, node_box, one, other, s, on)
                            across = _edges_on(t, u, mesh[3], edge_box, one, other, s, across)
            found_out[0, item], found_out[1, item] = on, across
        met_out[s], room_out[s] = met, max(on, across)
        if room_out[s] >= one.shape[2]:
            continue
        block = np.zeros(ROWS * BLOCK)
        for kind in range(2):
            end = on if kind == 0 else across
            t, before, into = _keep_near(kind, s, s * SLICE, end, mesh, paths, found_out, one, other, normal_out, block)
            for rest in range(t, last_triangle):
                found_out[kind, rest], before = into - before, into


@kernel
def _pack(n, mesh, one, other, normal, pairs):
    """What slices found, one after the other; the pairs of a triangle in the order of their keys."""
    key_out, nodes_out, normal_out, begin = pairs
    for s in prange((n + SLICE - 1) // SLICE):
        order, key = np.empty(one.shape[2], np.int64), np.empty(one.shape[2], np.int64)
        for kind in range(2):
            into = begin[kind * n + s * SLICE]
            for t in range(kind * n + s * SLICE, kind * n + min(n, (s + 1) * SLICE)):
                for i in range(begin[t] - into, begin[t + 1] - into):
                    key[i] = kind * EDGES + np.int64(one[kind, s, i]) * FIRST + np.int64(other[kind, s, i])
                    j = i
                    while j > begin[t] - into and key[order[j - 1]] > key[i]:
                        order[j] = order[j - 1]
                        j -= 1
                    order[j] = i
                for i in range(begin[t] - into, begin[t + 1] - into):
                    at, to = order[i], into + i
                    a, b, c, d = _members(kind, one[kind, s, at], other[kind, s, at], mesh[0], mesh[1])
                    key_out[to] = key[at]
                    nodes_out[to, 0], nodes_out[to, 1], nodes_out[to, 2], nodes_out[to, 3] = a, b, c, d
                    for k in range(3):
                        normal_out[to, k] = normal[kind, s, at, k]
