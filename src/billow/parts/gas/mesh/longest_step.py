"""How long a part of a step may be, and which step of the structure parts of it best.

Linear upwind fluxes A+ and A- along each axis make every cell a mean of itself and its neighbours,

    W' = (I - r sum_d |A_d|) W + r sum_d (A+_d W_below - A-_d W_above),   r = dt/h.

In variables in which the A_d are symmetric (pressure over rho c, and velocity) these weights are symmetric too, sum up
to I, and are all positive if r times the largest eigenvalue of sum_d |A_d| is at most 1; then the sum of squares never
grows (K. O. Friedrichs, Symmetric hyperbolic linear differential equations, Comm. Pure Appl. Math. 7 (1954) 345). For
gas at rest that eigenvalue is 3 c, as is the sum of |u_d| + c over the axes; where gas flows it is less than that sum,
at the speed of sound by a factor of 1.17 along an axis and 1.29 along a diagonal: a wave that the flow carries along
one axis is no faster along the others.
"""

from __future__ import annotations

import math

from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar

HALVINGS = 20
"""Of the range that the eigenvalue is known to lie in."""
ONCE_PER_FRAGMENT, ONCE_PER_TRIANGLE = 0.25, 0.25
"""Rough cost [us] in a step of the structure, however many parts it has: cutting and loads; the fabric itself."""
PART_PER_FRAGMENT, PART_PER_CELL = 0.05, 0.7
"""And in each part [us]."""


@kernel
def fastest(n, held, sound, most_out):
    """Of each chunk of n cells that hold this, with this speed of sound [m/s]: the largest eigenvalue of sum_d |A_d|
    and the largest speed along an axis [m/s], (chunks, 2)."""
    species = held.shape[1] - 4
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        most, flow = 0.0, 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            m = 0.0
            for s in range(species):
                m += held[i, s]
            if m != 0.0:
                share = 1.0 / m
                u, v = abs(share * held[i, species]), abs(share * held[i, species + 1])
                w = abs(share * held[i, species + 2])
                most, flow = spread(u, v, w, sound[i], most), max(flow, u, v, w)
        most_out[chunk, 0], most_out[chunk, 1] = most, flow


@scalar
def _short_of(speed, around, a, b, d, x, y, z):
    """Below zero if `speed` is below the largest eigenvalue of the matrix with the diagonal around, a, b, d and the
    squares x, y, z beside `around` in its first row and column."""
    return speed - around - x / (speed - a) - y / (speed - b) - z / (speed - d)


@scalar
def spread(u, v, w, c, most):
    """The larger of `most` [m/s] and the largest eigenvalue of sum_d |A_d| of gas with these speeds along the axes,
    none negative, and this speed of sound [m/s]."""
    if not u + v + w + 3.0 * c > most:
        return most
    along_x, along_y, along_z = max(u, c), max(v, c), max(w, c)
    around = along_x + along_y + along_z
    a, b, d = along_x + v + w, along_y + w + u, along_z + u + v  # none larger than `around`
    x, y, z = min(u, c) ** 2, min(v, c) ** 2, min(w, c) ** 2
    if most > around and _short_of(most, around, a, b, d, x, y, z) >= 0.0:
        return most
    top = max(a, b, d)
    low, high = around, 0.5 * (around + top + math.sqrt((around - top) ** 2 + 4.0 * (x + y + z)))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _short_of(middle, around, a, b, d, x, y, z) < 0.0:
            low = middle
        else:
            high = middle
    return max(most, high)


def parts_of(limit: float, part: float, most: int, cells: int, fragments: int, triangles: int) -> float:
    """The step [s] of the structure, not longer than `limit`, that costs least for the time it covers.

    part: longest part of a step [s]; most: parts of a step at most. A step that needs little more than a number of
    parts is worth less than one of just so many.
    """
    limit = min(limit, most * part)
    whole = math.floor(limit / part) if math.isfinite(limit) else 0
    if not 0 < whole < most:
        return limit
    once = ONCE_PER_FRAGMENT * fragments + ONCE_PER_TRIANGLE * triangles
    each = PART_PER_FRAGMENT * fragments + PART_PER_CELL * cells
    shorter = (once + whole * each) / (whole * part)
    return whole * part if shorter < (once + (whole + 1) * each) / limit else limit
