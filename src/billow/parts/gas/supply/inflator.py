"""Inflator: mass flow and temperature against time, composition, and the ring of jets it blows through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.supply.curve import Curve, CurveTable, interval


@dataclass(frozen=True)
class JetRing:
    """Jets through holes evenly spaced on a ring about the mouth axis.

    count; ring_radius: of the holes [m]; hole_diameter [m]; angle: of each jet from the mouth axis, outwards [rad].
    cone: half-angle of the cone each jet spreads in [rad], where the gas model asks for it. azimuth: of the first hole
    at the start, about the axis [rad]; from where: `Jets.zero`. spin: rate at which the ring turns about the axis
    [rad/s].
    """

    count: int
    ring_radius: float
    hole_diameter: float
    angle: float
    cone: float = 0.0
    azimuth: float = 0.0
    spin: float = 0.0


@dataclass(frozen=True)
class Inflator:
    """Gas source.

    flow_time [s], mass_flow [kg/s]: piecewise linear, zero outside. temperature_time [s], temperature [K]: total
    (stagnation) temperature, piecewise linear, constant outside. mass_fractions: (species,) in the order of the gas.
    A delay is already in both times. chamber: index of the chamber it blows into.
    """

    flow_time: np.ndarray
    mass_flow: np.ndarray
    temperature_time: np.ndarray
    temperature: np.ndarray
    mass_fractions: np.ndarray
    name: str = "inflator"
    chamber: int = 0

    @cached_property
    def cumulative(self) -> np.ndarray:
        """Mass delivered up to each flow_time [kg], exact for the piecewise linear flow."""
        steps = 0.5 * (self.mass_flow[1:] + self.mass_flow[:-1]) * np.diff(self.flow_time)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def delivered(self, time: float) -> float:
        """Mass delivered up to time [s], [kg]: the closed form the mass ledger is checked against."""
        return delivered_mass(self.flow_time, self.mass_flow, self.cumulative, time)


class InflowTable(NamedTuple):
    """Inflators as kernels need them.

    flow, cumulative: mass flow [kg/s] and mass delivered [kg] against time, on the same points. temperature [K] against
    time. mass_fractions: (inflators, species). chamber: (inflators,) int64.
    """

    flow: CurveTable
    cumulative: np.ndarray
    temperature: CurveTable
    mass_fractions: np.ndarray
    chamber: np.ndarray

    @classmethod
    def build(cls, inflators: Sequence[Inflator]) -> InflowTable:
        return cls(
            CurveTable.build([Curve(i.flow_time, i.mass_flow) for i in inflators]),
            np.concatenate([np.empty(0), *(i.cumulative for i in inflators)]),
            CurveTable.build([Curve(i.temperature_time, i.temperature) for i in inflators]),
            np.array([i.mass_fractions for i in inflators]),
            np.array([i.chamber for i in inflators], dtype=np.int64),
        )


@scalar
def delivered_mass(flow_time, mass_flow, cumulative, time):
    """Exact integral [kg] of the piecewise linear mass flow up to time [s]."""
    if time <= flow_time[0]:
        return 0.0
    last = len(flow_time) - 1
    if time >= flow_time[last]:
        return cumulative[last]
    k = interval(flow_time, time)
    span = time - flow_time[k]
    slope = (mass_flow[k + 1] - mass_flow[k]) / (flow_time[k + 1] - flow_time[k])
    return cumulative[k] + span * (mass_flow[k] + 0.5 * slope * span)
