"""Piecewise linear mass flow, and the mass and enthalpy it brings: linear in its values at the knots.

The same curve that `[inflator] mass_flow` takes: straight between knots, zero outside.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
"""Exact to degree 7: cp is of degree 4, so that h(T) is of degree 5 and, times a hat, of degree 6 in time."""


def integrals(
    times: np.ndarray, knots: np.ndarray, enthalpy: Callable[[np.ndarray], np.ndarray], breaks: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mass [kg] and enthalpy [J] that have entered by each time, per flow of 1 kg/s at each knot; both (times, knots).

    times [s]: increasing, the first is where counting begins; knots [s]: increasing; enthalpy: specific enthalpy
    [J/kg] of the inflow at times [s]; breaks [s]: where that function has kinks.
    """
    inside = np.concatenate([knots, breaks])
    grid = np.unique(np.concatenate([times, inside[(inside > times[0]) & (inside < times[-1])]]))
    width = np.diff(grid)
    at = grid[:-1, None] + 0.5 * width[:, None] * (_POINTS + 1.0)  # (intervals, 4)
    weight = 0.5 * width[:, None] * _WEIGHTS
    flowing = (at[:, 0] > knots[0]) & (at[:, 0] < knots[-1])
    left = np.clip(np.searchsorted(knots, at[:, 0], side="right") - 1, 0, len(knots) - 2)
    share = (at - knots[left, None]) / (knots[left + 1] - knots[left])[:, None]  # of the right knot
    rows = np.searchsorted(grid, times)
    row, made = np.arange(len(left)), []
    for density in (weight, weight * enthalpy(at)):
        parts = np.zeros((len(grid), len(knots)))
        parts[row + 1, left] = flowing * np.sum(density * (1.0 - share), axis=1)
        parts[row + 1, left + 1] = flowing * np.sum(density * share, axis=1)
        made.append(np.cumsum(parts, axis=0)[rows])
    return made[0], made[1]
