"""Which nodes of a surface are near which of its triangles: pairs, sorted, in one pass.

Nodes are sorted into cells of a uniform grid, so that each lies in one; every triangle looks through the cells about
it, of which those along one axis are one run of nodes. One thread: the same pairs in the same order, always.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.triangle import cross, double_area_vector, sides

MOST_CELLS = 1 << 19
"""Largest number of cells (2 MB of offsets); a wider scene gets larger cells."""

MOST_BLOCKS = 1 << 14
"""Likewise of blocks."""

SAMPLED = 64
"""Triangles by which the length of edges is estimated."""

BLOCK = 1.25
"""Edge of a block of space in reaches and edges; no node of the block and those around it may face a triangle in most
blocks of a bag that is blown up."""

SQUARE = -1e-9
"""Cosine below which an outward vector points against a normal. On the rim of a flat bag they are square to each other,
and rounding must not decide."""

PER_NODE = 16
"""Pairs of a node for which there is room at first."""


class NearPairs(NamedTuple):
    """Pairs in the order of their nodes, and of the triangles of each.

    start: (nodes + 1,) int64, the pairs of each node. triangle: (pairs,) int64. apart: distance, and its part in the
    plane of the triangle, zero over it [m], (pairs, 2). by_triangle: pairs in the order of their triangles, and of the
    nodes of each, (pairs,) int64; struck_start: (triangles + 1,) int64, those of each triangle.
    """

    start: np.ndarray
    triangle: np.ndarray
    apart: np.ndarray
    by_triangle: np.ndarray
    struck_start: np.ndarray


@scalar
def near_pairs(positions, nodes, triangles, faces, reach, outward, kept_nodes, kept_triangles):
    """NearPairs of `nodes` (n,) and `faces` (m,), int64 indices into positions [m] (all, 3) and triangles (all, 3),
    that are no further apart than `reach` [m].

    A triangle has no pair with its own corners, and none with a node whose outward vector, (all, 3) of any length, does
    not point against its normal: fabric that turns the same way has another layer in between. Triangles without area
    have none. kept_nodes, kept_triangles: (k,) int64 each, pairs that may point as they like.
    """
    n = len(nodes)
    if n == 0 or len(faces) == 0:
        none = np.empty(0, np.int64)
        return _in_order(len(positions), len(triangles), none, none, np.empty((0, 2)))
    low, high = np.full(3, math.inf), np.full(3, -math.inf)
    for p in nodes:
        for k in range(3):
            low[k], high[k] = min(low[k], positions[p, k]), max(high[k], positions[p, k])
    axes = np.argsort(high - low)  # runs of nodes are along the longest
    edge = _mean_edge(positions, triangles, faces)
    cell, counts = _grid(high - low, max(edge, 0.5 * reach), MOST_CELLS)
    per_cell = 1.0 / cell
    # Nodes by cell, with what is asked of each of them side by side.
    first, place = np.zeros(counts[0] * counts[1] * counts[2] + 2, np.int32), np.empty(n, np.int32)
    for i in range(n):
        p = nodes[i]
        place[i] = 0
        for k in axes:
            place[i] = place[i] * counts[k] + min(int((positions[p, k] - low[k]) * per_cell), counts[k] - 1)
        first[place[i] + 1] += 1
    for c in range(len(first) - 1):
        first[c + 1] += first[c]
    node, at = np.empty(n, np.int64), np.empty((n, 6))
    for i in range(n - 1, -1, -1):  # backwards, from the end of each cell, so that `first` is where it begins
        p, c = nodes[i], place[i] + 1
        first[c] -= 1
        slot = first[c]
        node[slot] = p
        size = math.sqrt(outward[p, 0] ** 2 + outward[p, 1] ** 2 + outward[p, 2] ** 2)
        for k in range(3):
            at[slot, k], at[slot, 3 + k] = positions[p, k], outward[p, k] / size if size > 0.0 else 0.0
    block, blocks = _grid(high - low, BLOCK * (reach + edge), MOST_BLOCKS)
    spread = _blocks(positions, nodes, outward, low, block, blocks)
    found = _pairs(
        positions, triangles, faces, reach, low, per_cell, counts, axes, first, node, at, block, blocks, spread
    )
    whose, which, apart = _with_kept(positions, triangles, reach, outward, kept_nodes, kept_triangles, *found)
    return _in_order(len(positions), len(triangles), whose, which, apart)


@scalar
def _mean_edge(positions, triangles, faces):
    """Mean length [m] of the first side of some of the triangles, a rough measure."""
    total, n, step = 0.0, 0, max(1, len(faces) // SAMPLED)
    for m in range(0, len(faces), step):
        a, b = triangles[faces[m], 0], triangles[faces[m], 1]
        square = 0.0
        for k in range(3):
            square += (positions[b, k] - positions[a, k]) ** 2
        total, n = total + math.sqrt(square), n + 1
    return total / n


@scalar
def _grid(extent, cell, most):
    """Edge of a cell [m], at least `cell`, and cells per axis, (3,) int64, `most` in all, that fill this extent [m],
    (3,)."""
    counts = np.empty(3, np.int64)
    while True:
        total = 1.0
        for k in range(3):
            counts[k] = int(extent[k] / cell) + 1
            total *= counts[k]
        if total <= most:
            return cell, counts
        cell *= 1.26


@scalar
def _pairs(positions, triangles, faces, reach, low, per_cell, counts, axes, first, node, at, block, blocks, spread):
    """Nodes and triangles of all pairs, (pairs,) each, and how far they are apart, (pairs, 2), in the order of the
    triangles."""
    size, found = PER_NODE * len(node) + 64, 0
    begin_at, end_at, hits = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(len(node) + 1, np.int64)
    whose, which, apart = np.empty(size, np.int64), np.empty(size, np.int64), np.empty((size, 2))
    for t in faces:
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        nx, ny, nz = double_area_vector(positions, a, b, c)
        square = nx * nx + ny * ny + nz * nz
        if not square > 0.0 or not _may_face(positions, a, b, c, nx, ny, nz, reach, low, block, blocks, spread):
            continue
        ax, ay, az = positions[a, 0], positions[a, 1], positions[a, 2]
        ux, uy, uz = positions[b, 0] - ax, positions[b, 1] - ay, positions[b, 2] - az
        vx, vy, vz = positions[c, 0] - ax, positions[c, 1] - ay, positions[c, 2] - az
        wx, wy, wz = vx - ux, vy - uy, vz - uz
        # Vectors in the plane, square to the sides and of unit length, and 1 over the squares of the sides.
        one = 1.0 / math.sqrt(square)
        uu, vv, ww = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, wx * wx + wy * wy + wz * wz
        uu, vv, ww = 1.0 / uu, 1.0 / vv, 1.0 / ww
        beside_u, beside_v, beside_w = one * math.sqrt(uu), one * math.sqrt(vv), one * math.sqrt(ww)
        sx, sy, sz = cross(ux, uy, uz, beside_u * nx, beside_u * ny, beside_u * nz)
        rx, ry, rz = cross(beside_v * nx, beside_v * ny, beside_v * nz, vx, vy, vz)
        qx, qy, qz = cross(wx, wy, wz, beside_w * nx, beside_w * ny, beside_w * nz)
        beyond = qx * ux + qy * uy + qz * uz
        nx, ny, nz = one * nx, one * ny, one * nz
        for k in range(3):
            least = min(positions[a, k], positions[b, k], positions[c, k]) - reach - low[k]
            most = max(positions[a, k], positions[b, k], positions[c, k]) + reach - low[k]
            begin_at[k], end_at[k] = _cells(least, most, per_cell, counts[k])
        slow, middle, fast, hit = axes[0], axes[1], axes[2], 0
        for x in range(begin_at[slow], end_at[slow]):
            for y in range(begin_at[middle], end_at[middle]):
                row = (x * counts[middle] + y) * counts[fast]
                if begin_at[fast] == end_at[fast]:
                    continue
                begin, end = first[row + begin_at[fast] + 1], first[row + end_at[fast] + 1]
                for i in range(begin, end):  # without branches, which could not be foretold
                    gx, gy, gz = at[i, 0] - ax, at[i, 1] - ay, at[i, 2] - az
                    height = gx * nx + gy * ny + gz * nz
                    by_u, by_v = gx * sx + gy * sy + gz * sz, gx * rx + gy * ry + gz * rz
                    by_w = gx * qx + gy * qy + gz * qz - beyond
                    against = at[i, 3] * nx + at[i, 4] * ny + at[i, 5] * nz < SQUARE
                    near = (abs(height) <= reach) & (by_u <= reach) & (by_v <= reach) & (by_w <= reach)
                    hits[hit] = i
                    hit += near & against
        for m in range(hit):
            i = hits[m]
            gx, gy, gz, p = at[i, 0] - ax, at[i, 1] - ay, at[i, 2] - az, node[i]
            height, lateral = abs(gx * nx + gy * ny + gz * nz), 0.0
            by_u, by_v = gx * sx + gy * sy + gz * sz, gx * rx + gy * ry + gz * rz
            if max(by_u, by_v, gx * qx + gy * qy + gz * qz - beyond) > 0.0:  # beside it
                to_u, to_v = _to_side(gx, gy, gz, ux, uy, uz, uu), _to_side(gx, gy, gz, vx, vy, vz, vv)
                square = min(to_u, to_v, _to_side(gx - ux, gy - uy, gz - uz, wx, wy, wz, ww))
                lateral = math.sqrt(max(0.0, square - height * height))
            distance = math.sqrt(height * height + lateral * lateral)
            if distance > reach or p in (a, b, c):
                continue
            if found == len(whose):
                whose, which, apart = _longer(whose), _longer(which), np.concatenate((apart, np.empty_like(apart)))
            whose[found], which[found], apart[found, 0], apart[found, 1] = p, t, distance, lateral
            found += 1
    return whose[:found], which[:found], apart[:found]


@scalar
def _blocks(positions, nodes, outward, low, block, counts):
    """Bounds of the outward vectors of the nodes in each block of space and in those around it: least and largest
    components, (blocks along x, y, z, 6). low: where the nodes begin [m], (3,). block: edge [m]."""
    spread = np.empty((counts[0], counts[1], counts[2], 6))
    spread[..., :3], spread[..., 3:] = math.inf, -math.inf
    for p in nodes:
        x, y, z = _block_of(positions, p, low, block, counts)
        for k in range(3):
            spread[x, y, z, k] = min(spread[x, y, z, k], outward[p, k])
            spread[x, y, z, 3 + k] = max(spread[x, y, z, 3 + k], outward[p, k])
    for axis in range(3):
        own = spread.copy()
        ix, iy, iz = int(axis == 0), int(axis == 1), int(axis == 2)
        for x in range(counts[0] - ix):
            for y in range(counts[1] - iy):
                for z in range(counts[2] - iz):
                    for k in range(3):
                        here, there = own[x, y, z, k], own[x + ix, y + iy, z + iz, k]
                        spread[x, y, z, k] = min(spread[x, y, z, k], there)
                        spread[x + ix, y + iy, z + iz, k] = min(spread[x + ix, y + iy, z + iz, k], here)
                        here, there = own[x, y, z, 3 + k], own[x + ix, y + iy, z + iz, 3 + k]
                        spread[x, y, z, 3 + k] = max(spread[x, y, z, 3 + k], there)
                        spread[x + ix, y + iy, z + iz, 3 + k] = max(spread[x + ix, y + iy, z + iz, 3 + k], here)
    return spread


@scalar
def _block_of(positions, p, low, block, counts):
    """The block of a node, along x, y and z; the outermost ones take what is beyond."""
    return (
        int(min(max((positions[p, 0] - low[0]) / block, 0.0), counts[0] - 1.0)),
        int(min(max((positions[p, 1] - low[1]) / block, 0.0), counts[1] - 1.0)),
        int(min(max((positions[p, 2] - low[2]) / block, 0.0), counts[2] - 1.0)),
    )


@scalar
def _may_face(positions, a, b, c, nx, ny, nz, reach, low, block, counts, spread):
    """Whether a node within reach of a triangle may point against its normal n, of any length, by `_blocks`."""
    for k in range(3):
        if max(abs(positions[b, k] - positions[a, k]), abs(positions[c, k] - positions[a, k])) + reach > block:
            return True  # larger than a block
    x, y, z = _block_of(positions, a, low, block, counts)
    least, size = 0.0, 0.0
    for k, part in enumerate((nx, ny, nz)):
        lower, upper = part * spread[x, y, z, k], part * spread[x, y, z, 3 + k]
        least += min(lower, upper)
        size += max(abs(lower), abs(upper))
    return spread[x, y, z, 0] <= spread[x, y, z, 3] and least < 1e-12 * size


@scalar
def _with_kept(positions, triangles, reach, outward, kept_nodes, kept_triangles, whose, which, apart):
    """Add the pairs to keep to what `_pairs` has found, unless they are there or too far apart."""
    found, more = len(whose), len(kept_nodes)
    whose = np.concatenate((whose, np.empty(more, np.int64)))
    which, apart = np.concatenate((which, np.empty(more, np.int64))), np.concatenate((apart, np.empty((more, 2))))
    for m in range(more):
        p, t = kept_nodes[m], kept_triangles[m]
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        nx, ny, nz = double_area_vector(positions, a, b, c)
        square = nx * nx + ny * ny + nz * nz
        if not square > 0.0:
            continue
        one = 1.0 / math.sqrt(square)
        nx, ny, nz = one * nx, one * ny, one * nz
        size = math.sqrt(outward[p, 0] ** 2 + outward[p, 1] ** 2 + outward[p, 2] ** 2)
        ox, oy, oz = outward[p, 0] / size, outward[p, 1] / size, outward[p, 2] / size
        if size > 0.0 and ox * nx + oy * ny + oz * nz < SQUARE:  # as in `_pairs`: it is there
            continue
        distance, lateral = _distance(positions, p, a, b, c, nx, ny, nz)
        if distance <= reach:
            whose[found], which[found], apart[found, 0], apart[found, 1] = p, t, distance, lateral
            found += 1
    return whose[:found], which[:found], apart[:found]


@scalar
def _distance(positions, p, a, b, c, nx, ny, nz):
    """Distance [m] of a node from a triangle with unit normal n, and its part in the plane."""
    gx, gy, gz = positions[p, 0] - positions[a, 0], positions[p, 1] - positions[a, 1], positions[p, 2] - positions[a, 2]
    ux, uy, uz, vx, vy, vz = sides(positions, a, b, c)
    wx, wy, wz = vx - ux, vy - uy, vz - uz
    sx, sy, sz = cross(ux, uy, uz, nx, ny, nz)
    rx, ry, rz = cross(nx, ny, nz, vx, vy, vz)
    qx, qy, qz = cross(wx, wy, wz, nx, ny, nz)
    beside = max(gx * sx + gy * sy + gz * sz, gx * rx + gy * ry + gz * rz)
    if max(beside, (gx - ux) * qx + (gy - uy) * qy + (gz - uz) * qz) <= 0.0:
        return abs(gx * nx + gy * ny + gz * nz), 0.0
    to_u = _to_side(gx, gy, gz, ux, uy, uz, 1.0 / (ux * ux + uy * uy + uz * uz))
    to_v = _to_side(gx, gy, gz, vx, vy, vz, 1.0 / (vx * vx + vy * vy + vz * vz))
    to_w = _to_side(gx - ux, gy - uy, gz - uz, wx, wy, wz, 1.0 / (wx * wx + wy * wy + wz * wz))
    square, height = min(to_u, to_v, to_w), gx * nx + gy * ny + gz * nz
    return math.sqrt(square), math.sqrt(max(0.0, square - height * height))


@scalar
def _to_side(px, py, pz, ux, uy, uz, one_over_square):
    """Square of the distance of a point from a side that begins at the origin [m^2]; 1 over the square of its length
    [1/m^2]."""
    along = min(1.0, max(0.0, (px * ux + py * uy + pz * uz) * one_over_square))
    px, py, pz = px - along * ux, py - along * uy, pz - along * uz
    return px * px + py * py + pz * pz


@scalar
def _cells(low, high, per_cell, count):
    """The first cell along an axis between two places [m] from its start, and the one after the last; equal if all of
    it is off the grid."""
    if not (high >= 0.0 and low * per_cell < count):
        return 0, 0
    return int(max(0.0, low * per_cell)), int(min(count - 1.0, high * per_cell)) + 1


@scalar
def _longer(row):
    """The same with room for as many more."""
    more = np.empty(2 * len(row), row.dtype)
    more[: len(row)] = row
    return more


@scalar
def _in_order(nodes, triangles, whose, which, apart):
    """NearPairs of pairs that are nearly in the order of their triangles."""
    pairs = len(whose)
    start, struck_start = np.zeros(nodes + 1, np.int64), np.zeros(triangles + 1, np.int64)
    triangle, ordered, by_triangle = np.empty(pairs, np.int64), np.empty((pairs, 2)), np.empty(pairs, np.int64)
    for m in range(pairs):
        start[whose[m] + 1] += 1
        struck_start[which[m] + 1] += 1
    for p in range(nodes):
        start[p + 1] += start[p]
    for t in range(triangles):
        struck_start[t + 1] += struck_start[t]
    free = start.copy()
    for m in range(pairs):
        k = free[whose[m]]
        free[whose[m]] = k + 1
        while k > start[whose[m]] and triangle[k - 1] > which[m]:
            triangle[k], ordered[k, 0], ordered[k, 1] = triangle[k - 1], ordered[k - 1, 0], ordered[k - 1, 1]
            k -= 1
        triangle[k], ordered[k, 0], ordered[k, 1] = which[m], apart[m, 0], apart[m, 1]
    free = struck_start.copy()
    for k in range(pairs):
        by_triangle[free[triangle[k]]] = k
        free[triangle[k]] += 1
    return NearPairs(start, triangle, ordered, by_triangle, struck_start)
