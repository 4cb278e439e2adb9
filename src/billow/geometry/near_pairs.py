"""Which nodes of a surface are near which of its triangles: pairs, sorted, in one pass.

Nodes are sorted into cells of a uniform grid, so that each lies in one. Groups of neighbouring triangles look through
the cells about them, of which those along one axis are one run of nodes, for nodes that may face one of them. Each
triangle of the group is then held against these, many at once. One thread: the same pairs in the same order, always.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.neighbours import GROUP
from billow.geometry.triangle import cross, double_area_vector, sides

MOST_CELLS = 1 << 19
"""Largest number of cells (2 MB of offsets); a wider scene gets larger cells."""

SAMPLED = 64
"""Triangles by which the length of edges is estimated."""

SQUARE = -1e-9
"""Cosine below which an outward vector points against a normal. On the rim of a flat bag they are square to each other,
and rounding must not decide."""

PER_NODE = 16
"""Pairs of a node for which there is room at first."""

BLOCK = 32
"""Nodes in a block; all rows together stay in the fastest cache."""

# fmt: off
(
    PX, PY, PZ, OX, OY, OZ, WHO,  # place [m], outward unit vector, number
    DISTANCE, LATERAL, HIT,  # from one triangle, its part in the plane, squared [m^2]; 1 for a pair, else 0
) = (BLOCK * row for row in range(10))
ROWS = 10
# fmt: on


class NearPairs(NamedTuple):
    """Pairs in the order of their nodes, and of the triangles of each.

    start: (nodes + 1,) int64, the pairs of each node. triangle: (pairs,) int64. apart: distance, and its part in the
    plane of the triangle, zero over it, squared [m^2], (pairs, 2).
    """

    start: np.ndarray
    triangle: np.ndarray
    apart: np.ndarray


@scalar
def near_pairs(positions, nodes, triangles, faces, reach, outward, kept_nodes, kept_triangles):
    """NearPairs of `nodes` (n,) and `faces` (m,), int64 indices into positions [m] (all, 3) and triangles (all, 3),
    that are no further apart than `reach` [m]. Fast where GROUP successive faces are neighbours, as `by_halves` orders
    them.

    A triangle has no pair with its own corners, and none with a node whose outward vector, (all, 3) of any length, does
    not point against its normal: fabric that turns the same way has another layer in between. Triangles without area
    have none. kept_nodes, kept_triangles: (k,) int64 each, pairs that may point as they like.
    """
    n, m, more = len(nodes), len(faces), len(kept_nodes)
    # Pairs as they are found, and which of them belong to each face, and to each pair that is kept.
    whose, apart, found = np.empty(PER_NODE * n + more, np.int64), np.empty((PER_NODE * n + more, 2)), 0
    of_run, run = np.empty(m + more, np.int64), np.zeros(m + more + 1, np.int64)
    for i in range(m):
        of_run[i] = faces[i]
    if n > 0 and m > 0:
        low, high = np.full(3, math.inf), np.full(3, -math.inf)
        for p in nodes:
            for k in range(3):
                low[k], high[k] = min(low[k], positions[p, k]), max(high[k], positions[p, k])
        axes = np.argsort(high - low)  # runs of nodes are along the longest
        cell, counts = _grid(high - low, max(_mean_edge(positions, triangles, faces), 0.5 * reach))
        first, at = _by_cell(positions, nodes, outward, low, 1.0 / cell, counts, axes)
        box, hits = np.empty(12), np.empty(n + 1, np.int64)
        blocks = np.zeros(ROWS * BLOCK)
        for begin in range(0, m, GROUP):
            end = min(begin + GROUP, m)
            _box_of(positions, triangles, faces, begin, end, box)
            near = _near_box(at, first, counts, axes, low, 1.0 / cell, box, reach, hits)
            if ROWS * BLOCK * (near // BLOCK + 1) > len(blocks):
                blocks = np.zeros(2 * ROWS * BLOCK * (near // BLOCK + 1))
            while found + GROUP * near + more > len(whose):
                whose, apart = _longer(whose), np.concatenate((apart, np.empty_like(apart)))
            _fill(at, hits, near, blocks)
            for i in range(begin, end):
                if near > 0:
                    found = _hold(positions, triangles, faces[i], reach, blocks, near, found, whose, apart)
                run[i + 1] = found
    for k in range(more):
        p, t = kept_nodes[k], kept_triangles[k]
        distance, lateral = _kept(positions, triangles, outward, p, t)
        if distance <= reach * reach:
            whose[found], apart[found, 0], apart[found, 1] = p, distance, lateral
            found += 1
        of_run[m + k], run[m + k + 1] = t, found
    return _in_order(len(positions), len(triangles), of_run, run, whose, apart)


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
def _grid(extent, cell):
    """Edge of a cell [m], at least `cell`, and cells per axis, (3,) int64, that fill this extent [m], (3,)."""
    counts = np.empty(3, np.int64)
    while True:
        total = 1.0
        for k in range(3):
            counts[k] = int(extent[k] / cell) + 1
            total *= counts[k]
        if total <= MOST_CELLS:
            return cell, counts
        cell *= 1.26


@scalar
def _by_cell(positions, nodes, outward, low, per_cell, counts, axes):
    """Where the nodes of each cell begin, (cells + 1,), and what is asked of each of them side by side: place [m],
    outward unit vector and number, (n, 7)."""
    n, slow, middle, fast = len(nodes), axes[0], axes[1], axes[2]
    first, place = np.zeros(counts[0] * counts[1] * counts[2] + 1, np.int32), np.empty(n, np.int32)
    for i in range(n):
        p = nodes[i]
        x = min(int((positions[p, slow] - low[slow]) * per_cell), counts[slow] - 1)
        y = min(int((positions[p, middle] - low[middle]) * per_cell), counts[middle] - 1)
        z = min(int((positions[p, fast] - low[fast]) * per_cell), counts[fast] - 1)
        place[i] = (x * counts[middle] + y) * counts[fast] + z
        first[place[i]] += 1
    for c in range(len(first) - 1):
        first[c + 1] += first[c]
    at = np.empty((n, 7))
    for i in range(n - 1, -1, -1):  # backwards, from the end of each cell, so that `first` is where it begins
        p = nodes[i]
        first[place[i]] -= 1
        slot = first[place[i]]
        ox, oy, oz = outward[p, 0], outward[p, 1], outward[p, 2]
        size = math.sqrt(ox * ox + oy * oy + oz * oz)
        one = 1.0 / size if size > 0.0 else 0.0
        at[slot, 0], at[slot, 1], at[slot, 2] = positions[p, 0], positions[p, 1], positions[p, 2]
        at[slot, 3], at[slot, 4], at[slot, 5], at[slot, 6] = one * ox, one * oy, one * oz, p
    return first, at


@scalar
def _box_of(positions, triangles, faces, begin, end, box):
    """Least and largest places of the corners of some faces [m], and of the components of their unit normals; nothing
    in it if none has an area. box: (12,)."""
    xl, yl, zl, xh, yh, zh = math.inf, math.inf, math.inf, -math.inf, -math.inf, -math.inf
    nxl, nyl, nzl, nxh, nyh, nzh = math.inf, math.inf, math.inf, -math.inf, -math.inf, -math.inf
    for i in range(begin, end):
        t = faces[i]
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        nx, ny, nz = double_area_vector(positions, a, b, c)
        square = nx * nx + ny * ny + nz * nz
        if square > 0.0:
            one = 1.0 / math.sqrt(square)
            nx, ny, nz = one * nx, one * ny, one * nz
            nxl, nyl, nzl = min(nxl, nx), min(nyl, ny), min(nzl, nz)
            nxh, nyh, nzh = max(nxh, nx), max(nyh, ny), max(nzh, nz)
            for p in (a, b, c):
                x, y, z = positions[p, 0], positions[p, 1], positions[p, 2]
                xl, yl, zl, xh, yh, zh = min(xl, x), min(yl, y), min(zl, z), max(xh, x), max(yh, y), max(zh, z)
    box[0], box[1], box[2], box[3], box[4], box[5] = xl, yl, zl, xh, yh, zh
    box[6], box[7], box[8], box[9], box[10], box[11] = nxl, nyl, nzl, nxh, nyh, nzh


@scalar
def _near_box(at, first, counts, axes, low, per_cell, box, reach, hits):
    """Put nodes no further than `reach` from a box of `_box_of`, of which each may face one of its normals, into
    `hits`; returns how many there are."""
    slow, middle, fast, hit = axes[0], axes[1], axes[2], 0
    if not box[0] <= box[3]:
        return 0
    xl, yl, zl = box[0] - reach, box[1] - reach, box[2] - reach
    xh, yh, zh = box[3] + reach, box[4] + reach, box[5] + reach
    nxl, nyl, nzl, nxh, nyh, nzh = box[6], box[7], box[8], box[9], box[10], box[11]
    lowest, highest = (xl, yl, zl), (xh, yh, zh)
    x_from, x_to = _cells(lowest[slow] - low[slow], highest[slow] - low[slow], per_cell, counts[slow])
    y_from, y_to = _cells(lowest[middle] - low[middle], highest[middle] - low[middle], per_cell, counts[middle])
    z_from, z_to = _cells(lowest[fast] - low[fast], highest[fast] - low[fast], per_cell, counts[fast])
    if z_from == z_to:
        return 0
    for x in range(x_from, x_to):
        for y in range(y_from, y_to):
            row = (x * counts[middle] + y) * counts[fast]
            for i in range(first[row + z_from], first[row + z_to]):  # without branches, which could not be foretold
                px, py, pz, ox, oy, oz = at[i, 0], at[i, 1], at[i, 2], at[i, 3], at[i, 4], at[i, 5]
                inside = (px >= xl) & (px <= xh) & (py >= yl) & (py <= yh) & (pz >= zl) & (pz <= zh)
                least = min(ox * nxl, ox * nxh) + min(oy * nyl, oy * nyh) + min(oz * nzl, oz * nzh)
                hits[hit] = i
                hit += inside & (least < 0.5 * SQUARE)
    return hit


@scalar
def _fill(at, hits, near, blocks):
    """Rows PX to WHO of the nodes in `hits`; what is left of the last block is no node."""
    for m in range(near):
        i, row = hits[m], m // BLOCK * ROWS * BLOCK + m % BLOCK
        blocks[PX + row], blocks[PY + row], blocks[PZ + row] = at[i, 0], at[i, 1], at[i, 2]
        blocks[OX + row], blocks[OY + row], blocks[OZ + row] = at[i, 3], at[i, 4], at[i, 5]
        blocks[WHO + row] = at[i, 6]


@scalar
def _hold(positions, triangles, t, reach, blocks, near, found, whose, apart):
    """Add the pairs that a triangle has with the nodes in blocks; returns how many pairs there are now."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    nx, ny, nz = double_area_vector(positions, a, b, c)
    square = nx * nx + ny * ny + nz * nz
    if not square > 0.0:
        return found
    ax, ay, az = positions[a, 0], positions[a, 1], positions[a, 2]
    ux, uy, uz = positions[b, 0] - ax, positions[b, 1] - ay, positions[b, 2] - az
    vx, vy, vz = positions[c, 0] - ax, positions[c, 1] - ay, positions[c, 2] - az
    wx, wy, wz = vx - ux, vy - uy, vz - uz
    # Vectors in the plane, square to the sides and of any length, and 1 over the squares of the sides.
    sx, sy, sz = cross(ux, uy, uz, nx, ny, nz)
    rx, ry, rz = cross(nx, ny, nz, vx, vy, vz)
    qx, qy, qz = cross(wx, wy, wz, nx, ny, nz)
    beyond = qx * ux + qy * uy + qz * uz
    uu = 1.0 / (ux * ux + uy * uy + uz * uz)
    vv = 1.0 / (vx * vx + vy * vy + vz * vz)
    ww = 1.0 / (wx * wx + wy * wy + wz * wz)
    one = 1.0 / math.sqrt(square)
    nx, ny, nz = one * nx, one * ny, one * nz
    fa, fb, fc, farthest = float(a), float(b), float(c), reach * reach
    for first in range(0, near, BLOCK):
        block = blocks[ROWS * first : ROWS * (first + BLOCK)]
        for j in range(BLOCK):
            gx, gy, gz = block[PX + j] - ax, block[PY + j] - ay, block[PZ + j] - az
            height = gx * nx + gy * ny + gz * nz
            by_u, by_v = gx * sx + gy * sy + gz * sz, gx * rx + gy * ry + gz * rz
            beside = max(max(by_u, by_v), gx * qx + gy * qy + gz * qz - beyond) > 0.0
            hx, hy, hz = gx - ux, gy - uy, gz - uz
            to_u = _to_side(gx, gy, gz, ux, uy, uz, uu)
            to_v = _to_side(gx, gy, gz, vx, vy, vz, vv)
            to_w = _to_side(hx, hy, hz, wx, wy, wz, ww)
            upward = height * height
            nearest = min(min(to_u, to_v), to_w)
            square = nearest if beside else upward
            against = block[OX + j] * nx + block[OY + j] * ny + block[OZ + j] * nz < SQUARE
            who = block[WHO + j]
            hit = (square <= farthest) & against & (who != fa) & (who != fb) & (who != fc)
            block[DISTANCE + j], block[LATERAL + j] = square, max(0.0, square - upward)
            block[HIT + j] = 1.0 if hit else 0.0
        for j in range(min(BLOCK, near - first)):
            whose[found] = int(block[WHO + j])
            apart[found, 0], apart[found, 1] = block[DISTANCE + j], block[LATERAL + j]
            found += int(block[HIT + j])
    return found


