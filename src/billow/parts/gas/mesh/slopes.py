"""Limited slopes of the gas in clusters, which see neighbours and walls alike, and the state half a step later.

B. van Leer, Towards the ultimate conservative difference scheme V, J. Comput. Phys. 32 (1979) 101 (slopes, harmonic
limiter, Hancock's half step). On each side of each axis a cluster sees the mean, by area, of the clusters behind open
faces and of the walls there. A wall says only what the velocity along the axis is. Without walls a layer thinner than a
cell between panels that part would know nothing of its own expansion, and push on them like a damper. An opening to
another room is no wall: behind it lies a cluster, as behind an open face.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.parts.gas.mesh.patches import AREA, AT, SIDE, SPEED
from billow.parts.gas.mesh.thermodynamics import RHO, C, G, P, U

VALUES = 5
"""Of a state that have slopes: rho, u, v, w, p."""
GAMMA, HEAT, HALF = 5, 6, 8
"""Columns of a state half a step later that do not change: gamma, and rho e/p; and the number of columns, a line of the
processor's cache."""
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
    n, start, members, of, beside, aperture, walls, rows, through, door, beyond, state, place, courant, second_order,
    slope_out, half_out,
):  # fmt: skip
    """slope_out: (n, 3, VALUES) per cell. half_out: (n, HALF), the state half a step later.

    n clusters: start, members, of as in Clusters; beside, aperture: of the cells; walls: first patch of each cell, and
    one more; rows: of the patches; through: speed at which gas leaves through each [m/s]; door: of each its row of
    `beyond`, place (3) and state (VALUES) of the cluster behind an opening, or -1. courant: dt/h. second_order: van
    Leer's scheme, else only the slopes of u_d along d, for the walls.
    """
    for team in prange((n + TEAM - 1) // TEAM):
        seen = np.empty((3, 2, VALUES + 3))  # sums of area, area x, area (q - q of the cluster), and area of walls
        for c in range(team * TEAM, min(n, (team + 1) * TEAM)):
            rho, p, sound = state[c, RHO], state[c, P], state[c, C]
            for v in range(VALUES):
                half_out[c, v] = state[c, v]
            if not p > 0.0:
                forget(state, c, slope_out, half_out)
                continue
            half_out[c, GAMMA], half_out[c, HEAT] = sound * sound * rho / p, 1.0 / (state[c, G] - 1.0)
            first = members[start[c]]
            open_around = start[c + 1] - start[c] == 1 and walls[first + 1] == walls[first]
            for face in range(6):
                j, d = beside[first, face], face // 2
                open_around = open_around and j >= 0
                if open_around:
                    a = aperture[first, d] if face % 2 else aperture[j, d]
                    away = place[of[j], d] - place[c, d] if face % 2 else place[c, d] - place[of[j], d]
                    open_around = a >= NARROW and away >= NEAR and state[of[j], P] > 0.0
            if open_around:  # one cluster on each side of each axis
                for d in range(3):
                    a, b = of[beside[first, 2 * d]], of[beside[first, 2 * d + 1]]
                    left, right = 1.0 / (place[c, d] - place[a, d]), 1.0 / (place[b, d] - place[c, d])
                    for v in range(VALUES):  # without branches: signs are hard to foresee
                        before, after = (state[c, v] - state[a, v]) * left, (state[b, v] - state[c, v]) * right
                        both = max(before * after, 0.0)
                        slope_out[c, d, v] = 2.0 * both / (before + after if both > 0.0 else 1.0)
                    if not second_order:
                        for v in range(VALUES):
                            slope_out[c, d, v] = slope_out[c, d, v] if v == U + d else 0.0
            else:
                seen[:] = 0.0
                for d in range(3):
                    for v in range(VALUES):
                        slope_out[c, d, v] = 0.0
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
                                seen[d, side, 2 + v] += a * (state[k, v] - state[c, v])
                    for q in range(walls[i], walls[i + 1]):
                        size, out, behind = rows[q, AREA], through[q], door[q]
                        if behind >= 0:
                            for d in range(3):
                                along = rows[q, SIDE + d]
                                a, side = size * abs(along), 1 if along > 0.0 else 0
                                seen[d, side, 0] += a
                                seen[d, side, 1] += a * beyond[behind, d]
                                for v in range(VALUES):
                                    seen[d, side, 2 + v] += a * (beyond[behind, 3 + v] - state[c, v])
                            continue
                        for d in range(3):  # what a wall does not say is as in the cluster
                            along = rows[q, SIDE + d]
                            a, side = size * abs(along), 1 if along > 0.0 else 0
                            seen[d, side, 2 + VALUES] += a
                            seen[d, side, 1] += a * rows[q, AT + d]
                            seen[d, side, 2 + U + d] += a * (rows[q, SPEED + d] + out * along - state[c, U + d])
                for d in range(3):
                    below, above = seen[d, 0, 0] + seen[d, 0, 2 + VALUES], seen[d, 1, 0] + seen[d, 1, 2 + VALUES]
                    if below < NARROW or above < NARROW:
                        continue
                    left, right = place[c, d] * below - seen[d, 0, 1], seen[d, 1, 1] - place[c, d] * above
                    if left < NEAR * below or right < NEAR * above:
                        continue
                    walled = seen[d, 0, 2 + VALUES] > WALLED * below or seen[d, 1, 2 + VALUES] > WALLED * above
                    back, ahead = -1.0 / left, 1.0 / right
                    for v in range(VALUES):
                        if second_order or v == U + d:
                            slope_out[c, d, v] = limited(back * seen[d, 0, 2 + v], ahead * seen[d, 1, 2 + v], walled)
            if second_order:
                late = 0.5 * courant
                divergence = slope_out[c, 0, U] + slope_out[c, 1, U + 1] + slope_out[c, 2, U + 2]
                for d in range(3):
                    u = late * state[c, U + d]
                    for v in range(VALUES):
                        half_out[c, v] -= u * slope_out[c, d, v]
                    half_out[c, U + d] -= late * slope_out[c, d, P] / rho
                half_out[c, RHO] -= late * rho * divergence
                half_out[c, P] -= late * rho * sound * sound * divergence
                if not (half_out[c, RHO] > LEAST * rho and half_out[c, P] > LEAST * p):
                    forget(state, c, slope_out, half_out)


@scalar
def forget(state, c, slope, half):
    """Make cluster c one of the donor-cell scheme."""
    for v in range(VALUES):
        half[c, v] = state[c, v]
        for d in range(3):
            slope[c, d, v] = 0.0
