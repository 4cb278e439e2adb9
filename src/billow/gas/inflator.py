"""Inflator: mass flow and temperature against time, composition, and the ring of jets it blows through."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.compiled import scalar


@dataclass(frozen=True)
class JetRing:
    """Jets through holes evenly spaced on a ring about the mouth axis.

    count; ring_radius: of the holes [m]; hole_diameter [m]; angle: of each jet from the mouth axis, outwards [rad].
    """

    count: int
    ring_radius: float
    hole_diameter: float
    angle: float


@dataclass(frozen=True)
class Inflator:
    """Gas source.

    flow_time [s], mass_flow [kg/s]: piecewise linear, zero outside. temperature_time [s], temperature [K]: total
    (stagnation) temperature, piecewise linear, constant outside. mass_fractions: (species,) in the order of the gas.
    """

    flow_time: np.ndarray
    mass_flow: np.ndarray
    temperature_time: np.ndarray
    temperature: np.ndarray
    mass_fractions: np.ndarray

    @property
    def cumulative(self) -> np.ndarray:
        """Mass delivered up to each flow_time [kg], exact for the piecewise linear flow."""
        steps = 0.5 * (self.mass_flow[1:] + self.mass_flow[:-1]) * np.diff(self.flow_time)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def delivered(self, time: float) -> float:
        """Mass delivered up to time [s], [kg]: the closed form the mass ledger is checked against."""
        return delivered_mass(self.flow_time, self.mass_flow, self.cumulative, time)


@scalar
def delivered_mass(flow_time, mass_flow, cumulative, time):
    """Exact integral [kg] of the piecewise linear mass flow up to time [s]."""
    if time <= flow_time[0]:
        return 0.0
    last = len(flow_time) - 1
    if time >= flow_time[last]:
        return cumulative[last]
    k = np.searchsorted(flow_time, time, side="right") - 1
    span = time - flow_time[k]
    slope = (mass_flow[k + 1] - mass_flow[k]) / (flow_time[k + 1] - flow_time[k])
    return cumulative[k] + span * (mass_flow[k] + 0.5 * slope * span)


@scalar
def interpolate(x, y, at):
    """Piecewise linear value, constant outside."""
    last = len(x) - 1
    if at <= x[0]:
        return y[0]
    if at >= x[last]:
        return y[last]
    k = np.searchsorted(x, at, side="right") - 1
    return y[k] + (y[k + 1] - y[k]) * (at - x[k]) / (x[k + 1] - x[k])
