"""No gas: fabric in still air of ambient pressure. An ordinary implementation of the contract."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from billow.parts.gas.gas_model import Bag, GasModel, GasTotals
from billow.parts.part import Loads


@dataclass
class EmptyState:
    """triangle_count; volume: enclosed now [m^3]."""

    triangle_count: int
    volume: float


@dataclass(frozen=True)
class NoGas(GasModel):
    """ambient_pressure [Pa] and ambient_temperature [K] are only reported."""

    looks_back: ClassVar[bool] = False
    ambient_pressure: float = 101325.0
    ambient_temperature: float = 295.0

    def start(self, bag: Bag) -> EmptyState:
        return EmptyState(bag.surface.triangle_count, bag.surface.volume(bag.positions))

    def advance(self, gas: EmptyState, bag: Bag, time: float, dt: float, loads: Loads) -> None:
        gas.volume = bag.surface.volume(bag.positions)

    def totals(self, gas: EmptyState) -> GasTotals:
        return GasTotals(self.ambient_pressure, self.ambient_temperature, gas.volume, np.zeros(0), energy=0.0)

    def fields(self, gas: EmptyState) -> dict[str, np.ndarray]:
        return {"gauge_pressure": np.zeros(gas.triangle_count)}
