"""Total temperature of an inflow against time; mass and enthalpy of a piecewise linear flow at that temperature.

The flow is the curve that `[inflator] mass_flow` takes: straight between knots, zero outside. Mass and enthalpy are
linear in its values at the knots.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from billow.apps.tank.filling import Tank

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
"""Exact to degree 7: cp is of degree 4, so that h(T) is of degree 5 and, times a hat, of degree 6 in time."""


@dataclass(frozen=True)
class InflowTemperature:
    """Total temperature [K] at times [s], (n,): linear between, constant outside."""

    times: np.ndarray
    values: np.ndarray

    @classmethod
    def constant(cls, value: float) -> InflowTemperature:
        """The same temperature [K] at all times."""
        return cls(np.zeros(1), np.full(1, value))

    def raised(self, by: float) -> InflowTemperature:
        """The curve moved up by a difference [K]."""
        return replace(self, values=self.values + by)

    def integrals(self, tank: Tank, times: np.ndarray, knots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mass [kg] and enthalpy [J] entered by the times [s] per 1 kg/s at each knot [s]: see `_integrals`."""

        def enthalpy(at: np.ndarray) -> np.ndarray:
            temperature = np.interp(at, self.times, self.values)
            distinct, back = np.unique(temperature, return_inverse=True)
            return np.array([tank.inflow_enthalpy(t) for t in distinct])[back].reshape(at.shape)

        return _integrals(times, knots, enthalpy, self.times)


def _integrals(
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
