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

from billow.base.compiled import inlined, kernel, scalar
from billow.geometry.closest_blocks import BLOCK, ROWS, SQUARE, X, Y, Z, fill, nodes_on_triangles, segments_on_segments
from billow.geometry.search_grid import MOST_CELLS, cell_lists, clipped_cell
from billow.parts.layers.distance import between
from billow.parts.layers.mesh import TouchMesh
from billow.parts.layers.pairs import EDGES, FIRST, Room

SLICE = 64
"""Triangles that one thread looks at together."""

ENOUGH = 2048
"""Candidates, from half of which on they are looked at."""

LEAST_ROOM, SPARE = 512, 2.0
"""Places of a slice, at least and more than it needed in the last search, and the times by which they are more."""

LEAST_CELL, CELL_IN_BOXES = 1e-4, 1.5
"""Edge of a cell: at least [m], and in mean sizes of the boxes."""

NOWHERE = (math.inf, math.inf, math.inf, -math.inf, -math.inf, -math.inf)
"""A box that meets no other."""

ENDS, REACH, NEAR, MORE_ROWS = ROWS * BLOCK, (ROWS + 12) * BLOCK, (ROWS + 13) * BLOCK, ROWS + 14
"""More rows of a block: where the four nodes will be [m], how near a pair has to come [m], and whether it does."""

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


