"""Limited slopes of the gas in clusters, which see neighbours and walls alike, and the state half a step later.

B. van Leer, Towards the ultimate conservative difference scheme V, J. Comput. Phys. 32 (1979) 101 (slopes, harmonic
limiter, Hancock's half step). On each side of each axis a cluster sees the mean, by area, of the clusters behind open
faces and of the walls there. A wall says only what the velocity along the axis is. Without walls a layer thinner than a
cell between panels that part would know nothing of its own expansion, and push on them like a damper.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.geometry.lattice_clipping import NORMAL, PLACE
from billow.parts.gas.mesh.thermodynamics import RHO, C, P, U
from billow.parts.gas.mesh.walls import fragment_velocity

VALUES = 5
"""Of a state that have slopes: rho, u, v, w, p."""
NARROW, NEAR = 1e-6, 1e-4
"""Area [faces] and distance [cells] on a side from which it is seen."""
WALLED = 0.5
"""Share of walls on a side from which the limiter is the stricter minmod."""
LEAST = 0.2
"""Density and pressure half a step later, relative, below which a cluster forgets its slopes."""
TEAM = 128
"""Clusters that share scratch."""


@scalar
def limited(a, b, walled):
    """Slope between two one-sided ones."""
    if not a * b > 0.0:
        return 0.0
    if walled:
        return a if abs(a) < abs(b) else b
    return 2.0 * a * b / (a + b)


@kernel
def find_slopes(
    n, start, members, of, beside, aperture, fragments_of, new_start, order, rows, triangle, triangles, velocity,
    through, state, place, courant, second_order, slope_out, half_out,
):  # fmt: skip
    """slope_out: (n, 3, VALUES) per cell. half_out: (n, VALUES), the state half a step later.

    n clusters: start, members, of as in Clusters; beside, aperture: of the cells; fragments_of: (cells,), the number of
    each cell among those with the fragments rows, in new_start and order; triangle: of each fragment; through: speed at
    which gas leaves through it [m/s]. courant: dt/h.
    second_order: van Leer's scheme, else only the slopes of u_d along d, for the walls.
    """
    for team in prange((n + TEAM - 1) // TEAM):
        seen = np.empty((3, 2, VALUES + 3))  # sums of area, area x, area q, and area of walls
        for c in range(team * TEAM, min(n, (team + 1) * TEAM)):
            for v in range(VALUES):
                half_out[c, v] = state[c, v]
                for d in range(3):
                    slope_out[c, d, v] = 0.0
            if not state[c, P] > 0.0:
                continue
            if start[c + 1] - start[c] == 1 and _in_the_open(
                members[start[c]], c, beside, aperture, of, fragments_of, new_start, state, place, second_order,
                slope_out,
            ):  # fmt: skip
                if second_order:
                    _half_step(state, c, slope_out, 0.5 * courant, half_out)
                continue
            seen[:] = 0.0
            for m in range(start[c], start[c + 1]):
                i = members[m]
                for face in range(6):
                    j, d, side = beside[i, face], face // 2, face % 2
                    if j < 0 or of[j] == c:
                        continue
                    a, k = aperture[i, d] if side else aperture[j, d], of[j]
                    if a > 0.0 and state[k, P] > 0.0:
                        seen[d, side, 0] += a
                        seen[d, side, 1] += a * place[k, d]
                        for v in range(VALUES):
                            seen[d, side, 2 + v] += a * state[k, v]
                at = fragments_of[i]
                if at < 0:
                    continue
                for g in range(new_start[at], new_start[at + 1]):
                    f = order[g]
                    moves = fragment_velocity(rows, f, triangles, triangle[f], velocity)
                    out = through[f]
                    if out != 0.0:
                        out /= np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)
                    for d in range(3):
                        a = abs(rows[f, NORMAL + d])
                        leaves = moves[d] + out * rows[f, NORMAL + d]
                        side = 1 if rows[f, NORMAL + d] > 0.0 else 0
                        seen[d, side, 0] += a
                        seen[d, side, 1] += a * rows[f, PLACE + d]
                        for v in range(VALUES):
                            seen[d, side, 2 + v] += a * (leaves if v == U + d else state[c, v])
                        seen[d, side, 2 + VALUES] += a
            for d in range(3):
                below, above = seen[d, 0, 0], seen[d, 1, 0]
                if below < NARROW or above < NARROW:
                    continue
                left, right = place[c, d] - seen[d, 0, 1] / below, seen[d, 1, 1] / above - place[c, d]
                if left < NEAR or right < NEAR:
                    continue
                walled = seen[d, 0, 2 + VALUES] > WALLED * below or seen[d, 1, 2 + VALUES] > WALLED * above
                for v in range(VALUES):
                    if second_order or v == U + d:
                        a = (state[c, v] - seen[d, 0, 2 + v] / below) / left
                        b = (seen[d, 1, 2 + v] / above - state[c, v]) / right
                        slope_out[c, d, v] = limited(a, b, walled)
            if second_order:
                _half_step(state, c, slope_out, 0.5 * courant, half_out)


@scalar
def _in_the_open(i, c, beside, aperture, of, fragments_of, new_start, state, place, second_order, slope_out):
    """Slopes of cluster c, a single cell i without walls, which sees one cluster on each side of each axis; returns
    whether it is one, before anything is written."""
    at = fragments_of[i]
    if at >= 0 and new_start[at + 1] > new_start[at]:
        return False
    for d in range(3):
        j, k = beside[i, 2 * d], beside[i, 2 * d + 1]
        if j < 0 or k < 0 or aperture[j, d] < NARROW or aperture[i, d] < NARROW:
            return False
        a, b = of[j], of[k]
        if not (state[a, P] > 0.0 and state[b, P] > 0.0):
            return False
        if place[c, d] - place[a, d] < NEAR or place[b, d] - place[c, d] < NEAR:
            return False
    for d in range(3):
        a, b = of[beside[i, 2 * d]], of[beside[i, 2 * d + 1]]
        left, right = 1.0 / (place[c, d] - place[a, d]), 1.0 / (place[b, d] - place[c, d])
        for v in range(VALUES):
            if second_order or v == U + d:
                before, after = (state[c, v] - state[a, v]) * left, (state[b, v] - state[c, v]) * right
                slope_out[c, d, v] = limited(before, after, False)
    return True


@scalar
def _half_step(state, c, slope, half, half_out):
    """half: half a step over h [s/m]."""
    rho, p = state[c, RHO], state[c, P]
    divergence = slope[c, 0, U] + slope[c, 1, U + 1] + slope[c, 2, U + 2]
    for d in range(3):
        u = half * state[c, U + d]
        for v in range(VALUES):
            half_out[c, v] -= u * slope[c, d, v]
        half_out[c, U + d] -= half * slope[c, d, P] / rho
    half_out[c, RHO] -= half * rho * divergence
    half_out[c, P] -= half * rho * state[c, C] * state[c, C] * divergence
    if not (half_out[c, RHO] > LEAST * rho and half_out[c, P] > LEAST * p):
        forget(state, c, slope, half_out)


@scalar
def forget(state, c, slope, half):
    """Make cluster c one of the donor-cell scheme."""
    for v in range(VALUES):
        half[c, v] = state[c, v]
        for d in range(3):
            slope[c, d, v] = 0.0
