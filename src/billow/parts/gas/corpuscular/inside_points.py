"""Points spread evenly by volume inside a closed surface (docs/theory.md, Inside and outside)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.chambers import Chambers
from billow.geometry.search_grid import box_around
from billow.parts.gas.corpuscular.random_numbers import stream, uniform

COLUMNS_PER_POINT = 4
FEWEST_COLUMNS = 40_000

INSIDE_POINTS = 0x494E5349
"""Names the random numbers of points and columns."""


@dataclass(frozen=True)
class Enclosure:
    """The surface of a bag as it stands: triangles (n, 3), positions [m] (nodes, 3), its chambers, and the groups that
    openings join them to, (chambers,) int32; None if there are no openings."""

    triangles: np.ndarray
    positions: np.ndarray
    chambers: Chambers
    group: np.ndarray | None = None


def points_inside(bag: Enclosure, number: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points in each chamber, as many as `number` (chambers,) int64 says.

    Returns points [m] (number.sum(), 3), chamber by chamber; their chambers (number.sum(),) int32; and volumes [m^3]
    (chambers,) as found by the columns, for comparison with Gauss' theorem. A chamber without volume, which no column
    meets, gets no points.
    """
    turned, order, low = thin_axis_last(bag.positions)
    width, depth = np.ptp(turned, axis=0)[:2]
    columns = max(FEWEST_COLUMNS, COLUMNS_PER_POINT * int(number.sum()))
    edge = math.sqrt(max(width * depth, 1e-300) / columns)
    shape = np.array([max(1, math.ceil(width / edge)), max(1, math.ceil(depth / edge))])
    pitch = np.array([width, depth]) / shape
    sides = bag.chambers.behind, bag.chambers.ahead
    start, height, left, entered = _cut(bag.triangles.astype(np.int64), turned, *sides, shape, pitch, seed)
    length = _inside_length(start, height, left, entered, len(number))
    found = np.where(length > 0.0, number, 0)
    points, chamber = _deal(start, height, left, entered, shape, pitch, length, found, seed)
    back = np.empty_like(points)
    back[:, order] = points
    return back + low, chamber, length * pitch[0] * pitch[1]


