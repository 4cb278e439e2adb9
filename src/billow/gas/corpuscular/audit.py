"""Is every particle in its chamber? Independent of flight, on the walls as they stand; escapees are pushed back.

A particle near walls looks at the nearest of them: the first wall on the straight way to its middle shows the particle
one of its sides, and behind that side lies the particle's chamber. Cells of the search grid without any wall nearby
belong to one chamber as a whole, together with all such cells they touch; one look per connected region is enough.

Within TOLERANCE of its own wall a particle counts as inside: rounding cannot tell.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.compiled import CHUNK, kernel, scalar
from billow.gas.corpuscular.crossing import NEVER
from billow.gas.corpuscular.flight import Flock
from billow.gas.corpuscular.sight import UNSEEN, beside_wall, first_wall, height_over
from billow.gas.corpuscular.walls import Walls
from billow.geometry.search_grid import SearchGrid, clipped_cell

TOLERANCE = 1e-7
"""Distance [m] on the wrong side of its own wall at which a particle still counts as inside."""

_NO_WALL = np.uint32(0xFFFF_FFFF)


def find_escaped(flock: Flock, walls: Walls, grid: SearchGrid, positions: np.ndarray) -> np.ndarray:
    """Indices (n,) int64 of particles that are not in the chamber they believe to be in.

    positions: [m], (nodes, 3), where the particles' step ended; grid: must cover them.
    """
    region = _chambers_of_free_cells(walls, grid, positions)
    escaped = np.zeros(len(flock.position), dtype=np.bool_)
    _find(
        len(flock.position), flock.position, flock.chamber, walls.nodes, walls.orientation, walls.behind, walls.ahead,
        positions, grid.first, grid.listed, grid.origin, grid.cell, grid.counts, grid.reach, region, escaped,
    )  # fmt: skip
    return np.flatnonzero(escaped)


def push_back(flock: Flock, escaped: np.ndarray, walls: Walls, grid: SearchGrid, positions: np.ndarray) -> None:
    """Put escaped particles back beside the nearest wall of their chamber; velocity, hence energy, stays.

    One whose chamber has no wall stays where it is.
    """
    _push_back.serial(
        len(escaped), escaped, flock.position, flock.chamber, walls.nodes, walls.orientation, walls.behind, walls.ahead,
        positions, grid.first, grid.listed, grid.origin, grid.cell, grid.counts, grid.reach,
    )  # fmt: skip


def _chambers_of_free_cells(walls, grid, positions):
    """Chamber of each cell without walls, (cells,) int32; UNSEEN for the others."""
    region = np.full(len(grid.first) - 1, UNSEEN, dtype=np.int32)
    _flood.serial(
        len(region), walls.nodes, walls.orientation, walls.behind, walls.ahead, positions, grid.first, grid.listed,
        grid.origin, grid.cell, grid.counts, grid.reach, region,
    )  # fmt: skip
    return region


@scalar
def _middle(nodes, t, positions):
    i, j, k = nodes[t, 0], nodes[t, 1], nodes[t, 2]
    return (
        (positions[i, 0] + positions[j, 0] + positions[k, 0]) / 3.0,
        (positions[i, 1] + positions[j, 1] + positions[k, 1]) / 3.0,
        (positions[i, 2] + positions[j, 2] + positions[k, 2]) / 3.0,
    )


@scalar
def _nearest_listed(px, py, pz, c, nodes, behind, ahead, positions, first, listed):
    """Wall of cell c whose middle is nearest to a point: (triangle, distance squared)."""
    best, nearest = np.inf, -1
    for entry in range(first[c], first[c + 1]):
        t = listed[entry]
        if behind[t] == ahead[t]:
            continue
        mx, my, mz = _middle(nodes, t, positions)
        away = (mx - px) ** 2 + (my - py) ** 2 + (mz - pz) ** 2
        if away < best:
            best, nearest = away, np.int64(t)
    return nearest, best


@kernel
def _find(
    n, position, chamber, nodes, orientation, behind, ahead, positions, first, listed, origin, cell, counts, reach,
    region, escaped_out,
):  # fmt: skip
    chunks = (n + CHUNK - 1) // CHUNK
    for chunk in prange(chunks):
        for p in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            home = chamber[p]
            if home < 0:
                continue
            px, py, pz = position[p, 0], position[p, 1], position[p, 2]
            off = False
            for axis in range(3):
                place = (position[p, axis] - origin[axis]) / cell
                off = off or not (0.0 <= place < counts[axis])
            if off:
                escaped_out[p] = True  # beyond all walls, or not a number
                continue
            x = clipped_cell(px, origin[0], 1.0 / cell, counts[0])
            y = clipped_cell(py, origin[1], 1.0 / cell, counts[1])
            z = clipped_cell(pz, origin[2], 1.0 / cell, counts[2])
            c = (x * counts[1] + y) * counts[2] + z
            if first[c] == first[c + 1]:
                escaped_out[p] = region[c] != home and region[c] != UNSEEN
                continue
            t, _ = _nearest_listed(px, py, pz, c, nodes, behind, ahead, positions, first, listed)
            if t < 0:
                continue
            mx, my, mz = _middle(nodes, t, positions)
            # A little beyond the middle, so that the wall aimed at is crossed.
            qx, qy, qz = mx + 1e-3 * (mx - px), my + 1e-3 * (my - py), mz + 1e-3 * (mz - pz)
            when, wall, near, far = first_wall(
                px, py, pz, qx, qy, qz, _NO_WALL, nodes, orientation, behind, ahead, positions, first, listed, origin,
                cell, counts, reach,
            )  # fmt: skip
            if when < NEVER and near != home:
                escaped_out[p] = not (far == home and height_over(nodes, wall, positions, px, py, pz) < TOLERANCE)


@kernel
def _flood(
    n, nodes, orientation, behind, ahead, positions, first, listed, origin, cell, counts, reach, region_out
):  # fmt: skip
    ny, nz = counts[1], counts[2]
    seen = np.zeros(n, dtype=np.bool_)
    queue = np.empty(n, dtype=np.int32)
    for begin in range(n):
        if seen[begin] or first[begin] < first[begin + 1]:
            continue
        queue[0], tail, head = begin, 1, 0
        seen[begin] = True
        answer = UNSEEN
        while head < tail:
            c = queue[head]
            head += 1
            x, y, z = c // (ny * nz), (c // nz) % ny, c % nz
            for side in range(6):
                step = 1 if side % 2 == 0 else -1
                u = x + (step if side < 2 else 0)
                v = y + (step if 2 <= side < 4 else 0)
                w = z + (step if side >= 4 else 0)
                if u < 0 or v < 0 or w < 0 or u >= counts[0] or v >= ny or w >= nz:
                    continue
                d = (u * ny + v) * nz + w
                if first[d] == first[d + 1]:
                    if not seen[d]:
                        seen[d] = True
                        queue[tail] = d
                        tail += 1
                elif answer == UNSEEN:
                    px = origin[0] + (x + 0.5) * cell
                    py = origin[1] + (y + 0.5) * cell
                    pz = origin[2] + (z + 0.5) * cell
                    t, _ = _nearest_listed(px, py, pz, d, nodes, behind, ahead, positions, first, listed)
                    if t >= 0:
                        mx, my, mz = _middle(nodes, t, positions)
                        qx, qy, qz = mx + 1e-3 * (mx - px), my + 1e-3 * (my - py), mz + 1e-3 * (mz - pz)
                        _, _, answer, _ = first_wall(
                            px, py, pz, qx, qy, qz, _NO_WALL, nodes, orientation, behind, ahead, positions, first,
                            listed, origin, cell, counts, reach,
                        )  # fmt: skip
        for done in range(tail):
            region_out[queue[done]] = answer


@kernel
def _push_back(
    n, escaped, position_out, chamber, nodes, orientation, behind, ahead, positions, first, listed, origin, cell,
    counts, reach,
):  # fmt: skip
    for e in range(n):
        p = escaped[e]
        px, py, pz = position_out[p, 0], position_out[p, 1], position_out[p, 2]
        best, t = np.inf, -1
        for s in range(len(nodes)):
            if behind[s] != ahead[s] and (behind[s] == chamber[p] or ahead[s] == chamber[p]):
                mx, my, mz = _middle(nodes, s, positions)
                away = (mx - px) ** 2 + (my - py) ** 2 + (mz - pz) ** 2
                if away < best:
                    best, t = away, s
        if t < 0:
            continue
        third = 1.0 / 3.0
        px, py, pz = beside_wall(
            t, third, third, third, chamber[p], nodes, orientation, behind, ahead, positions, first, listed, origin,
            cell, counts, reach,
        )  # fmt: skip
        position_out[p, 0], position_out[p, 1], position_out[p, 2] = px, py, pz
