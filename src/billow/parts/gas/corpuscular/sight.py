"""What a point sees of walls that stand still, and how to stand beside a wall for certain.

Standing walls are walls that end where they started, and a line of sight is a flight: the test is `crossing`.
"""

from __future__ import annotations

import math

from billow.base.compiled import scalar
from billow.geometry.search_grid import clipped_cell
from billow.parts.gas.corpuscular.crossing import BOTH, NEVER, crossing

ELBOW_ROOM = 1e-6
"""Largest distance [m] from a wall at which a particle is put beside it."""


@scalar
def first_wall(
    px, py, pz, qx, qy, qz, skip, nodes, orientation, behind, ahead, positions, first, listed, origin, cell, counts,
    reach,
):  # fmt: skip
    """Fraction of the straight way from p to q at which the first wall between two chambers stands, triangle `skip`
    left out; NEVER if there is none."""
    best = NEVER
    per_cell = 1.0 / cell
    low_x, high_x, low_y, high_y, low_z, high_z = (
        min(px, qx), max(px, qx), min(py, qy), max(py, qy), min(pz, qz), max(pz, qz),
    )  # fmt: skip
    xa = clipped_cell(min(low_x + reach, 0.5 * (low_x + high_x)), origin[0], per_cell, counts[0])
    xb = clipped_cell(max(high_x - reach, 0.5 * (low_x + high_x)), origin[0], per_cell, counts[0])
    ya = clipped_cell(min(low_y + reach, 0.5 * (low_y + high_y)), origin[1], per_cell, counts[1])
    yb = clipped_cell(max(high_y - reach, 0.5 * (low_y + high_y)), origin[1], per_cell, counts[1])
    za = clipped_cell(min(low_z + reach, 0.5 * (low_z + high_z)), origin[2], per_cell, counts[2])
    zb = clipped_cell(max(high_z - reach, 0.5 * (low_z + high_z)), origin[2], per_cell, counts[2])
    for x in range(xa, xb + 1):
        for y in range(ya, yb + 1):
            for z in range(za, zb + 1):
                c = (x * counts[1] + y) * counts[2] + z
                for entry in range(first[c], first[c + 1]):
                    t = listed[entry]
                    i, j, k = nodes[t, 0], nodes[t, 1], nodes[t, 2]
                    ax, ay, az = positions[i, 0], positions[i, 1], positions[i, 2]
                    bx, by, bz = positions[j, 0], positions[j, 1], positions[j, 2]
                    dx, dy, dz = positions[k, 0], positions[k, 1], positions[k, 2]
                    if (
                        (min(ax, bx, dx) > high_x) | (max(ax, bx, dx) < low_x)
                        | (min(ay, by, dy) > high_y) | (max(ay, by, dy) < low_y)
                        | (min(az, bz, dz) > high_z) | (max(az, bz, dz) < low_z)
                        | (behind[t] == ahead[t]) | (t == skip)
                    ):  # fmt: skip
                        continue
                    when, _, _, _, _, _ = crossing(
                        nodes, orientation, t, positions, positions, px, py, pz, qx, qy, qz, BOTH, -1.0
                    )
                    best = min(best, when)
    return best


@scalar
def beside_wall(
    t, wi, wj, wk, home, nodes, orientation, behind, ahead, positions, first, listed, origin, cell, counts, reach
):  # fmt: skip
    """A point in chamber `home` beside its wall t: half-way to the wall opposite, at most ELBOW_ROOM away.

    wi, wj, wk: barycentric weights of the place on the wall; drawn towards its middle, off the edges.
    """
    wi, wj, wk = 0.9 * wi + 0.1 / 3.0, 0.9 * wj + 0.1 / 3.0, 0.9 * wk + 0.1 / 3.0
    i, j, k = nodes[t, 0], nodes[t, 1], nodes[t, 2]
    ix, iy, iz = positions[i, 0], positions[i, 1], positions[i, 2]
    jx, jy, jz = positions[j, 0], positions[j, 1], positions[j, 2]
    kx, ky, kz = positions[k, 0], positions[k, 1], positions[k, 2]
    px, py, pz = wi * ix + wj * jx + wk * kx, wi * iy + wj * jy + wk * ky, wi * iz + wj * jz + wk * kz
    nx = (jy - iy) * (kz - iz) - (jz - iz) * (ky - iy)
    ny = (jz - iz) * (kx - ix) - (jx - ix) * (kz - iz)
    nz = (jx - ix) * (ky - iy) - (jy - iy) * (kx - ix)
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    if length == 0.0:
        return px, py, pz
    inward = (-orientation[t] if behind[t] == home else orientation[t]) * 2.0 * ELBOW_ROOM / length
    nx, ny, nz = inward * nx, inward * ny, inward * nz
    when = first_wall(
        px, py, pz, px + nx, py + ny, pz + nz, t, nodes, orientation, behind, ahead, positions, first, listed, origin,
        cell, counts, reach,
    )  # fmt: skip
    half = 0.5 * max(0.0, min(when, 1.0))
    return px + half * nx, py + half * ny, pz + half * nz
