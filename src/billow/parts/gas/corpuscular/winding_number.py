"""How often the surface of a chamber, however crumpled, goes around a point, and the audit that uses it to check,
independently of flight, that every particle is in its chamber (docs/theory.md, Inside and outside)."""

from __future__ import annotations

import math

import numpy as np
from numba import prange
from scipy.spatial import cKDTree

from billow.base.compiled import CHUNK, kernel
from billow.geometry.search_grid import box_around, cell_lists
from billow.geometry.triangle import double_area_vector
from billow.parts.gas.corpuscular.flight import UNCOUNTED, Flock
from billow.parts.gas.corpuscular.inside_points import Enclosure, meet, thin_axis_last


def audit(flock: Flock, bag: Enclosure, some: np.ndarray | None = None) -> np.ndarray:
    """Recount both overlaps of all or some particles (n,) int64; returns the indices (n,) int64 of those that are in no
    chamber of their group. Those that are in another one than their own belong to that one from now on.

    bag: where the particles' step ended."""
    some = np.arange(len(flock.chamber)) if some is None else some
    some = some[flock.chamber[some] >= 0]
    winding = around = winding_numbers(flock.position[some], flock.chamber[some], bag)
    if bag.group is not None:
        group = bag.group[flock.chamber[some]]
        joined = Enclosure(bag.triangles, bag.positions, bag.chambers.joined(bag.group))
        around = winding_numbers(flock.position[some], group, joined)
        astray = (winding < 1) & (around > 0)
        for chamber in range(bag.chambers.count):
            there = np.flatnonzero(astray & (group == bag.group[chamber]))
            number = winding_numbers(flock.position[some[there]], np.full(len(there), chamber), bag)
            there, number = there[number > 0], number[number > 0]
            winding[there], flock.chamber[some[there]], astray[there] = number, chamber, False
    flock.overlap[some], flock.group_overlap[some] = np.maximum(winding, 1) - 1, np.maximum(around, 1) - 1
    return some[around < 1]


def recheck_parked(flock: Flock, bag: Enclosure) -> None:
    """Recount the particles that flight has put beside a wall; if fabric has moved over that place, bring them back."""
    bring_back(flock, audit(flock, bag, np.flatnonzero(flock.overlap == UNCOUNTED)))


def bring_back(flock: Flock, escaped: np.ndarray) -> None:
    """Move escaped particles to the nearest particle inside their chamber; velocity, hence energy, does not change.

    If all particles of a chamber have escaped, none of them moves.
    """
    inside = np.ones(len(flock.chamber), np.bool_)
    inside[escaped] = False
    for chamber in np.unique(flock.chamber[escaped]):
        lost = escaped[flock.chamber[escaped] == chamber]
        others = np.flatnonzero(inside & (flock.chamber == chamber))
        if len(others):
            nearest = others[cKDTree(flock.position[others]).query(flock.position[lost])[1]]
            flock.position[lost], flock.overlap[lost] = flock.position[nearest], flock.overlap[nearest]
            flock.group_overlap[lost] = flock.group_overlap[nearest]


def winding_numbers(points: np.ndarray, chamber: np.ndarray, bag: Enclosure) -> np.ndarray:
    """How often the surface of its chamber goes around each point, (points,) int32: 0 outside, 1 inside, 2 where two
    parts of the bag overlap, negative where the bag is turned inside out.

    points [m] (points, 3), NaN counts as outside; chamber (points,).
    """
    turned, order, low = thin_axis_last(bag.positions)
    width, depth, _ = box_around(turned)[1]  # its lowest corner is the origin
    # As many fields as there are triangles, or points, if those are few: lists for a single point are not worth it.
    field = math.sqrt(max(width * depth, 1e-300) / max(min(len(bag.triangles), len(points)), 1))
    shape = np.array([int(width / field) + 1, int(depth / field) + 1])
    triangles, spans = bag.triangles, np.empty((len(bag.triangles), 6), np.int32)
    _find_fields(len(triangles), triangles, turned, field, spans)
    start, listed = cell_lists(spans, np.array([*shape, 1]))  # of the plane across the rays
    found = np.zeros(len(points), np.int32)
    _count_passages(
        len(points), np.ascontiguousarray((points - low)[:, order]), np.asarray(chamber), triangles, turned,
        bag.chambers.behind, bag.chambers.ahead, field, shape, start, listed, found,
    )  # fmt: skip
    return found


@kernel
def _find_fields(n, triangles, positions, field, spans_out):
    """Fields that each triangle touches in the plane across the rays, as in `cell_lists`."""
    for t in prange(n):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for axis in range(2):
            u, v, w = positions[a, axis] / field, positions[b, axis] / field, positions[c, axis] / field
            spans_out[t, 2 * axis], spans_out[t, 2 * axis + 1] = int(min(u, v, w)), int(max(u, v, w))
        spans_out[t, 4], spans_out[t, 5] = 0, 0


@kernel
def _count_passages(n, points, chamber, triangles, positions, behind, ahead, field, shape, start, listed, found_out):
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        for p in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            home = chamber[p]
            x, y, z = points[p, 0], points[p, 1], points[p, 2]
            if not (0.0 <= x < field * shape[0] and 0.0 <= y < field * shape[1] and abs(z) < np.inf):
                continue
            place = int(x / field) * shape[1] + int(y / field)
            winding = 0
            for entry in range(start[place], start[place + 1]):
                t = listed[entry]
                left = (1 if behind[t] == home else 0) - (1 if ahead[t] == home else 0)
                if left == 0:
                    continue
                a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
                sense, _ = meet(a, b, c, positions, x, y)
                if sense == 0:
                    continue
                nx, ny, nz = double_area_vector(positions, a, b, c)
                wx, wy, wz = positions[a, 0] - x, positions[a, 1] - y, positions[a, 2] - z
                # The triangle is above the point if the point is behind it and the ray passes along the normal, or if
                # neither is the case.
                if (nx * wx + ny * wy + nz * wz > 0.0) == (sense > 0):
                    winding += sense * left
            found_out[p] = winding