def thin_axis_last(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions [m] (nodes, 3) from their lowest corner, axes in cyclic order so that the thinnest extent comes last;
    that order of the axes (3,), and the lowest corner [m] (3,)."""
    low, high = box_around(positions)
    thin = int(np.argmin(high - low))
    order = np.array([(thin + 1) % 3, (thin + 2) % 3, thin])  # cyclic: keeps the sense of orientation
    return np.ascontiguousarray((positions - low)[:, order]), order, low


@scalar
def _column(index, shape, pitch, seed):
    """Position of a column [m]: random within its field."""
    key = stream(seed + INSIDE_POINTS, 0, index)
    return (index // shape[1] + uniform(key, 0)) * pitch[0], (index % shape[1] + uniform(key, 1)) * pitch[1]


@scalar
def _left_of(positions, a, b, x, y):
    """Twice the area of (x, y) and edge a-b, positive if the point is on the left, and whether it is; evaluated from
    the lower to the higher node.

    A point on the line counts as if it were shifted a little along x, and still less along y. A point at a node then
    lies in exactly one of the triangles around it (Edelsbrunner and Muecke, "Simulation of simplicity", 1990).
    """
    low, high = min(a, b), max(a, b)
    ax, ay = positions[low, 0], positions[low, 1]
    ux, uy = positions[high, 0] - ax, positions[high, 1] - ay
    area = ux * (y - ay) - uy * (x - ax)
    left = area > 0.0 or (area == 0.0 and (uy < 0.0 or (uy == 0.0 and ux > 0.0)))
    return (area, left) if a < b else (-area, not left)


@scalar
def meet(a, b, c, positions, x, y):
    """Whether a column passes triangle a-b-c: 1 along its normal, -1 against it, 0 if not; and at what height [m]."""
    area_a, left_a = _left_of(positions, b, c, x, y)
    area_b, left_b = _left_of(positions, c, a, x, y)
    area_c, left_c = _left_of(positions, a, b, x, y)
    if not (left_a == left_b and left_b == left_c):
        return 0, 0.0
    sense = 1 if left_a else -1
    total = area_a + area_b + area_c
    if total == 0.0:
        return sense, positions[a, 2]
    return sense, (area_a * positions[a, 2] + area_b * positions[b, 2] + area_c * positions[c, 2]) / total


@scalar
def _cut(triangles, positions, behind, ahead, shape, pitch, seed):
    """The triangles each column passes, from below: start (columns + 1,), height [m], chambers left and entered."""
    columns = shape[0] * shape[1]
    start, filled = np.zeros(columns + 1, np.int64), np.zeros(columns, np.int64)
    height, left, entered = np.empty(0), np.empty(0, np.int32), np.empty(0, np.int32)
    for filling in range(2):
        for t in range(len(triangles)):
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            x0 = min(positions[a, 0], positions[b, 0], positions[c, 0])
            x1 = max(positions[a, 0], positions[b, 0], positions[c, 0])
            y0 = min(positions[a, 1], positions[b, 1], positions[c, 1])
            y1 = max(positions[a, 1], positions[b, 1], positions[c, 1])
            for i in range(max(0, int(x0 / pitch[0]) - 1), min(shape[0], int(x1 / pitch[0]) + 2)):
                for j in range(max(0, int(y0 / pitch[1]) - 1), min(shape[1], int(y1 / pitch[1]) + 2)):
                    index = i * shape[1] + j
                    x, y = _column(index, shape, pitch, seed)
                    sense, z = meet(a, b, c, positions, x, y)
                    if sense != 0 and filling == 0:
                        start[index + 1] += 1
                    elif sense != 0:
                        at = start[index] + filled[index]
                        filled[index] += 1
                        while at > start[index] and height[at - 1] > z:  # insert by height
                            height[at], left[at], entered[at] = height[at - 1], left[at - 1], entered[at - 1]
                            at -= 1
                        height[at] = z
                        left[at], entered[at] = (behind[t], ahead[t]) if sense > 0 else (ahead[t], behind[t])
        if filling == 0:
            for index in range(columns):
                start[index + 1] += start[index]
            total = start[columns]
            height, left, entered = np.empty(total), np.empty(total, np.int32), np.empty(total, np.int32)
    return start, height, left, entered


@scalar
def _pass(winding, left, entered):
    """Update the winding number of each chamber after one crossing; returns the chamber the column is now in, or -1."""
    if left >= 0:
        winding[left] -= 1
    if entered >= 0:
        winding[entered] += 1
    for k in range(len(winding)):
        if winding[k] > 0:
            return k
    return -1


@scalar
def _inside_length(start, height, left, entered, chambers):
    """Length of all columns within each chamber [m]."""
    length, winding = np.zeros(chambers), np.zeros(chambers, np.int64)
    for column in range(len(start) - 1):
        winding[:] = 0
        for at in range(start[column], start[column + 1] - 1):
            k = _pass(winding, left[at], entered[at])
            if k >= 0:
                length[k] += height[at + 1] - height[at]
    return length


@scalar
def _deal(start, height, left, entered, shape, pitch, length, number, seed):
    """Points at equal distances with jitter along the inside lengths of all columns."""
    chambers = len(number)
    first = np.zeros(chambers + 1, np.int64)
    for k in range(chambers):
        first[k + 1] = first[k] + number[k]
    points, chamber = np.empty((first[chambers], 3)), np.empty(first[chambers], np.int32)
    gone, dealt, winding = np.zeros(chambers), np.zeros(chambers, np.int64), np.zeros(chambers, np.int64)
    for column in range(len(start) - 1):
        winding[:] = 0
        for at in range(start[column], start[column + 1] - 1):
            k = _pass(winding, left[at], entered[at])
            if k < 0:
                continue
            here = height[at + 1] - height[at]
            while dealt[k] < number[k]:
                place = first[k] + dealt[k]
                key = stream(seed + INSIDE_POINTS, 1, place)
                along = (dealt[k] + uniform(key, 0)) * length[k] / number[k] - gone[k]
                if along > here:
                    break
                points[place, 0], points[place, 1] = _column(column, shape, pitch, seed)
                points[place, 2] = height[at] + along
                chamber[place] = k
                dealt[k] += 1
            gone[k] += here
    return points, chamber
