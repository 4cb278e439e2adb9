"""Total temperature of an inflow against time, and what a piecewise linear flow at that temperature brings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from billow.apps.tank.filling import Tank
from billow.apps.tank.flow import integrals


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
        """Mass [kg] and enthalpy [J] entered by the times [s] per 1 kg/s at each knot [s]: see `flow.integrals`."""

        def enthalpy(at: np.ndarray) -> np.ndarray:
            temperature = np.interp(at, self.times, self.values)
            distinct, back = np.unique(temperature, return_inverse=True)
            return np.array([tank.inflow_enthalpy(t) for t in distinct])[back].reshape(at.shape)

        return integrals(times, knots, enthalpy, self.times)
