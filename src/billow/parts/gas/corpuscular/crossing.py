"""Where a flying point crosses a moving triangulated surface, without gaps at edges, at vertices or between steps
(docs/theory.md, Flight: the pieces of a triangle's prism, and the test); and places beside it."""

from __future__ import annotations

import math

from billow.base.compiled import scalar
from billow.geometry.search_grid import clipped_cell
from billow.geometry.triangle import cross, double_area_vector, sides

OUTWARD, INWARD, BOTH = 1, 2, 3
"""Directions of a crossing: from behind a triangle to ahead of it (along its normal), and back; BOTH is their sum."""

NEVER = 2.0
"""Fraction of the step that is returned if nothing is crossed."""

LARGEST_DISTANCE = 1e-6
"""Largest distance [m] from a wall at which a particle is put beside it."""

_ROUNDING = 5e-15
"""Bound of the rounding error of a determinant in units of (largest entry)^3: six products, each rounded five times."""


@scalar
def _determinant(ax, ay, az, bx, by, bz, cx, cy, cz):
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


@scalar
def _inside(d0, d1, d2, d3, sense, directions, rounding):
    """Whether the origin lies in a tetrahedron whose barycentric numerators are d0 ... d3, crossed in an allowed way.

    Their sum is six times its signed volume; `sense` times that is positive for outward crossings.
    """
    volume = d0 + d1 + d2 + d3
    if abs(volume) <= 4.0 * rounding:
        return False  # the particle moves along with the piece
    outward = sense * volume > 0.0
    if (outward and not directions & 1) or (not outward and not directions & 2):
        return False
    slack = 8.0 * rounding
    if volume > 0.0:
        return d0 >= -slack and d1 >= -slack and d2 >= -slack and d3 >= -slack
    return d0 <= slack and d1 <= slack and d2 <= slack and d3 <= slack