def find_pairs(mesh: TouchMesh, paths: Paths, room: Room | None = None) -> Found:
    """All pairs of which at least one node can move. room: whose memory is used; what was found with it before last is
    written over."""
    n, slices, room = len(mesh.triangles), -(-len(mesh.triangles) // SLICE), room or Room()
    box, edge_box, node_box = np.empty((n, 6)), np.empty((len(mesh.edges) + 1, 6)), np.empty((len(paths.skin) + 1, 6))
    edge_box[-1], node_box[-1] = NOWHERE, NOWHERE
    drift = np.ascontiguousarray(paths.velocities.T).mean(axis=1)  # along rows of three it takes ten times longer
    run = "parallel" if n >= PARALLEL_FROM and numba.get_num_threads() > 1 else "serial"
    ways = np.empty((len(paths.skin), 8))
    getattr(_boxes, run)(n, len(mesh.edges), tuple(mesh), tuple(paths), drift, ways, box, edge_box, node_box)
    sides = np.ascontiguousarray(box.T)
    low, high = sides[:3].min(axis=1), sides[3:].max(axis=1)
    cell = np.maximum(CELL_IN_BOXES * (sides[3:].mean(axis=1) - sides[:3].mean(axis=1)), LEAST_CELL)
    while True:
        counts = ((high - low) / cell).astype(np.int64) + 1
        if np.prod(counts.astype(float)) <= MOST_CELLS:
            break
        cell = 1.3 * cell
    spans = np.empty((n, 6), np.int32)
    _find_spans(n, box, low, cell, counts, spans)
    first, listed = cell_lists(spans, counts)
    begin = np.zeros(2 * n + 1, np.int64)
    found, met = begin[1:].reshape(2, n), np.empty(slices, np.int64)
    needed = room.needed if room.needed is not None else np.zeros((2, slices), np.int64)
    while True:
        places = np.zeros(2 * slices + 1, np.int64)
        np.cumsum(SPARE * needed.ravel() + LEAST_ROOM, out=places[1:])
        kept, way = room.array("kept", int(places[-1]), 2, np.int32), room.array("way", int(places[-1]), 3)
        needed = np.empty((2, slices), np.int64)
        getattr(_find, run)(
            n, tuple(mesh), ways, (paths.near, paths.edges_near), box, edge_box, node_box, spans, counts, first, listed,
            places, kept, way, found, met, needed,
        )  # fmt: skip
        if (needed.ravel() < np.diff(places)).all():  # one place is left over, for what does not count
            break
    room.needed = needed
    np.cumsum(begin, out=begin)
    total = int(begin[-1])
    pairs = Found(
        room.other("key", total, 0, np.int64), room.other("nodes", total, 4, np.int32), room.other("normal", total, 3),
        begin, int(met.sum()),
    )  # fmt: skip
    getattr(_pack, run)(n, tuple(mesh), places, kept, way, tuple(pairs[:4]))
    return pairs


@kernel
def _boxes(n, m, mesh, paths, drift, ways_out, box_out, edge_box_out, node_box):
    """Boxes, low and high corner, around the paths of n triangles, m edges, and nodes, seen by who flies with the
    velocity `drift` [m/s]; and of each node where it is, where it will be, and its skin, (nodes, 8) in ways_out."""
    triangles, edges = mesh[0], mesh[1]
    positions, velocities, skin, near, edges_near, time = paths
    for i in prange(len(positions)):
        reach = 0.5 * near + skin[i]
        ways_out[i, 6] = skin[i]
        for k in range(3):
            ways_out[i, k], ways_out[i, 3 + k] = positions[i, k], positions[i, k] + time * velocities[i, k]
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
def _nodes_on(one, other, lower, own_node, box, node_box, candidates, count):
    """Candidates of the pairs of triangle `lower`: the nodes for which triangle `one` speaks, and triangle `other`;
    returns how many there are."""
    for i in range(own_node.shape[1]):
        p = np.uint64(own_node[one, i])
        candidates[0, count, 0], candidates[0, count, 1], candidates[0, count, 2] = p, other, lower
        count += _meet(node_box, p, box, other)
    return count


@inlined
def _edges_on(lower, other, own_edge, edge_box, candidates, count):
    """Likewise, of the edges for which two triangles speak."""
    for i in range(own_edge.shape[1]):
        for j in range(own_edge.shape[1]):
            e, g = np.uint64(own_edge[lower, i]), np.uint64(own_edge[other, j])
            candidates[1, count, 0], candidates[1, count, 1] = min(e, g), max(e, g)
            candidates[1, count, 2] = lower
            count += _meet(edge_box, e, edge_box, g)
    return count


@inlined
def _members(kind, one, other, triangles, edges):
    """Nodes of a pair."""
    if kind == 0:
        return one, triangles[other, 0], triangles[other, 1], triangles[other, 2]
    return edges[one, 0], edges[one, 1], edges[other, 0], edges[other, 1]


@inlined
def _fill_ends(block, j, ways, a, b, c, d):
    """Rows of a block for where the four nodes of pair j will be."""
    block[ENDS + j], block[ENDS + BLOCK + j], block[ENDS + 2 * BLOCK + j] = ways[a, 3], ways[a, 4], ways[a, 5]
    block[ENDS + 3 * BLOCK + j], block[ENDS + 4 * BLOCK + j] = ways[b, 3], ways[b, 4]
    block[ENDS + 5 * BLOCK + j], block[ENDS + 6 * BLOCK + j] = ways[b, 5], ways[c, 3]
    block[ENDS + 7 * BLOCK + j], block[ENDS + 8 * BLOCK + j] = ways[c, 4], ways[c, 5]
    block[ENDS + 9 * BLOCK + j], block[ENDS + 10 * BLOCK + j] = ways[d, 3], ways[d, 4]
    block[ENDS + 11 * BLOCK + j] = ways[d, 5]


@inlined
def _judge(is_node, block):
    """Whether the pairs of a block come within their reach, now or at the end: NEAR is 1 or 0. Along the way between
    their closest points, whose length need not be known: squares are compared."""
    for j in range(BLOCK):
        x, y, z = block[X + j], block[Y + j], block[Z + j]
        a = x * block[ENDS + j] + y * block[ENDS + BLOCK + j] + z * block[ENDS + 2 * BLOCK + j]
        b = x * block[ENDS + 3 * BLOCK + j] + y * block[ENDS + 4 * BLOCK + j] + z * block[ENDS + 5 * BLOCK + j]
        c = x * block[ENDS + 6 * BLOCK + j] + y * block[ENDS + 7 * BLOCK + j] + z * block[ENDS + 8 * BLOCK + j]
        d = x * block[ENDS + 9 * BLOCK + j] + y * block[ENDS + 10 * BLOCK + j] + z * block[ENDS + 11 * BLOCK + j]
        apart = between(is_node, a, b, c, d)
        square, reach = block[SQUARE + j], block[REACH + j] * block[REACH + j]
        far = (square > reach) & (apart > 0.0) & (apart * apart > reach * square)
        block[NEAR + j] = 0.0 if far else 1.0


@scalar
def _keep_near(kind, end, place, last, mesh, ways, near, candidates, kept, way_out, found_out, block):
    """Of candidates of one kind keep those that may come near, from a place on: returns the next one, which may be past
    the last; and how many there are of each triangle in found_out. Called for many at once, so that it need not be
    compiled anew for serial and parallel searches."""
    triangles, edges, free = mesh[0], mesh[1], mesh[4]
    own = np.empty(BLOCK, np.bool_)
    for begin in range(0, end, BLOCK):
        count = min(BLOCK, end - begin)
        for j in range(count):
            at = begin + j
            m, n, o, p = _members(kind, candidates[kind, at, 0], candidates[kind, at, 1], triangles, edges)
            a, b, c, d = np.uint64(m), np.uint64(n), np.uint64(o), np.uint64(p)
            shared = (a == c) | (a == d) | ((a == b) if kind == 0 else ((b == c) | (b == d)))
            own[j] = (not shared) & (free[a] | free[b] | free[c] | free[d])
            fill(block, j, ways, a, b, c, d)
            _fill_ends(block, j, ways, a, b, c, d)
            if kind == 0:
                block[REACH + j] = near + ways[a, 6] + max(ways[b, 6], ways[c, 6], ways[d, 6])
            else:
                block[REACH + j] = near + max(ways[a, 6], ways[b, 6]) + max(ways[c, 6], ways[d, 6])
        if kind == 0:
            nodes_on_triangles(block)
        else:
            segments_on_segments(block)
        _judge(kind == 0, block)
        for j in range(count):
            at, keep, into = begin + j, own[j] & (block[NEAR + j] > 0.0), min(place, last)
            kept[into, 0], kept[into, 1] = candidates[kind, at, 0], candidates[kind, at, 1]
            way_out[into, 0], way_out[into, 1] = block[X + j], block[Y + j]
            way_out[into, 2] = block[Z + j]
            found_out[kind, np.uint64(candidates[kind, at, 2])] += keep
            place += keep
    return place


@kernel
def _find(
    n, mesh, ways, near, box, edge_box, node_box, spans, counts, first, listed, places, kept_out, way_out, found_out,
    met_out, needed_out,
):  # fmt: skip
    """Pairs of each triangle with higher ones, (2, triangles) in found_out, as many of them as a slice has places for;
    and how many it needs, (2, slices). ways: of the nodes, from `_boxes`; near: distances of the two kinds that matter
    [m]; places: the first of each kind and slice, and the end, (2 slices + 1,)."""
    slices = (n + SLICE - 1) // SLICE
    per_met = max(2 * mesh[2].shape[1], mesh[3].shape[1] ** 2)
    for s in prange((n + SLICE - 1) // SLICE):
        on, across, met, on_place, across_place = 0, 0, 0, places[s], places[slices + s]
        others, block = np.empty(n, np.uint32), np.zeros(MORE_ROWS * BLOCK)
        candidates = np.empty((2, ENOUGH, 3), np.int32)
        last_triangle = min(n, (s + 1) * SLICE)
        for item in range(s * SLICE, last_triangle):
            t, count = np.uint64(item), 0
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
                            if x == max(x0, spans[u, 0]) and y == max(y0, spans[u, 2]) and z == max(z0, spans[u, 4]):
                                others[count] = u
                                count += 1
            if max(on, across) + per_met * count > candidates.shape[1]:
                more = np.empty((2, 2 * (max(on, across) + per_met * count), 3), np.int32)
                more[:, : max(on, across)] = candidates[:, : max(on, across)]
                candidates = more
            for i in range(count):
                u = np.uint64(others[i])
                on = _nodes_on(t, u, t, mesh[2], box, node_box, candidates, on)
                on = _nodes_on(u, t, t, mesh[2], box, node_box, candidates, on)
                across = _edges_on(t, u, mesh[3], edge_box, candidates, across)
            met += count
            found_out[0, item], found_out[1, item] = 0, 0
            # Many at once, so that most blocks are full.
            if 2 * max(on, across) > ENOUGH or item == last_triangle - 1:
                on_place = _keep_near(
                    0, on, on_place, places[s + 1] - 1, mesh, ways, near[0], candidates, kept_out, way_out, found_out,
                    block,
                )  # fmt: skip
                across_place = _keep_near(
                    1, across, across_place, places[slices + s + 1] - 1, mesh, ways, near[1], candidates, kept_out,
                    way_out, found_out, block,
                )  # fmt: skip
                on, across = 0, 0
        met_out[s] = met
        needed_out[0, s], needed_out[1, s] = on_place - places[s], across_place - places[slices + s]


@kernel
def _pack(n, mesh, places, kept, way, pairs):
    """What slices found, one after the other; the pairs of a triangle in the order of their keys."""
    key_out, nodes_out, normal_out, begin = pairs
    slices = (n + SLICE - 1) // SLICE
    for s in prange(slices):
        for kind in range(2):
            place, into = places[kind * slices + s], begin[kind * n + s * SLICE]
            most = places[kind * slices + s + 1] - place
            order, key = np.empty(most, np.int64), np.empty(most, np.int64)
            for t in range(kind * n + s * SLICE, kind * n + min(n, (s + 1) * SLICE)):
                for i in range(begin[t] - into, begin[t + 1] - into):
                    key[i] = kind * EDGES + np.int64(kept[place + i, 0]) * FIRST + np.int64(kept[place + i, 1])
                    j = i
                    while j > begin[t] - into and key[order[j - 1]] > key[i]:
                        order[j] = order[j - 1]
                        j -= 1
                    order[j] = i
                for i in range(begin[t] - into, begin[t + 1] - into):
                    at, to = place + order[i], into + i
                    a, b, c, d = _members(kind, kept[at, 0], kept[at, 1], mesh[0], mesh[1])
                    key_out[to] = key[order[i]]
                    nodes_out[to, 0], nodes_out[to, 1], nodes_out[to, 2], nodes_out[to, 3] = a, b, c, d
                    x, y, z = way[at, 0], way[at, 1], way[at, 2]
                    size = math.sqrt(x * x + y * y + z * z)
                    per = 1.0 / size if size > 0.0 else 0.0
                    normal_out[to, 0], normal_out[to, 1], normal_out[to, 2] = per * x, per * y, per * z
