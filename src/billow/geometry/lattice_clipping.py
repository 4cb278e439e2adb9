"""Triangles cut into fragments by the cells of a cubic lattice.

Everything is in lattice coordinates: a cell is a unit cube between integers, so that its planes are exact and a
triangle that lies in a plane is in one cell, neither lost nor counted twice.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.base.scratch import Scratch

NORMAL, WEIGHT, PLACE, COLUMNS = 0, 3, 5, 8
"""Columns of a fragment: area vector, in cell faces, pointing out of the gas (three); weights of the triangle's second
and third corners in its centroid (two); centroid (three); a line of the processor's cache together."""
MOMENT, SHARE, LOOSE = 8, 11, 12
"""Of a loose one also integrals of xi_d^2 n_d, xi from the lower planes of the cell (three); its share of the triangle;
and the number of columns."""

FARTHEST = 2**20
"""Cells are numbered from -FARTHEST to FARTHEST along each axis."""
STRIDE = (2**42, 2**21, 1)
"""Of a cell's key along each axis; keys in ascending order are cells in order of x, y, z."""

NOTHING = 1e-14
"""Share of a triangle below which a fragment is left out."""
CORNERS = 16
"""Room for the corners of a clipped triangle, which has 9 at most."""
ROOMS = 10
"""Polygons that a triangle is clipped in: itself, and along each axis the part below a plane and twice the rest."""
TEAM = 128
"""Triangles that share room for polygons."""


class Fragments(NamedTuple):
    """They lie in memory cell by cell, those of a cell in order of triangles. rows: (n, COLUMNS); triangle: (n,) int32.
    first: (triangles + 1,) int64 and number: (n,) int32: those of triangle t are number[first[t]] to
    number[first[t + 1]]. levers: (n, 3), in order of triangles, share of the triangle times the weights of its corners
    in the centroid; they stay until the next cut."""

    rows: np.ndarray
    triangle: np.ndarray
    first: np.ndarray
    number: np.ndarray
    levers: np.ndarray

    def on(self, triangles: np.ndarray) -> np.ndarray:
        """Those on some triangles, in their order, (m,) int64."""
        count = self.first[triangles + 1] - self.first[triangles]
        return self.number[
            np.repeat(self.first[triangles] - np.cumsum(count) + count, count) + np.arange(count.sum())
        ].astype(np.int64)


class Loose(NamedTuple):
    """Fragments as they were found. slot, first: (triangles + 1,) int64: those of triangle t, of which there are
    first[t + 1] - first[t], begin at slot[t]. key: of the cell of each, int64; rows: (slots, LOOSE)."""

    slot: np.ndarray
    first: np.ndarray
    key: np.ndarray
    rows: np.ndarray


@scalar
def key_of(i, j, k):
    """Key of a cell."""
    return (i + FARTHEST) * STRIDE[0] + (j + FARTHEST) * STRIDE[1] + (k + FARTHEST)


@scalar
def cell_of(key):
    """Lower corner i, j, k of the cell with this key."""
    return (key >> 42) - FARTHEST, ((key >> 21) & (2 * FARTHEST - 1)) - FARTHEST, (key & (2 * FARTHEST - 1)) - FARTHEST


def clip(triangles: np.ndarray, sign: np.ndarray, places: np.ndarray, scratch: Scratch) -> Loose:
    """sign: (triangles,), 1.0 where the normal points out of the gas, else -1.0. places: of the nodes, in lattice
    coordinates, (nodes, 3). scratch: whose "passing" and "half" are used, and free again once fragments are packed."""
    n = len(triangles)
    slot, first = np.zeros(n + 1, np.int64), np.zeros(n + 1, np.int64)
    _most(n, triangles, places, slot)
    np.cumsum(slot, out=slot)
    key, rows = scratch.take("half", slot[n]).view(np.int64), scratch.take("passing", slot[n], LOOSE)
    _clip(n, triangles, sign, places, slot, key, rows, first)
    if (first[1:] > np.diff(slot)).any():
        raise RuntimeError("a triangle has more fragments than it can have")
    np.cumsum(first, out=first)
    return Loose(slot, first, key, rows)


