"""The contract every gas fulfils.

A gas fills the bag and pushes on it. It sees the bag's surface and how it moved (`Bag`), and answers with forces on
corners: it adds to `corner_force` (triangles, 3, 3) [N] and to nothing else. It promises, and
tests/contracts/test_gas_contract.py checks for every implementation:

1. mass closes: injected = inside + vented + leaked - what was there at the start, to rounding;
2. energy closes: U - U0 = enthalpy in - enthalpy out - work - heat lost, to rounding;
3. a sealed rigid bag obeys p V = m R T;
4. gas at rest puts no net force on a closed bag;
5. a scene moving at constant velocity changes nothing beyond the scheme's order;
6. work given equals work received: what the gas books as p dV is what the nodal forces do, to the scheme's order;
7. same seed, same bits, for any number of threads.

`NoGas` is an ordinary implementation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from billow.geometry.surface import Surface


@dataclass
class Bag:
    """All a gas may see.

    positions: [m] at the end of the step, velocities: [m/s] at its middle, both (nodes, 3). touched: (nodes,) bool,
    nodes in contact with any obstacle; None where nothing can be touched.
    """

    surface: Surface
    positions: np.ndarray
    velocities: np.ndarray
    touched: np.ndarray | None = None


@dataclass(frozen=True)
class ChamberTotals:
    """State of the gas in one chamber: pressure [Pa] absolute, temperature [K], volume [m^3], mass [kg], energy [J]."""

    name: str
    pressure: float
    temperature: float
    volume: float
    mass: float
    energy: float


@dataclass(frozen=True)
class GasTotals:
    """State of the whole gas.

    pressure [Pa] absolute, temperature [K], volume [m^3], mass_by_species [kg] (species,), energy [J], and running sums
    since the start: injected, vented, leaked, drawn_in [kg]; enthalpy_in, enthalpy_out [J]; work [J] done on the fabric
    including against the ambient; ambient_work [J] = p_amb (V - V0); jet_work [J]; jet_impulse_in, jet_impulse_out [N
    s]: thrust of all jets over time, and the part of it that found fabric in line of sight; mass_error, energy_error:
    largest relative ledger error of any step so far [-]; heat_lost [J] to the surroundings. blocked_area: of vents and
    fabric, by contact, now [m^2].

    Of several chambers pressure is the mean over volume and temperature the mean over mass; `chambers` has them one by
    one, and is empty for a single one. vented_by, leaked_by [kg] split the outflow by vent and by part of the fabric;
    passed [kg] is what went through passages between chambers, back flow subtracted. escaped: particles that were found
    outside their chamber and put back.
    """

    pressure: float
    temperature: float
    volume: float
    mass_by_species: np.ndarray
    energy: float
    injected: float
    vented: float
    leaked: float
    drawn_in: float
    enthalpy_in: float
    enthalpy_out: float
    work: float
    ambient_work: float
    jet_work: float
    jet_impulse_in: float
    jet_impulse_out: float
    mass_error: float
    energy_error: float
    heat_lost: float = 0.0
    blocked_area: float = 0.0
    vented_by: Mapping[str, float] = field(default_factory=dict)
    leaked_by: Mapping[str, float] = field(default_factory=dict)
    passed: Mapping[str, float] = field(default_factory=dict)
    chambers: tuple[ChamberTotals, ...] = ()
    escaped: int = 0

    @property
    def mass(self) -> float:
        """Mass inside [kg]."""
        return float(self.mass_by_species.sum())

    @property
    def work_on_fabric(self) -> float:
        """Net work on the fabric [J]: pressure against ambient, plus jets."""
        return self.work - self.ambient_work + self.jet_work


class GasModel(Protocol):
    """A gas: parameters only; everything that changes is in the state it hands out."""

    def start(self, bag: Bag) -> object:
        """State at time zero for the bag's start shape."""

    def advance(self, gas: object, bag: Bag, time: float, dt: float, corner_force: np.ndarray) -> None:
        """From `time` to `time + dt` [s]; the bag has already moved. Changes `gas`, adds to `corner_force`."""

    def stable_dt(self, gas: object) -> float:
        """Largest step [s] of the structure that the gas tolerates now."""

    def totals(self, gas: object) -> GasTotals:
        """Totals of the state."""

    def fields(self, gas: object) -> dict[str, np.ndarray]:
        """What users want to see on the fabric, for example {"pressure": gauge [Pa], (triangles,)}."""


@runtime_checkable
class LocalGas(GasModel, Protocol):
    """A gas that differs from place to place, and says how. A gas without these methods is the same everywhere."""

    def cells(self, gas: object) -> dict[str, np.ndarray]:
        """Boxes to look at: "centre" and "size" [m], (n, 3); "pressure" [Pa] absolute, "temperature" [K], "density"
        [kg/m^3], (n,); "velocity" [m/s], (n, 3); and what else there is."""

    def points(self, gas: object) -> dict[str, np.ndarray]:
        """The particles: "position" [m], (n, 3), and what is known of each by name, (n,) or (n, 3)."""

    def at(self, gas: object, places: np.ndarray) -> dict[str, np.ndarray]:
        """Readings at places [m], (m, 3): "pressure" [Pa] absolute, "temperature" [K], "density" [kg/m^3], (m,);
        "velocity" [m/s], (m, 3). Outside the bag those of the surroundings."""
