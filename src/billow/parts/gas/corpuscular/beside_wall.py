"""How to place a particle beside a wall so that no other wall lies between: the line of sight to the wall opposite is a
flight past walls that stand still."""

from __future__ import annotations

import math

from billow.base.compiled import scalar
from billow.geometry.search_grid import clipped_cell
from billow.geometry.triangle import double_area_vector
from billow.parts.gas.corpuscular.crossing import BOTH, NEVER, crossing

LARGEST_DISTANCE = 1e-6
"""Largest distance [m] from a wall at which a particle is put beside it."""


@scalar
def beside_wall(t, wi, wj, wk, home, walls, positions, grid):
    """A point in chamber `home` beside its wall t: half-way to the wall opposite, at most LARGEST_DISTANCE away.

    wi, wj, wk: barycentric weights of the place on the wall, from which it is moved towards the middle, off the edges.
    positions: of the nodes [m], (nodes, 3). grid: SearchGrid that lists the walls there.
    """
    wi, wj, wk = 0.9 * wi + 0.1 / 3.0, 0.9 * wj + 0.1 / 3.0, 0.9 * wk + 0.1 / 3.0
    i, j, k = walls.nodes[t, 0], walls.nodes[t, 1], walls.nodes[t, 2]
    px = wi * positions[i, 0] + wj * positions[j, 0] + wk * positions[k, 0]
    py = wi * positions[i, 1] + wj * positions[j, 1] + wk * positions[k, 1]
    pz = wi * positions[i, 2] + wj * positions[j, 2] + wk * positions[k, 2]
    nx, ny, nz = double_area_vector(positions, i, j, k)
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    if length == 0.0:
        return px, py, pz
    orientation = walls.orientation[t]
    inward = (-orientation if walls.behind[t] == home else orientation) * 2.0 * LARGEST_DISTANCE / length
    nx, ny, nz = inward * nx, inward * ny, inward * nz
    when = _first_wall(px, py, pz, px + nx, py + ny, pz + nz, t, walls, positions, grid)
    half = 0.5 * max(0.0, min(when, 1.0))
    return px + half * nx, py + half * ny, pz + half * nz


@scalar
def _first_wall(px, py, pz, qx, qy, qz, skip, walls, positions, grid):
    """Fraction of the straight line from p to q at which the first wall between two chambers stands, triangle `skip`
    left out; NEVER if there is none."""
    best = NEVER
    low_x, high_x, xa, xb = _range(px, qx, grid, 0)
    low_y, high_y, ya, yb = _range(py, qy, grid, 1)
    low_z, high_z, za, zb = _range(pz, qz, grid, 2)
    for x in range(xa, xb + 1):
        for y in range(ya, yb + 1):
            for z in range(za, zb + 1):
                c = (x * grid.counts[1] + y) * grid.counts[2] + z
                for entry in range(grid.first[c], grid.first[c + 1]):
                    t = grid.listed[entry]
                    i, j, k = walls.nodes[t, 0], walls.nodes[t, 1], walls.nodes[t, 2]
                    if (
                        walls.behind[t] != walls.ahead[t] and t != skip
                        and _overlaps(positions, i, j, k, 0, low_x, high_x)
                        and _overlaps(positions, i, j, k, 1, low_y, high_y)
                        and _overlaps(positions, i, j, k, 2, low_z, high_z)
                    ):  # fmt: skip
                        when, _, _, _, _, _ = crossing(
                            walls.nodes, walls.orientation, t, positions, positions, px, py, pz, qx, qy, qz, BOTH, -1.0
                        )
                        best = min(best, when)
    return best


@scalar
def _range(p, q, grid, axis):
    """Lowest and highest coordinate of a line from p to q along an axis, and the first and last cell to search."""
    low, high, per_cell = min(p, q), max(p, q), 1.0 / grid.cell
    first = clipped_cell(min(low + grid.reach, 0.5 * (low + high)), grid.origin[axis], per_cell, grid.counts[axis])
    last = clipped_cell(max(high - grid.reach, 0.5 * (low + high)), grid.origin[axis], per_cell, grid.counts[axis])
    return low, high, first, last


@scalar
def _overlaps(positions, i, j, k, axis, low, high):
    """Whether the triangle of nodes i, j, k reaches into the interval from low to high along an axis."""
    a, b, c = positions[i, axis], positions[j, axis], positions[k, axis]
    return min(a, b, c) <= high and max(a, b, c) >= low