@kernel
def _most(n, triangles, places, slot_out):
    """How many fragments each triangle can have."""
    for t in prange(n):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        x0, x1, x2 = places[a, 0], places[b, 0], places[c, 0]
        y0, y1, y2 = places[a, 1], places[b, 1], places[c, 1]
        z0, z1, z2 = places[a, 2], places[b, 2], places[c, 2]
        x = int(math.floor(max(x0, x1, x2)) - math.floor(min(x0, x1, x2)))  # planes that cut it
        y = int(math.floor(max(y0, y1, y2)) - math.floor(min(y0, y1, y2)))
        z = int(math.floor(max(z0, z1, z2)) - math.floor(min(z0, z1, z2)))
        # Lines in a plane part it into one region more than there are lines and crossings. Rounding may make an eighth
        # of seven where three lines meet nearly in one point.
        slot_out[t + 1] = 1 + x + y + z + y * z + z * x + x * y * (2 if z > 0 else 1)


@kernel
def _clip(n, triangles, sign, places, slot, key_out, rows_out, found_out):
    for team in prange((n + TEAM - 1) // TEAM):
        room = np.empty((ROOMS, CORNERS, 3))
        for t in range(team * TEAM, min(n, (team + 1) * TEAM)):
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            found_out[t + 1] = _fragments(places, a, b, c, sign[t], room, slot[t], slot[t + 1], key_out, rows_out)


@kernel
def pack(n, slot, first, rows, number, rows_out, triangle_out, moment_out, levers_out):
    """Put the loose fragments of n triangles where their numbers say; the levers stay in order of triangles."""
    for t in prange(n):
        for m in range(first[t + 1] - first[t]):
            f, at = slot[t] + m, number[first[t] + m]
            triangle_out[at], second, third = t, rows[f, WEIGHT], rows[f, WEIGHT + 1]
            for k in range(COLUMNS):
                rows_out[at, k] = rows[f, k]
            for d in range(3):
                moment_out[at, d] = rows[f, MOMENT + d]
            levers_out[first[t] + m, 0] = rows[f, SHARE] * (1.0 - second - third)
            levers_out[first[t] + m, 1], levers_out[first[t] + m, 2] = rows[f, SHARE] * second, rows[f, SHARE] * third


@scalar
def _split(polygons, source, n, axis, value, below, above):
    """Split a convex polygon of n corners by the plane x = value; returns the numbers of corners below and above."""
    under, over = 0, 0
    here = polygons[source, 0, axis] - value
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        there = polygons[source, j, axis] - value
        if here <= 0.0:
            for d in range(3):
                polygons[below, under, d] = polygons[source, i, d]
            under += 1
        if here >= 0.0:
            for d in range(3):
                polygons[above, over, d] = polygons[source, i, d]
            over += 1
        if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
            t = here / (here - there)
            for d in range(3):
                x = polygons[source, i, d] + t * (polygons[source, j, d] - polygons[source, i, d])
                polygons[below, under, d] = polygons[above, over, d] = x
            polygons[below, under, axis] = polygons[above, over, axis] = value
            under, over = under + 1, over + 1
        here = there
    return under, over


@scalar
def _next_slab(polygons, source, n, axis, k, last):
    """Take the part below the plane k + 1 away from what is left of a polygon; of the last one nothing is left. Returns
    where the part is and how many corners it has, and the same of the rest."""
    if k == last or n < 3:
        return source, n, source, np.int64(0)
    part, rest = 3 * axis + 1, 3 * axis + 2
    rest += 1 if source == rest else 0
    below, above = _split(polygons, source, n, axis, float(k + 1), part, rest)
    return part, below, rest, above


@scalar
def _range(polygons, source, n, axis):
    low = high = polygons[source, 0, axis]
    for i in range(1, n):
        low, high = min(low, polygons[source, i, axis]), max(high, polygons[source, i, axis])
    return math.floor(low), math.floor(high)


@scalar
def _fragments(places, a, b, c, sign, room, first, end, key_out, rows_out):
    """Write the fragments of the triangle of nodes a, b, c from `first` on, before `end`; returns their number, which
    is more than fit where one had no room.

    room: (ROOMS, CORNERS, 3), for polygons.
    """
    for d in range(3):
        room[0, 0, d], room[0, 1, d], room[0, 2, d] = places[a, d], places[b, d], places[c, d]
    ux, uy, uz = room[0, 1, 0] - room[0, 0, 0], room[0, 1, 1] - room[0, 0, 1], room[0, 1, 2] - room[0, 0, 2]
    wx, wy, wz = room[0, 2, 0] - room[0, 0, 0], room[0, 2, 1] - room[0, 0, 1], room[0, 2, 2] - room[0, 0, 2]
    normal = (uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx)
    g = 0  # areas are measured in the projection along the largest component of the normal
    if abs(normal[1]) > abs(normal[g]):
        g = 1
    if abs(normal[2]) > abs(normal[g]):
        g = 2
    whole = normal[g]
    if whole == 0.0:
        return 0
    u, v = (g + 1) % 3, (g + 2) % 3
    found = 0
    # Not plain numbers: for each of those numba would compile what is called anew.
    x, y, z, all_corners = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
    x_rest, x_left = np.int64(0), all_corners
    x0, x1 = _range(room, x_rest, x_left, x)
    for i in range(x0, x1 + 1):
        layer, in_layer, x_rest, x_left = _next_slab(room, x_rest, x_left, x, i, x1)
        if in_layer < 3:
            continue
        y_rest, y_left = layer, in_layer
        y0, y1 = _range(room, layer, in_layer, y)
        for j in range(y0, y1 + 1):
            column, in_column, y_rest, y_left = _next_slab(room, y_rest, y_left, y, j, y1)
            if in_column < 3:
                continue
            z_rest, z_left = column, in_column
            z0, z1 = _range(room, column, in_column, z)
            for k in range(z0, z1 + 1):
                cell, in_cell, z_rest, z_left = _next_slab(room, z_rest, z_left, z, k, z1)
                if in_cell < 3:
                    continue
                low = (float(i), float(j), float(k))
                area, cx, cy, cz, sx, sy, sz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                px, py, pz = room[cell, 0, 0] - low[0], room[cell, 0, 1] - low[1], room[cell, 0, 2] - low[2]
                for m in range(1, in_cell - 1):
                    w = (room[cell, m, u] - room[cell, 0, u]) * (room[cell, m + 1, v] - room[cell, 0, v])
                    w -= (room[cell, m, v] - room[cell, 0, v]) * (room[cell, m + 1, u] - room[cell, 0, u])
                    area += w
                    qx, rx = room[cell, m, 0] - low[0], room[cell, m + 1, 0] - low[0]
                    qy, ry = room[cell, m, 1] - low[1], room[cell, m + 1, 1] - low[1]
                    qz, rz = room[cell, m, 2] - low[2], room[cell, m + 1, 2] - low[2]
                    cx, cy, cz = cx + w * (px + qx + rx), cy + w * (py + qy + ry), cz + w * (pz + qz + rz)
                    sx += w * (px * px + qx * qx + rx * rx + px * qx + qx * rx + rx * px)
                    sy += w * (py * py + qy * qy + ry * ry + py * qy + qy * ry + ry * py)
                    sz += w * (pz * pz + qz * qz + rz * rz + pz * qz + qz * rz + rz * pz)
                share = area / whole
                if not share > NOTHING:
                    continue
                if first + found == end:
                    return found + 1
                at, scale, mean = first + found, 0.5 * sign * share, 1.0 / (3.0 * area)
                key_out[at] = key_of(i, j, k)
                for d in range(3):
                    rows_out[at, NORMAL + d] = scale * normal[d]
                place = (low[0] + mean * cx, low[1] + mean * cy, low[2] + mean * cz)
                moment = (sx, sy, sz)
                for d in range(3):
                    rows_out[at, PLACE + d] = place[d]
                    rows_out[at, MOMENT + d] = moment[d] / (6.0 * area) * scale * normal[d]
                pu, pv = place[u] - room[0, 0, u], place[v] - room[0, 0, v]
                second = (pu * (room[0, 2, v] - room[0, 0, v]) - pv * (room[0, 2, u] - room[0, 0, u])) / whole
                third = ((room[0, 1, u] - room[0, 0, u]) * pv - (room[0, 1, v] - room[0, 0, v]) * pu) / whole
                rows_out[at, WEIGHT], rows_out[at, WEIGHT + 1], rows_out[at, SHARE] = second, third, share
                found += 1
    return found