@scalar
def _kept(positions, triangles, outward, p, t):
    """Squares of distance and lateral part of a pair that is kept; inf if it is found anyway, or has no area."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    nx, ny, nz = double_area_vector(positions, a, b, c)
    square = nx * nx + ny * ny + nz * nz
    if not square > 0.0:
        return math.inf, math.inf
    one = 1.0 / math.sqrt(square)
    nx, ny, nz = one * nx, one * ny, one * nz
    ox, oy, oz = outward[p, 0], outward[p, 1], outward[p, 2]
    size = math.sqrt(ox * ox + oy * oy + oz * oz)
    one = 1.0 / size if size > 0.0 else 0.0
    if one * ox * nx + one * oy * ny + one * oz * nz < SQUARE:
        return math.inf, math.inf
    return _distance(positions, p, a, b, c, nx, ny, nz)


@scalar
def _distance(positions, p, a, b, c, nx, ny, nz):
    """Squares of the distance of a node from a triangle with unit normal n, and of its part in the plane [m^2]."""
    gx, gy, gz = positions[p, 0] - positions[a, 0], positions[p, 1] - positions[a, 1], positions[p, 2] - positions[a, 2]
    ux, uy, uz, vx, vy, vz = sides(positions, a, b, c)
    wx, wy, wz = vx - ux, vy - uy, vz - uz
    sx, sy, sz = cross(ux, uy, uz, nx, ny, nz)
    rx, ry, rz = cross(nx, ny, nz, vx, vy, vz)
    qx, qy, qz = cross(wx, wy, wz, nx, ny, nz)
    beside = max(gx * sx + gy * sy + gz * sz, gx * rx + gy * ry + gz * rz)
    if max(beside, (gx - ux) * qx + (gy - uy) * qy + (gz - uz) * qz) <= 0.0:
        return (gx * nx + gy * ny + gz * nz) ** 2, 0.0
    to_u = _to_side(gx, gy, gz, ux, uy, uz, 1.0 / (ux * ux + uy * uy + uz * uz))
    to_v = _to_side(gx, gy, gz, vx, vy, vz, 1.0 / (vx * vx + vy * vy + vz * vz))
    to_w = _to_side(gx - ux, gy - uy, gz - uz, wx, wy, wz, 1.0 / (wx * wx + wy * wy + wz * wz))
    square, height = min(to_u, to_v, to_w), gx * nx + gy * ny + gz * nz
    return square, max(0.0, square - height * height)


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
def _in_order(nodes, triangles, of_run, run, whose, apart):
    """NearPairs of pairs that were found in runs of one triangle each. of_run: those triangles, (runs,). run: where
    each begins, (runs + 1,)."""
    pairs, runs = run[-1], len(of_run)
    begin, order = np.zeros(triangles + 1, np.int64), np.empty(runs, np.int64)
    for r in range(runs):
        begin[of_run[r] + 1] += 1
    for t in range(triangles):
        begin[t + 1] += begin[t]
    for r in range(runs):
        order[begin[of_run[r]]] = r
        begin[of_run[r]] += 1
    start, free = np.zeros(nodes + 1, np.int64), np.zeros(nodes, np.int64)
    for i in range(pairs):
        start[whose[i] + 1] += 1
    for p in range(nodes):
        start[p + 1] += start[p]
        free[p] = start[p]
    triangle, ordered = np.empty(pairs, np.int64), np.empty((pairs, 2))
    for r in order:
        for i in range(run[r], run[r + 1]):
            k = free[whose[i]]
            free[whose[i]] = k + 1
            triangle[k], ordered[k, 0], ordered[k, 1] = of_run[r], apart[i, 0], apart[i, 1]
    return NearPairs(start, triangle, ordered)
