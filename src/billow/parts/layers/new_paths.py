"""New paths for a few nodes: what they need is searched for and spliced into a list that goes on serving all others.

A list is spent when one node has used its skin, and then hardly another one has used half of its own. So only pairs of
nodes that get new paths are searched for: of these nodes with triangles, of their triangles with other nodes, of their
edges with all edges. A ring of triangles that the list passes over is looked at again where one of these nodes is in
it: two others of the ring are no nearer than they would have been.
"""

from __future__ import annotations

import numpy as np

from billow.base.compiled import kernel, scalar
from billow.parts.layers.groups import boxes_of_groups, level_starts
from billow.parts.layers.mesh import TouchMesh
from billow.parts.layers.pairs import FIRST, Room
from billow.parts.layers.rings import Shapes, open_rings, widened
from billow.parts.layers.search import ACROSS, ACROSS_ALL, ON, UNDER, Found, Kept, Look, Paths, pack


def find_pairs_of(mesh: TouchMesh, paths: Paths, strayed: np.ndarray, room: Room) -> Found:
    """All pairs of which a node strayed, (nodes,) bool. room: of the list."""
    look = Look.along(mesh, paths, room)
    room.shapes = room.shapes or Shapes(mesh.rings)
    near = max(paths.near, paths.edges_near)
    is_open = open_rings(mesh.rings, room.shapes, look.ways, near, widened(mesh.rings, strayed))
    few = room.beside("few")
    nodes, lists, begins, met = len(mesh.nodes), [], [np.zeros(1, np.int64)], 0
    for kinds, count in (((ON, UNDER), nodes), ((ACROSS_ALL,), len(mesh.edges))):
        kept = [_ask(look, kind, strayed, is_open, few) for kind in kinds]
        items, ways = (np.concatenate(parts) for parts in zip(*(_together(each) for each in kept), strict=True))
        order = np.argsort(items[:, 0] * np.int64(FIRST) + items[:, 1])
        lists.append((items[order], ways[order]))
        begins.append(np.bincount(items[:, 0], minlength=count))
        met += sum(int(each.met.sum()) for each in kept)
    begin = np.concatenate(begins).cumsum()
    pairs = Found.empty(few, begin, met)
    for kind, (items, ways) in enumerate(lists):
        ends = begin[[0, nodes]] if kind == ON else begin[[nodes, -1]]
        pack.serial(1, kind, mesh[:3], np.zeros(1, np.int64), items, ways, ends, pairs.written)
    return pairs


def _ask(look: Look, kind: int, strayed: np.ndarray, is_open: np.ndarray, room: Room) -> Kept:
    """Pairs of the items of which a node strayed, (nodes,) bool."""
    mesh, side = look.mesh, {ON: 0, UNDER: 1, ACROSS_ALL: 2}[kind]
    members, columns = ((mesh.nodes.reshape(-1, 1), 1), (mesh.triangles, 3), (mesh.edges, 2))[side]
    items = np.empty(len(members), np.int32)
    items = items[: _choose(len(members), members, columns, strayed, items)]
    starts = level_starts(len(items))
    boxes = np.empty((6, starts[-1]), np.float32)
    boxes[:, : len(items)] = look.sides[side][:, items]
    boxes[:3, len(items) : starts[1]], boxes[3:, len(items) : starts[1]] = np.inf, -np.inf
    boxes_of_groups(boxes, starts)
    of_first = np.empty(len(mesh.edges) if kind & ACROSS else len(mesh.nodes), np.int64)
    return look.ask(kind, items, boxes, starts, is_open, strayed, room, of_first)


def _together(kept: Kept) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and ways of what all slices found."""
    where = np.concatenate([np.zeros(0, np.int64), *map(np.arange, kept.places[:-1], kept.places[:-1] + kept.needed)])
    return kept.items[where], kept.way[where]


@kernel
def _choose(n, members, columns, strayed, items_out):
    """Numbers of the n items of which one of the first `columns` members strayed; returns how many they are."""
    count = 0
    for i in range(n):
        is_one = False
        for c in range(columns):
            is_one = is_one | strayed[members[i, c]]
        items_out[count] = i
        count += is_one
    return count


@kernel
def splice(n, begin, old, strayed, new_begin, new, begin_out, spliced_out):
    """A list without its pairs of nodes that strayed, (nodes,) bool, and with those of another one; keys ascend in
    each of n groups. Of each list: key, nodes, normal, level, gap, impulse. Returns how many pairs there are."""
    key, nodes, new_key = old[0], old[1], new[0]
    m, run = 0, begin[0]
    begin_out[0] = 0
    for t in range(n):
        j, last = new_begin[t], new_begin[t + 1]
        for i in range(begin[t], begin[t + 1]):
            a, b, c, d = np.uint64(nodes[i, 0]), np.uint64(nodes[i, 1]), np.uint64(nodes[i, 2]), np.uint64(nodes[i, 3])
            dropped = strayed[a] | strayed[b] | strayed[c] | strayed[d]
            if dropped or (j < last and new_key[j] < key[i]):
                m, run = _copy(old, run, i, m, spliced_out), i + dropped
                first = j
                while j < last and new_key[j] < key[i]:
                    j += 1
                m = _copy(new, first, j, m, spliced_out)
        if j < last:
            m, run = _copy(old, run, begin[t + 1], m, spliced_out), begin[t + 1]
            m = _copy(new, j, last, m, spliced_out)
        begin_out[t + 1] = m + begin[t + 1] - run
    return _copy(old, run, begin[n], m, spliced_out)


@scalar
def _copy(pairs, first, end, into, spliced_out):
    """Pairs from the first one on go into a place of another list; returns the next place."""
    for i in range(first, end):
        spliced_out[0][into + i - first] = pairs[0][i]
    for i in range(first, end):
        for k in range(4):
            spliced_out[1][into + i - first, k] = pairs[1][i, k]
    for i in range(first, end):
        for k in range(3):
            spliced_out[2][into + i - first, k] = pairs[2][i, k]
    for i in range(first, end):
        spliced_out[3][into + i - first] = pairs[3][i]
    for i in range(first, end):
        spliced_out[4][into + i - first] = pairs[4][i]
    for i in range(first, end):
        spliced_out[5][into + i - first] = pairs[5][i]
    return into + end - first