@scalar
def crossing(nodes, orientation, t, start, end, x0, y0, z0, x1, y1, z1, directions, after):
    """First crossing of triangle t by the line from (x0, y0, z0) at the start of a step to (x1, y1, z1) at its end.

    nodes: (triangles, 3), ascending node numbers of each triangle. orientation: (triangles,), +1 if the ascending order
    has the sense of the triangle, else -1. start, end: node positions [m], (nodes, 3). directions: OUTWARD, INWARD or
    BOTH. after: fraction of the step; earlier crossings do not count.

    Returns (fraction of the step or NEVER, OUTWARD or INWARD, piece, weight of node i, of j, of k); the weights sum to
    one.
    """
    i, j, k = nodes[t, 0], nodes[t, 1], nodes[t, 2]
    turn = orientation[t]
    i0x, i0y, i0z = start[i, 0] - x0, start[i, 1] - y0, start[i, 2] - z0
    j0x, j0y, j0z = start[j, 0] - x0, start[j, 1] - y0, start[j, 2] - z0
    k0x, k0y, k0z = start[k, 0] - x0, start[k, 1] - y0, start[k, 2] - z0
    i1x, i1y, i1z = end[i, 0] - x1, end[i, 1] - y1, end[i, 2] - z1
    j1x, j1y, j1z = end[j, 0] - x1, end[j, 1] - y1, end[j, 2] - z1
    k1x, k1y, k1z = end[k, 0] - x1, end[k, 1] - y1, end[k, 2] - z1
    largest = max(
        abs(i0x), abs(i0y), abs(i0z), abs(j0x), abs(j0y), abs(j0z), abs(k0x), abs(k0y), abs(k0z),
        abs(i1x), abs(i1y), abs(i1z), abs(j1x), abs(j1y), abs(j1z), abs(k1x), abs(k1y), abs(k1z),
    )  # fmt: skip
    rounding = _ROUNDING * largest * largest * largest
    best, way, piece, wi, wj, wk = NEVER, 0, 0, 0.0, 0.0, 0.0

    i0j0k1 = _determinant(i0x, i0y, i0z, j0x, j0y, j0z, k1x, k1y, k1z)
    i0j1k1 = _determinant(i0x, i0y, i0z, j1x, j1y, j1z, k1x, k1y, k1z)

    d0 = _determinant(j0x, j0y, j0z, k0x, k0y, k0z, k1x, k1y, k1z)
    d1 = -_determinant(i0x, i0y, i0z, k0x, k0y, k0z, k1x, k1y, k1z)
    d3 = -_determinant(i0x, i0y, i0z, j0x, j0y, j0z, k0x, k0y, k0z)
    if _inside(d0, d1, i0j0k1, d3, -turn, directions, rounding):
        volume = d0 + d1 + i0j0k1 + d3
        fraction = d3 / volume
        if fraction >= after and fraction < best:
            best, way, piece = fraction, OUTWARD if turn * volume < 0.0 else INWARD, 0
            wi, wj = d0 / volume, d1 / volume
            wk = 1.0 - wi - wj

    d0 = _determinant(j0x, j0y, j0z, j1x, j1y, j1z, k1x, k1y, k1z)
    d2 = i0j0k1
    d3 = -_determinant(i0x, i0y, i0z, j0x, j0y, j0z, j1x, j1y, j1z)
    if _inside(d0, -i0j1k1, d2, d3, turn, directions, rounding):
        volume = d0 - i0j1k1 + d2 + d3
        fraction = (d2 + d3) / volume
        if fraction >= after and fraction < best:
            best, way, piece = fraction, OUTWARD if turn * volume > 0.0 else INWARD, 1
            wi, wk = d0 / volume, d3 / volume
            wj = 1.0 - wi - wk

    d0 = _determinant(i1x, i1y, i1z, j1x, j1y, j1z, k1x, k1y, k1z)
    d2 = _determinant(i0x, i0y, i0z, i1x, i1y, i1z, k1x, k1y, k1z)
    d3 = -_determinant(i0x, i0y, i0z, i1x, i1y, i1z, j1x, j1y, j1z)
    if _inside(d0, -i0j1k1, d2, d3, -turn, directions, rounding):
        volume = d0 - i0j1k1 + d2 + d3
        fraction = 1.0 - d0 / volume
        if fraction >= after and fraction < best:
            best, way, piece = fraction, OUTWARD if turn * volume < 0.0 else INWARD, 2
            wj, wk = d2 / volume, d3 / volume
            wi = 1.0 - wj - wk
    return best, way, piece, wi, wj, wk


@scalar
def piece_normal(nodes, orientation, t, piece, start, end):
    """Unit normal of a piece (on the triangle's outer side) and how far it moves along it in the step [m].

    Returns (nx, ny, nz, travel).
    """
    i, j, k = nodes[t, 0], nodes[t, 1], nodes[t, 2]
    mover = k if piece == 0 else (j if piece == 1 else i)
    if piece == 2:
        ax, ay, az, bx, by, bz = sides(end, i, j, k)
    else:
        ax, ay, az, bx, by, bz = sides(start, i, j, k)
        if piece == 1:
            bx, by, bz = end[k, 0] - end[j, 0], end[k, 1] - end[j, 1], end[k, 2] - end[j, 2]
    nx, ny, nz = cross(ax, ay, az, bx, by, bz)
    scale = orientation[t] / math.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = scale * nx, scale * ny, scale * nz
    travel = (
        nx * (end[mover, 0] - start[mover, 0])
        + ny * (end[mover, 1] - start[mover, 1])
        + nz * (end[mover, 2] - start[mover, 2])
    )
    return nx, ny, nz, travel


@scalar
def beside_wall(t, wi, wj, wk, outward, walls, positions, grid):
    """A point beside wall t, behind it if a flight `outward` met it: half-way to the wall opposite, at most
    LARGEST_DISTANCE away.

    The line of sight to it is a flight past walls that stand still.

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
    inward = (-orientation if outward else orientation) * 2.0 * LARGEST_DISTANCE / length
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
