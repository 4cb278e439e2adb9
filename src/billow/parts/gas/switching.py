"""A local gas first, uniform pressure from a given time on (docs/theory.md, Switch to uniform pressure).

The books of the local gas are kept as they stood; totals are theirs plus those of uniform pressure.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from billow.base.errors import Concern
from billow.base.quality import Criterion
from billow.geometry.chambers import OUTSIDE
from billow.geometry.surface import Surface, area_vectors
from billow.parts.gas.gas_model import Bag, GasTotals, LocalGas, SwitchableGas
from billow.parts.gas.supply.mixture import mixture_gas_constant, mixture_temperature
from billow.parts.gas.supply.supply import Supply
from billow.parts.gas.uniform.uniform_pressure import UniformPressure, UniformState
from billow.parts.part import Loads, Setting

ITERATIONS = 6
"""For the pressure and its work in half a step; each is better than the last by the change of volume in it, 1e-3."""


@dataclass
class SwitchingState:
    """local: the local gas, and its books ever after; uniform: without meaning until switched. positions: of the
    surface now [m], (nodes, 3). mass_error, energy_error: of what went over [-]."""

    local: object
    uniform: UniformState
    positions: np.ndarray
    switched: bool = False
    mass_error: float = 0.0
    energy_error: float = 0.0

    # Totals of the local gas' books, made anew from them after a restart.
    so_far = None


@dataclass(frozen=True)
class Switching(LocalGas):
    """local and uniform: of the same supply, in the same bag. time: of the switch [s]; it waits until every chamber
    holds gas."""

    surface: Surface
    local: SwitchableGas
    uniform: UniformPressure
    time: float

    @property
    def on_lattice(self) -> bool:
        return self.local.on_lattice

    @property
    def supply(self) -> Supply:
        return self.uniform.supply

    # --- the contract ----------------------------------------------------------------------------------------------

    def start(self, bag: Bag) -> SwitchingState:
        """The local gas in the start shape."""
        return SwitchingState(self.local.start(bag), self.uniform.start(bag), bag.positions.copy())

    def advance(self, gas: SwitchingState, bag: Bag, time: float, dt: float, loads: Loads) -> None:
        gas.positions[...] = bag.positions
        if gas.switched:
            self.uniform.advance(gas.uniform, bag, time, dt, loads)
        elif dt > 0.0 and time + 1.5 * dt > self.time and self.local.can_hand_over(gas.local):
            self._switch(gas, bag, time, dt, loads)
        else:
            self.local.advance(gas.local, bag, time, dt, loads)

    def _switch(self, gas: SwitchingState, bag: Bag, time: float, dt: float, loads: Loads) -> None:
        """From time to time + dt [s], at the end of which the gas is uniform."""
        start = self.local.totals(gas.local)
        content = self.local.hand_over(gas.local, bag, time, dt)
        masses, energy, table = content.masses, content.energy, self.supply.table
        swept = self._swept(bag, dt)
        pressure, temperature = np.empty_like(energy), content.temperature
        work = np.zeros_like(energy)
        for c in range(len(energy)):
            for _ in range(ITERATIONS):
                temperature[c] = mixture_temperature(table, masses[c], energy[c] - work[c], temperature[c])
                pressure[c] = mixture_gas_constant(table, masses[c]) * temperature[c] / content.volume[c]
                work[c] = pressure[c] * swept[c]
        self.local.book_work(gas.local, float(work.sum()), self.supply.ambient.pressure * float(swept.sum()))
        gas.uniform = self.uniform.holding(bag, masses, energy - work, content.volume, pressure, temperature, time + dt)
        gas.uniform.is_open[...] = content.is_open
        self.uniform.press(gas.uniform, loads)
        gas.switched = True
        self._close_books(gas, start)

    def _swept(self, bag: Bag, dt: float) -> np.ndarray:
        """Volume [m^3] (chambers,) that the walls, as they stand at the end, gain in half a step of dt [s]."""
        triangles, chambers = bag.surface.triangles, self.supply.chambers
        normals = area_vectors(triangles, bag.positions)
        rate = np.sum(normals * bag.velocities[triangles].mean(axis=1), axis=1)
        inner, outer = chambers.behind != OUTSIDE, chambers.ahead != OUTSIDE
        gained = np.bincount(chambers.behind[inner], rate[inner], chambers.count)
        return 0.5 * dt * (gained - np.bincount(chambers.ahead[outer], rate[outer], chambers.count))

    def _close_books(self, gas: SwitchingState, before: GasTotals) -> None:
        """Hold what went over against the books. before: totals of the local gas before the step."""
        gas.so_far = None
        now = self.totals(gas)

        def balance(totals: GasTotals) -> tuple[float, float]:
            """Mass [kg] and energy [J] that was there at the start, by the totals of any time."""
            mass = totals.mass + totals.vented + totals.leaked - totals.injected - totals.drawn_in
            return mass, totals.energy + totals.enthalpy_out + totals.work + totals.heat_lost - totals.enthalpy_in

        (mass, energy), (start_mass, start_energy) = balance(now), balance(before)
        gas.mass_error = abs(mass - start_mass) / (start_mass + now.injected + now.drawn_in)
        gas.energy_error = abs(energy - start_energy) / (start_energy + now.enthalpy_in)

    def stable_dt(self, gas: SwitchingState, limit: float) -> float:
        """That of the gas it is now."""
        return self.uniform.stable_dt(gas.uniform, limit) if gas.switched else self.local.stable_dt(gas.local, limit)

    # --- what users see --------------------------------------------------------------------------------------------

    def totals(self, gas: SwitchingState) -> GasTotals:
        if not gas.switched:
            return self.local.totals(gas.local)
        if gas.so_far is None:
            gas.so_far = self.local.totals(gas.local)
        return _together(gas.so_far, self.uniform.totals(gas.uniform), gas)

    def fields(self, gas: SwitchingState) -> dict[str, np.ndarray]:
        if not gas.switched:
            return self.local.fields(gas.local)
        chambers, uniform = self.supply.chambers, gas.uniform
        side = np.where(chambers.behind != OUTSIDE, chambers.behind, chambers.ahead)
        return self.uniform.fields(uniform) | {
            "gas_temperature": uniform.temperature[side],
            "gas_density": (uniform.masses.sum(axis=1) / uniform.volume)[side],
            "gas_velocity": np.zeros((len(side), 3)),
        }

    def cells(self, gas: SwitchingState) -> dict[str, np.ndarray]:
        """After the switch, a box about each chamber, and no cells of a lattice."""
        if not gas.switched:
            return self.local.cells(gas.local)
        if self.on_lattice:
            return {}
        triangles, chambers = self.surface.triangles, self.supply.chambers
        corners = [gas.positions[chambers.boundary(c, triangles)].reshape(-1, 3) for c in range(chambers.count)]
        low, high = (np.array([extreme(places, axis=0) for places in corners]) for extreme in (np.min, np.max))
        uniform = gas.uniform
        return {
            "centre": 0.5 * (low + high),
            "size": high - low,
            "pressure": uniform.pressure.copy(),
            "temperature": uniform.temperature.copy(),
            "density": uniform.masses.sum(axis=1) / uniform.volume,
            "velocity": np.zeros_like(low),
            "particles": np.zeros(len(low)),
        }

    def points(self, gas: SwitchingState) -> dict[str, np.ndarray]:
        """Of the local gas; after the switch there are none."""
        return self.local.points(gas.local)

    def at(self, gas: SwitchingState, places: np.ndarray) -> dict[str, np.ndarray]:
        if not gas.switched:
            return self.local.at(gas.local, places)
        uniform, ambient = gas.uniform, self.supply.ambient
        air = ambient.pressure / (mixture_gas_constant(self.supply.table, ambient.mass_fractions) * ambient.temperature)
        rows = np.tile([ambient.pressure, ambient.temperature, air], (len(places), 1))
        for c in range(self.supply.chambers.count):
            within = ~self.local.outside(gas.positions, places, c)
            rows[within] = uniform.pressure[c], uniform.temperature[c], uniform.masses[c].sum() / uniform.volume[c]
        return {
            "pressure": rows[:, 0],
            "temperature": rows[:, 1],
            "density": rows[:, 2],
            "velocity": np.zeros((len(places), 3)),
        }

    def books(self, gas: SwitchingState) -> dict[str, float]:
        return self.local.books(gas.local)

    def verdicts(self, books: Mapping[str, float]) -> Iterator[Criterion]:
        return self.local.verdicts(books)

    def concerns(self, setting: Setting) -> Iterator[Concern]:
        return self.local.concerns(setting)

    def remarks(self, gas: SwitchingState) -> list[str]:
        return self.local.remarks(gas.local)

    def seconds_per_step(self, gas: SwitchingState, dt: float, end: float) -> float:
        """As long as the local gas is there, and nearly nothing afterwards."""
        return self.local.seconds_per_step(gas.local, dt, end) * min(1.0, self.time / end)


SUMS = (
    "injected", "vented", "leaked", "drawn_in", "enthalpy_in", "enthalpy_out", "work", "ambient_work", "jet_work",
    "jet_impulse_in", "jet_impulse_out", "heat_lost",
)  # fmt: skip
SPLIT = ("vented_by", "leaked_by", "passed")


def _together(before: GasTotals, now: GasTotals, gas: SwitchingState) -> GasTotals:
    """The state now, sums since the start."""

    def added(name: str) -> dict[str, float]:
        earlier, later = getattr(before, name), getattr(now, name)
        return {key: earlier[key] + later[key] for key in later}

    return replace(
        now,
        **{name: getattr(before, name) + getattr(now, name) for name in SUMS},
        **{name: added(name) for name in SPLIT},
        mass_error=max(before.mass_error, now.mass_error, gas.mass_error),
        energy_error=max(before.energy_error, now.energy_error, gas.energy_error),
    )
