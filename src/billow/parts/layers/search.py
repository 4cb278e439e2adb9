"""Search for pairs: whatever can come near within a time, if every node keeps to a straight path but for a skin.

A pair is kept if its distance is less than what is near, plus the skins of both sides, plus the time times the largest
relative speed within it, and if boxes around the paths of its sides meet. A stack that flies together therefore needs
no new list, however fast it flies.

Boxes around the paths of triangles are sorted into the cells of a grid; of two triangles whose boxes meet, nodes are
held against triangles and edges against edges. A pair belongs to the lower of the two triangles, and
the pairs of a triangle are in the order of their keys, so that the order does not depend on the search.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numba import prange

from billow.base.compiled import inlined, kernel
from billow.geometry.closest_points import of_segments, on_triangle
from billow.geometry.search_grid import MOST_CELLS, cell_lists, clipped_cell
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
    """Pairs in their order: key, nodes and normal as in `Pairs`; begin: of the pairs of each triangle, (triangles +
    1,) int64. looked_at: pairs of triangles whose boxes meet.
    crowd: the most pairs that a slice has."""

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
    begin, room = np.zeros(n + 1, np.int64), max(LEAST_ROOM, int(1.25 * crowd))
    met = np.empty(slices, np.int64)
    while True:
        key, nodes = np.empty((slices, room), np.int64), np.empty((slices, room, 4), np.int32)
        normal = np.empty((slices, room, 3))
        getattr(_find, run)(
            n, tuple(mesh), tuple(paths), box, edge_box, node_box, spans, counts, first, listed, key, nodes, normal,
            begin[1:], met,
        )  # fmt: skip
        most = int(np.add.reduceat(begin[1:], np.arange(0, n, SLICE)).max(initial=0))
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
def _relative(velocities, i, j):
    """Square of the relative speed of two nodes [m^2/s^2]."""
    x = velocities[i, 0] - velocities[j, 0]
    y = velocities[i, 1] - velocities[j, 1]
    z = velocities[i, 2] - velocities[j, 2]
    return x * x + y * y + z * z


@inlined
def _meet(one, i, other, j):
    """Whether two boxes meet. All is asked at once: which question decides cannot be foreseen."""
    return (
        (one[i, 0] <= other[j, 3]) & (other[j, 0] <= one[i, 3]) & (one[i, 1] <= other[j, 4])
        & (other[j, 1] <= one[i, 4]) & (one[i, 2] <= other[j, 5]) & (other[j, 2] <= one[i, 5])
    )  # fmt: skip


@inlined
def _keep(key, a, b, c, d, x, y, z, square, key_out, nodes_out, normal_out, s, count):
    """Write a pair, if there is room."""
    if count < key_out.shape[1]:
        key_out[s, count] = key
        nodes_out[s, count, 0], nodes_out[s, count, 1] = a, b
        nodes_out[s, count, 2], nodes_out[s, count, 3] = c, d
        per = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
        normal_out[s, count, 0], normal_out[s, count, 1], normal_out[s, count, 2] = per * x, per * y, per * z


@inlined
def _nodes_on(one, other, mesh, paths, box, node_box, key_out, nodes_out, normal_out, s, count):
    """Pairs of the nodes for which triangle `one` speaks, and triangle `other`; returns how many a slice has then."""
    triangles, own_node_start, own_node, free = mesh[0], mesh[2], mesh[3], mesh[6]
    positions, velocities, skin, near, time = paths
    for i in range(own_node_start[one], own_node_start[one + np.uint64(1)]):
        p = np.uint64(own_node[np.uint64(i)])
        if not _meet(node_box, p, box, other):
            continue
        a, b, c = np.uint64(triangles[other, 0]), np.uint64(triangles[other, 1]), np.uint64(triangles[other, 2])
        if p in (a, b, c) or not (free[p] or free[a] or free[b] or free[c]):
            continue
        _, _, rx, ry, rz = on_triangle(
            positions[p, 0], positions[p, 1], positions[p, 2], positions[a, 0], positions[a, 1], positions[a, 2],
            positions[b, 0], positions[b, 1], positions[b, 2], positions[c, 0], positions[c, 1], positions[c, 2],
        )  # fmt: skip
        square = max(_relative(velocities, p, a), _relative(velocities, p, b), _relative(velocities, p, c))
        reach = near + skin[p] + max(skin[a], skin[b], skin[c]) + time * math.sqrt(square)
        size = rx * rx + ry * ry + rz * rz
        if size <= reach * reach:
            key = np.int64(p) * FIRST + np.int64(other)
            _keep(key, p, a, b, c, rx, ry, rz, size, key_out, nodes_out, normal_out, s, count)
            count += 1
    return count


@inlined
def _edges_on(one, other, mesh, paths, edge_box, key_out, nodes_out, normal_out, s, count):
    """Likewise, pairs of the edges for which two triangles speak."""
    edges, own_edge_start, own_edge, free = mesh[1], mesh[4], mesh[5], mesh[6]
    positions, velocities, skin, near, time = paths
    for i in range(own_edge_start[one], own_edge_start[one + np.uint64(1)]):
        for j in range(own_edge_start[other], own_edge_start[other + np.uint64(1)]):
            e, g = np.uint64(own_edge[np.uint64(i)]), np.uint64(own_edge[np.uint64(j)])
            if not _meet(edge_box, e, edge_box, g):
                continue
            e, g = min(e, g), max(e, g)
            a, b, c, d = np.uint64(edges[e, 0]), np.uint64(edges[e, 1]), np.uint64(edges[g, 0]), np.uint64(edges[g, 1])
            if a in (c, d) or b in (c, d) or not (free[a] or free[b] or free[c] or free[d]):
                continue
            _, _, rx, ry, rz = of_segments(
                positions[a, 0], positions[a, 1], positions[a, 2], positions[b, 0], positions[b, 1], positions[b, 2],
                positions[c, 0], positions[c, 1], positions[c, 2], positions[d, 0], positions[d, 1], positions[d, 2],
            )  # fmt: skip
            square = max(
                _relative(velocities, a, c), _relative(velocities, a, d), _relative(velocities, b, c),
                _relative(velocities, b, d),
            )  # fmt: skip
            reach = near + max(skin[a], skin[b]) + max(skin[c], skin[d]) + time * math.sqrt(square)
            size = rx * rx + ry * ry + rz * rz
            if size <= reach * reach:
                key = EDGES + np.int64(e) * FIRST + np.int64(g)
                _keep(key, a, b, c, d, rx, ry, rz, size, key_out, nodes_out, normal_out, s, count)
                count += 1
    return count


@kernel
def _find(
    n, mesh, paths, box, edge_box, node_box, spans, counts, first, listed, key_out, nodes_out, normal_out, count_out,
    met_out,
):  # fmt: skip
    """Pairs of each triangle with higher ones: how many, and as many of them as a slice has room for."""
    for s in prange((n + SLICE - 1) // SLICE):
        count, met = 0, 0
        for item in range(s * SLICE, min(n, (s + 1) * SLICE)):
            t, begin = np.uint64(item), count
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
                            count = _nodes_on(
                                t, u, mesh, paths, box, node_box, key_out, nodes_out, normal_out, s, count
                            )
                            count = _nodes_on(
                                u, t, mesh, paths, box, node_box, key_out, nodes_out, normal_out, s, count
                            )
                            count = _edges_on(t, u, mesh, paths, edge_box, key_out, nodes_out, normal_out, s, count)
            count_out[item] = count - begin
        met_out[s] = met


@kernel
def _pack(n, key, nodes, normal, found):
    """What slices found, one after the other; the pairs of a triangle in the order of their keys."""
    key_out, nodes_out, normal_out, begin = found
    for s in prange((n + SLICE - 1) // SLICE):
        order = np.empty(key.shape[1], np.int64)
        into = begin[s * SLICE]
        for t in range(s * SLICE, min(n, (s + 1) * SLICE)):
            low, high = begin[t] - into, begin[t + 1] - into
            for i in range(low, high):
                j = i
                while j > low and key[s, order[j - 1]] > key[s, i]:
                    order[j] = order[j - 1]
                    j -= 1
                order[j] = i
            for i in range(low, high):
                at = order[i]
                key_out[into + i] = key[s, at]
                for k in range(4):
                    nodes_out[into + i, k] = nodes[s, at, k]
                for k in range(3):
                    normal_out[into + i, k] = normal[s, at, k]
