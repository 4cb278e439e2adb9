"""Search for pairs: whatever can come near within a time, if every node keeps to a straight path but for a skin.

A pair is kept if boxes around the paths of its sides meet, and if along the way between its closest points the sides
come nearer than what is near, plus the skins of both, now or at the end (`distance`). A stack that flies together
therefore needs no new list, however fast it flies, nor do layers that slide.

Nodes are held against triangles and edges against edges, each against those in the groups of eight neighbours whose box
its own group's box meets, all of them at once; what lies in one ring that stays open is passed over. Pairs of nodes and
triangles come first, then those of edges, each by their first, and those of one by their second: the order does not
depend on the search.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numba import prange

from billow.base.compiled import inlined, kernel, scalar
from billow.geometry.closest_blocks import BLOCK, ROWS, SQUARE, X, Y, Z, fill, nodes_on_triangles, segments_on_segments
from billow.geometry.neighbours import GROUP
from billow.parts.layers.distance import between
from billow.parts.layers.groups import OUTWARD, boxes_of_groups, level_starts
from billow.parts.layers.mesh import TouchMesh
from billow.parts.layers.pairs import EDGES, FIRST, LEVELS, Room
from billow.parts.layers.rings import Shapes, open_rings

ON, ACROSS, UNDER, ACROSS_ALL = range(4)
"""Which pairs are asked for: those of a node with triangles, of an edge with edges of higher numbers, of a triangle
with nodes that did not stray, and of an edge with all edges."""
EVERYTHING = ON, ACROSS
"""Kinds that are asked for of all items at once."""

SLICE = 1024
"""Items that one thread looks at together."""

LEAST_ROOM, SPARE = 512, 2.0
"""Places of a slice, at least and more than it needed in the last search, and the times by which they are more."""

ENDS, REACH, SKINS, SLACK = ROWS * BLOCK, (ROWS + 12) * BLOCK, (ROWS + 13) * BLOCK, (ROWS + 14) * BLOCK
MORE_ROWS = ROWS + 15
"""More rows of a block: where the four nodes will be [m], how near a pair has to come to matter [m], the skins of both
its sides [m], and by how much it stays farther apart, in these skins."""

ROUNDED = 1.0 + 1e-9
"""Share of its skins that a pair has to stay farther apart to be left out."""

PARALLEL_FROM = 1000
"""Fewest triangles for which a search with all threads pays: it takes about a millisecond."""


class Paths(NamedTuple):
    """Nodes on their way: positions [m] and velocities [m/s], (nodes, 3); skin: how far each may stray [m], (nodes,).
    near: distance of a node and a triangle that matters [m]; edges_near: of two edges, which is no more [m]; time: how
    long the pairs have to serve [s]; ready: how much farther apart a pair may matter in a step [m]."""

    positions: np.ndarray
    velocities: np.ndarray
    skin: np.ndarray
    near: float
    edges_near: float
    time: float
    ready: float = 0.0


class Found(NamedTuple):
    """Pairs in their order: key, nodes, normal, begin and level as in `Pairs`. looked_at: candidates whose boxes
    meet."""

    key: np.ndarray
    nodes: np.ndarray
    normal: np.ndarray
    begin: np.ndarray
    level: np.ndarray
    looked_at: int

    @classmethod
    def empty(cls, room: Room, begin: np.ndarray, looked_at: int) -> Found:
        """Nothing yet, but room for as many as begin says."""
        total = int(begin[-1])
        return cls(
            room.other("key", total, 0, np.int64), room.other("nodes", total, 4, np.int32),
            room.other("normal", total, 3), begin, room.other("level", total, 0, np.uint8), looked_at,
        )  # fmt: skip

    @property
    def written(self) -> tuple[np.ndarray, ...]:
        """What `pack` writes."""
        return self.key, self.nodes, self.normal, self.level


def find_pairs(mesh: TouchMesh, paths: Paths, room: Room | None = None) -> Found:
    """All pairs of which at least one node can move. room: whose memory is used; what was found with it before last is
    written over."""
    room = room or Room()
    look = Look.along(mesh, paths, room)
    room.shapes = room.shapes or Shapes(mesh.rings)
    is_open = open_rings(mesh.rings, room.shapes, look.ways, max(paths.near, paths.edges_near))
    begin, nobody, lists = np.zeros(len(mesh.nodes) + len(mesh.edges) + 1, np.int64), np.zeros(0, np.bool_), []
    for kind, side in ((ON, 0), (ACROSS, 2)):
        everything = np.arange((len(mesh.nodes), len(mesh.edges))[kind], dtype=np.int32)
        boxes = everything, look.sides[side], look.starts[side]
        lists.append(look.ask(kind, *boxes, is_open, nobody, room, _of_kind(begin, kind, mesh)[1:]))
    np.cumsum(begin, out=begin)
    pairs = Found.empty(room, begin, sum(int(kept.met.sum()) for kept in lists))
    for kind, kept in enumerate(lists):
        of_kind = _of_kind(begin, kind, mesh)
        getattr(pack, look.run)(
            len(of_kind) - 1, kind, mesh[:3], kept.places, kept.items, kept.way, of_kind, pairs.written
        )  # fmt: skip
    return pairs


def _of_kind(begin: np.ndarray, kind: int, mesh: TouchMesh) -> np.ndarray:
    return begin[: 1 + len(mesh.nodes)] if kind == ON else begin[len(mesh.nodes) :]


class Kept(NamedTuple):
    """What slices found. items: first and second number of each pair, and its level, (places, 3) int32; way: from the
    second side to the first [m], (places, 3); places: where each slice begins, and the end; needed, met: pairs and
    candidates of each slice."""

    items: np.ndarray
    way: np.ndarray
    places: np.ndarray
    needed: np.ndarray
    met: np.ndarray


class Look(NamedTuple):
    """A look along all paths. run: how kernels are run that look at everything. ways: of the nodes, from `_boxes`;
    starts, sides: of nodes, triangles and edges, where each level of boxes begins, and the boxes, as low and high
    coordinates, (6, boxes)."""

    mesh: TouchMesh
    paths: Paths
    run: str
    ways: np.ndarray
    starts: list[np.ndarray]
    sides: list[np.ndarray]

    @classmethod
    def along(cls, mesh: TouchMesh, paths: Paths, room: Room) -> Look:
        run = "parallel" if len(mesh.triangles) >= PARALLEL_FROM and numba.get_num_threads() > 1 else "serial"
        starts = [level_starts(count) for count in (len(mesh.nodes), len(mesh.triangles), len(mesh.edges))]
        node_box, ways = np.empty((len(paths.skin), 6)), np.empty((len(paths.skin), 8))
        drift = np.ascontiguousarray(paths.velocities.T).mean(axis=1)  # along rows of three it takes ten times longer
        sides = [room.array(f"sides {k}", 6 * starts[k][-1], 0, np.float32).reshape(6, -1) for k in range(3)]
        getattr(_boxes, run)(len(mesh.triangles), mesh[:3], tuple(paths[:6]), drift, ways, node_box, tuple(sides))
        for boxes, levels in zip(sides, starts, strict=True):
            boxes_of_groups(boxes, levels)
        return cls(mesh, paths, run, ways, starts, sides)

    def ask(self, kind: int, items, boxes, starts, is_open, strayed, room: Room, found: np.ndarray) -> Kept:
        """Pairs of some items, with their boxes, as in `_find`. room: whose memory is used; found: gets how many pairs
        each first side has."""
        target, slices, run = (1, 2, 0, 2)[kind], -(-len(items) // SLICE), self.run if kind in EVERYTHING else "serial"
        needed = np.resize(room.needed.get(kind, np.zeros(1, np.int64)), slices)
        while True:
            places = np.zeros(slices + 1, np.int64)
            np.cumsum(SPARE * needed + LEAST_ROOM, out=places[1:])
            kept = room.array(f"kept {kind}", int(places[-1]), 3, np.int32)
            way, met = room.array(f"way {kind}", int(places[-1]), 3), np.empty(slices, np.int64)
            needed, found[:] = np.empty(slices, np.int64), 0
            getattr(_find, run)(
                len(items), kind, (*self.mesh[:4], *self.mesh.rings[:2]), self.ways, is_open, strayed,
                self.paths.edges_near if kind & 1 else self.paths.near, self.paths.ready, items, boxes, starts,
                self.sides[target], self.starts[target], places, kept, way, found, met, needed,
            )  # fmt: skip
            if (needed < np.diff(places)).all():  # one place is left over, for what does not count
                break
        if slices:
            room.needed[kind] = needed
        return Kept(kept, way, places, needed, met)


@kernel
def _boxes(n, mesh, paths, drift, ways_out, node_box, sides_out):
    """Boxes around the paths of nodes, n triangles, and edges, seen by who flies with the velocity `drift` [m/s], as
    low and high coordinates, (6, boxes); and of each node where it is, where it will be, and its skin, (nodes, 8) in
    ways_out."""
    triangles, edges, nodes = mesh
    positions, velocities, skin, near, edges_near, time = paths
    of_nodes, of_triangles, of_edges = sides_out
    for i in prange(len(positions)):
        reach = 0.5 * near + skin[i]
        ways_out[i, 6] = skin[i]
        for k in range(3):
            ways_out[i, k], ways_out[i, 3 + k] = positions[i, k], positions[i, k] + time * velocities[i, k]
            way = time * (velocities[i, k] - drift[k])
            low, high = positions[i, k] + min(0.0, way) - reach, positions[i, k] + max(0.0, way) + reach
            node_box[i, k], node_box[i, 3 + k] = low - OUTWARD * abs(low), high + OUTWARD * abs(high)
    for i in range(len(nodes)):
        for k in range(6):
            of_nodes[k, i] = node_box[nodes[i], k]
    for t in prange(n):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for k in range(3):
            of_triangles[k, t] = min(node_box[a, k], node_box[b, k], node_box[c, k])
            of_triangles[3 + k, t] = max(node_box[a, 3 + k], node_box[b, 3 + k], node_box[c, 3 + k])
    for e in prange(len(edges)):
        a, b = edges[e, 0], edges[e, 1]
        for k in range(3):
            of_edges[k, e] = min(node_box[a, k], node_box[b, k]) + 0.5 * (near - edges_near)
            of_edges[3 + k, e] = max(node_box[a, 3 + k], node_box[b, 3 + k]) - 0.5 * (near - edges_near)
    for kind in range(3):
        boxes, count = sides_out[kind], (len(nodes), n, len(edges))[kind]
        for i in range(count, 8 * ((count + 7) // 8)):
            for k in range(3):
                boxes[k, i], boxes[3 + k, i] = np.inf, -np.inf


@inlined
def _members(kind, one, other, mesh):
    """Nodes of a pair."""
    if kind == 0:
        return mesh[2][one], mesh[0][other, 0], mesh[0][other, 1], mesh[0][other, 2]
    return mesh[1][one, 0], mesh[1][one, 1], mesh[1][other, 0], mesh[1][other, 1]


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
    """By how much the pairs of a block stay farther apart than their reach, now and at the end, along the way between
    their closest points."""
    for j in range(BLOCK):
        x, y, z = block[X + j], block[Y + j], block[Z + j]
        a = x * block[ENDS + j] + y * block[ENDS + BLOCK + j] + z * block[ENDS + 2 * BLOCK + j]
        b = x * block[ENDS + 3 * BLOCK + j] + y * block[ENDS + 4 * BLOCK + j] + z * block[ENDS + 5 * BLOCK + j]
        c = x * block[ENDS + 6 * BLOCK + j] + y * block[ENDS + 7 * BLOCK + j] + z * block[ENDS + 8 * BLOCK + j]
        d = x * block[ENDS + 9 * BLOCK + j] + y * block[ENDS + 10 * BLOCK + j] + z * block[ENDS + 11 * BLOCK + j]
        apart, size = between(is_node, a, b, c, d), math.sqrt(block[SQUARE + j])
        then = apart / (size if size > 0.0 else 1.0)
        block[SLACK + j] = ((then if then < size else size) - block[REACH + j]) / block[SKINS + j]


@scalar
def _keep_near(kind, count, place, last, mesh, ways, near, ready, candidates, kept, way_out, found_out, block):
    """Of a block of candidates (2, count) keep those that may come near, from a place on: returns the next one, which
    may be past the last. kind: of the pair, ON or ACROSS. found_out: how many there are of each first."""
    free = mesh[3]
    for j in range(count):
        m, n, o, p = _members(kind, candidates[0, j], candidates[1, j], mesh)
        a, b, c, d = np.uint64(m), np.uint64(n), np.uint64(o), np.uint64(p)
        fill(block, j, ways, a, b, c, d)
        _fill_ends(block, j, ways, a, b, c, d)
        block[REACH + j] = near
        if kind == 0:
            block[SKINS + j] = ways[a, 6] + max(ways[b, 6], ways[c, 6], ways[d, 6])
        else:
            block[SKINS + j] = max(ways[a, 6], ways[b, 6]) + max(ways[c, 6], ways[d, 6])
        if not (free[a] | free[b] | free[c] | free[d]):
            block[REACH + j] = -np.inf
    if kind == 0:
        nodes_on_triangles(block)
    else:
        segments_on_segments(block)
    _judge(kind == 0, block)
    for j in range(count):
        keep, into = block[SLACK + j] <= ROUNDED, min(place, last)
        level = LEVELS * (block[SLACK + j] - ready / block[SKINS + j])
        kept[into, 0], kept[into, 1], kept[into, 2] = candidates[0, j], candidates[1, j], max(0.0, level)
        way_out[into, 0], way_out[into, 1], way_out[into, 2] = block[X + j], block[Y + j], block[Z + j]
        found_out[np.uint64(candidates[0, j])] += keep
        place += keep
    return place


@scalar
def _hits(flat, number, count, boxes, i, hit, eight, hits):
    """Numbers of those of the first `count` boxes that box i meets, in their order; returns how many they are. All are
    asked at once, eight by eight: which of them meet cannot be foreseen."""
    x0, y0, z0, x1, y1, z1 = boxes[0, i], boxes[1, i], boxes[2, i], boxes[3, i], boxes[4, i], boxes[5, i]
    for j in range(count):
        hit[j] = (
            (flat[0, j] <= x1) & (flat[1, j] <= y1) & (flat[2, j] <= z1)
            & (flat[3, j] >= x0) & (flat[4, j] >= y0) & (flat[5, j] >= z0)
        )  # fmt: skip
    m = np.uint64(0)
    for w in range(count // GROUP):
        if eight[w] != 0:
            for j in range(GROUP * w, GROUP * w + GROUP):
                hits[m] = number[np.uint64(j)]
                m += np.uint64(hit[np.uint64(j)])
    return np.int64(m)


@inlined
def _gather(groups, first, count, target, start, flat_out, number_out):
    """Boxes of the members of groups, from the first one on, beside each other, and their numbers; how many they
    are."""
    for i in range(first, count):
        into, place = np.uint64(GROUP * (i - first)), np.uint64(GROUP * groups[i])
        for j in range(np.uint64(GROUP)):
            number_out[into + j] = place + j
        for k in range(6):
            for j in range(np.uint64(GROUP)):
                flat_out[k, into + j] = target[k, np.uint64(start) + place + j]
    return GROUP * (count - first)


@inlined
def _from(numbers, count, least):
    """Place of the first of ascending numbers that is not less."""
    first = 0
    while first < count and numbers[first] < least:
        first += 1
    return first


@scalar
def _find_in_slice(
    s, count_of_items, kind, mesh, ways, is_open, strayed, near, ready, items, query, query_starts, target, starts,
    places, kept_out, way_out, found_out,
):  # fmt: skip
    """Of a slice: how many candidates there were, and how many pairs. A function of its own, whose memory belongs to
    nobody else: a parallel loop would take an array out of it that grows in it."""
    triangles, edges, nodes = mesh[0], mesh[1], mesh[2]
    rim_begin, rim = mesh[4], mesh[5]
    halls, groups = starts[3] - starts[2], starts[2] - starts[1]
    place, met, waiting = places[s], 0, 0
    hit, near_halls, near_groups = np.zeros(groups, np.uint8), np.empty(halls, np.int32), np.empty(groups, np.int32)
    all_halls, hall_number = target[:, starts[2] : starts[3]].copy(), np.arange(halls).astype(np.int32)
    of_hall, group_number = np.empty((6, groups), np.float32), np.empty(groups, np.int32)
    flat, number = np.empty((6, 64 * GROUP), np.float32), np.empty(64 * GROUP, np.int32)
    item_hit, hits = np.zeros(64 * GROUP, np.uint8), np.empty(64 * GROUP, np.int32)
    eight, item_eight = hit.view(np.uint64), item_hit.view(np.uint64)
    stamp = np.full(len(is_open), -1, np.int64)
    candidates, block = np.empty((2, BLOCK), np.int32), np.zeros(MORE_ROWS * BLOCK)
    end = min(count_of_items, (s + 1) * SLICE)
    for group in range(s * SLICE // GROUP, (end + GROUP - 1) // GROUP):
        # Halls are groups of groups.
        if group % GROUP == 0 or group == s * SLICE // GROUP:
            hall = group // GROUP
            count = _hits(
                all_halls, hall_number, halls, query, np.uint64(query_starts[2] + hall), hit, eight, near_halls
            )  # fmt: skip
            first = _from(near_halls, count, hall) if kind == ACROSS else 0
            in_halls = _gather(near_halls, first, count, target, starts[1], of_hall, group_number)
        count = _hits(
            of_hall, group_number, in_halls, query, np.uint64(query_starts[1] + group), hit, eight, near_groups
        )  # fmt: skip
        first = _from(near_groups, count, group) if kind == ACROSS else 0
        if GROUP * count > len(number):
            flat, number = np.empty((6, 2 * GROUP * count), np.float32), np.empty(2 * GROUP * count, np.int32)
            item_hit, hits = np.zeros(2 * GROUP * count, np.uint8), np.empty(2 * GROUP * count, np.int32)
            item_eight = item_hit.view(np.uint64)
        in_groups = _gather(near_groups, first, count, target, 0, flat, number)
        for asked in range(GROUP * group, min(end, GROUP * group + GROUP)):
            q = np.uint64(asked)
            item = np.int64(items[q])
            m = _hits(flat, number, in_groups, query, q, item_hit, item_eight, hits)
            first = _from(hits, m, item + 1) if kind == ACROSS else 0
            if m == first:
                continue
            # A stamp on whatever shares a node with the item, or a ring that stays open.
            if kind == ON:
                p = nodes[item]
                stamp[p] = 2 * item
                for i in range(rim_begin[p], rim_begin[p + 1]):
                    if is_open[rim[i]]:
                        stamp[rim[i]] = 2 * item
            elif kind == UNDER:
                for c in range(3):
                    p = triangles[item, c]
                    stamp[p] = 2 * item
                    if is_open[p]:
                        for i in range(rim_begin[p], rim_begin[p + 1]):
                            stamp[rim[i]] = 2 * item
            else:
                for i in range(4):
                    p = edges[item, i]
                    if p >= 0 and (i < 2 or is_open[p]):
                        stamp[p] = 2 * item + is_open[p]
            for i in range(first, m):
                u, one, other = np.uint64(hits[i]), np.int32(item), hits[i]
                if kind == ON:
                    skipped = (
                        (stamp[triangles[u, 0]] == 2 * item) | (stamp[triangles[u, 1]] == 2 * item)
                        | (stamp[triangles[u, 2]] == 2 * item)
                    )  # fmt: skip
                elif kind == UNDER:
                    skipped = (stamp[nodes[u]] == 2 * item) | strayed[nodes[u]]
                    one, other = other, one
                else:
                    skipped = (
                        (stamp[edges[u, 0]] >> 1 == item) | (stamp[edges[u, 1]] >> 1 == item)
                        | ((edges[u, 2] >= 0) & (stamp[edges[u, 2]] == 2 * item + 1))
                        | ((edges[u, 3] >= 0) & (stamp[edges[u, 3]] == 2 * item + 1))
                    )  # fmt: skip
                    if kind == ACROSS_ALL and other < one:
                        skipped = skipped | strayed[edges[u, 0]] | strayed[edges[u, 1]]
                        one, other = other, one
                candidates[0, waiting], candidates[1, waiting] = one, other
                waiting += not skipped
                if waiting == BLOCK:
                    place = _keep_near(
                        kind & 1, BLOCK, place, places[s + 1] - 1, mesh, ways, near, ready, candidates, kept_out,
                        way_out, found_out, block,
                    )  # fmt: skip
                    met, waiting = met + BLOCK, 0
    place = _keep_near(
        kind & 1, waiting, place, places[s + 1] - 1, mesh, ways, near, ready, candidates, kept_out, way_out, found_out,
        block,
    )  # fmt: skip
    return met + waiting, place - places[s]


@kernel
def _find(
    n, kind, mesh, ways, is_open, strayed, near, ready, items, query, query_starts, target, starts, places, kept_out,
    way_out, found_out, met_out, needed_out,
):  # fmt: skip
    """Pairs of one kind of n items: how many each first side has in found_out, which are zero before, and as many of
    the pairs as a slice has places for, with how many it needs. ways: of the nodes, from `_boxes`; is_open: whether
    there are none in the ring around a node, (nodes,) bool; strayed: nodes, (nodes,) bool, of which all pairs are asked
    for, if not everything is; near, ready: distance that matters, and how much more in a step [m]; items: their
    numbers, ascending; query, target: boxes; places: the first of each slice, and the end, (slices + 1,)."""
    for s in prange((n + SLICE - 1) // SLICE):
        met_out[s], needed_out[s] = _find_in_slice(
            s, n, kind, mesh, ways, is_open, strayed, near, ready, items, query, query_starts, target, starts, places,
            kept_out, way_out, found_out,
        )  # fmt: skip


@kernel
def pack(n, kind, mesh, places, kept, way, begin, pairs):
    """What slices found, one after the other."""
    key_out, nodes_out, normal_out, level_out = pairs
    for s in prange((n + SLICE - 1) // SLICE):
        first = begin[SLICE * s]
        count = begin[min(n, SLICE * (s + 1))] - first
        for i in range(count):
            at, to = places[s] + i, first + i
            one, other = kept[at, 0], kept[at, 1]
            a, b, c, d = _members(kind, one, other, mesh)
            key_out[to] = kind * EDGES + np.int64(a if kind == 0 else one) * FIRST + np.int64(other)
            nodes_out[to, 0], nodes_out[to, 1], nodes_out[to, 2], nodes_out[to, 3] = a, b, c, d
            level_out[to] = min(kept[at, 2], LEVELS - 1)
            x, y, z = way[at, 0], way[at, 1], way[at, 2]
            size = math.sqrt(x * x + y * y + z * z)
            per = 1.0 / size if size > 0.0 else 0.0
            normal_out[to, 0], normal_out[to, 1], normal_out[to, 2] = per * x, per * y, per * z
