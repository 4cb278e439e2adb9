"""Particles first, uniform pressure from a given time on.

While a bag unfolds, jets, gaps and the way of the gas matter; once pressure is even, particles cost time for nothing.
In the step that ends nearest to the given time the particles fly to its end for the last time. What each chamber then
holds goes into uniform pressure: mass by species, with what inflators have delivered and is no particle yet, and all
energy, with what is pending or pooled and what walls were given and have not passed on. Mass and energy thus go over
exactly. Uniform pressure knows no flow: the kinetic energy of the gas' bulk motion becomes heat, and its momentum, with
the impulses that patches of fabric still hold, is dropped.

Work is booked by trapezia. The force at the beginning of that step was the particles', the one at its end is that of
uniform pressure; each has done half of the step's work. The pressure at the end must know that work, which is found by
iteration.

The books of the particles are kept as they stood; totals are theirs plus those of uniform pressure.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.surface import area_vectors
from billow.parts.gas.corpuscular.corpuscular import Corpuscular
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.gas_model import Bag, GasTotals
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.inflator import Inflator
from billow.parts.gas.supply.mixture import mixture_gas_constant, mixture_temperature
from billow.parts.gas.uniform.uniform_pressure import UniformPressure, UniformState

ITERATIONS = 6
"""For the pressure and its work in half a step; each is better than the last by the change of volume in it, 1e-3."""


@dataclass
class SwitchingState:
    """corpuscular: the particles, and for ever their books; uniform: means nothing until switched."""

    corpuscular: CorpuscularState
    uniform: UniformState
    switched: bool = False

    # Totals of the particles' books, made anew from them after a restart.
    so_far = None


@dataclass(frozen=True)
class Switching:
    """corpuscular and uniform: the same bag, inflators, passages and ambient. time: of the switch [s]; it waits until
    every chamber holds gas."""

    corpuscular: Corpuscular
    uniform: UniformPressure
    time: float

    @property
    def table(self) -> np.ndarray:
        return self.uniform.table

    @property
    def species_names(self) -> tuple[str, ...]:
        return self.uniform.species_names

    @property
    def inflators(self) -> tuple[Inflator, ...]:
        return self.uniform.inflators

    @property
    def ambient(self) -> Ambient:
        return self.uniform.ambient

    @property
    def chambers(self) -> Chambers:
        return self.uniform.chambers

    # --- the contract ----------------------------------------------------------------------------------------------

    def start(self, bag: Bag) -> SwitchingState:
        """Particles in the start shape."""
        return SwitchingState(self.corpuscular.start(bag), self.uniform.start(bag))

    def advance(self, gas: SwitchingState, bag: Bag, time: float, dt: float, corner_force: np.ndarray) -> None:
        if gas.switched:
            self.uniform.advance(gas.uniform, bag, time, dt, corner_force)
            gas.corpuscular.positions[...] = bag.positions
        elif dt > 0.0 and time + 1.5 * dt > self.time and gas.corpuscular.masses.any(axis=1).all():
            self._switch(gas, bag, time, dt, corner_force)
        else:
            self.corpuscular.advance(gas.corpuscular, bag, time, dt, corner_force)

    def _switch(self, gas: SwitchingState, bag: Bag, time: float, dt: float, corner_force: np.ndarray) -> None:
        """From time to time + dt [s], at the end of which the gas is uniform."""
        old = gas.corpuscular
        self.corpuscular.arrive(old, bag, time, dt)
        masses, energy = self.corpuscular.content(old)
        swept = self._swept(bag, dt)
        pressure, temperature = np.empty_like(energy), old.temperature.copy()
        work = np.zeros_like(energy)
        for c in range(len(energy)):
            for _ in range(ITERATIONS):
                temperature[c] = mixture_temperature(self.table, masses[c], energy[c] - work[c], temperature[c])
                pressure[c] = mixture_gas_constant(self.table, masses[c]) * temperature[c] / old.volume[c]
                work[c] = pressure[c] * swept[c]
        old.load.work += float(work.sum())
        old.load.ambient_work += self.ambient.pressure * float(swept.sum())
        gas.uniform = self.uniform.holding(masses, energy - work, old.volume.copy(), pressure, temperature, time + dt)
        gas.uniform.is_open[...] = old.is_open
        self.uniform.press(gas.uniform, bag, corner_force)
        self.corpuscular.dismiss(old)
        gas.switched = True
        self._close_books(gas)

    def _swept(self, bag: Bag, dt: float) -> np.ndarray:
        """Volume [m^3] (chambers,) that the walls, as they stand at the end, gain in half a step of dt [s]."""
        triangles, chambers = bag.surface.triangles, self.chambers
        normals = area_vectors(triangles, bag.positions)
        rate = np.sum(normals * bag.velocities[triangles].mean(axis=1), axis=1)
        inner, outer = chambers.behind != OUTSIDE, chambers.ahead != OUTSIDE
        gained = np.bincount(chambers.behind[inner], rate[inner], chambers.count)
        return 0.5 * dt * (gained - np.bincount(chambers.ahead[outer], rate[outer], chambers.count))

    def _close_books(self, gas: SwitchingState) -> None:
        """Hold what went over against all that came and left since the start."""
        old, totals = gas.corpuscular, self.totals(gas)
        came = float(old.start_masses.sum()) + totals.injected + totals.drawn_in
        gap = totals.mass + totals.vented + totals.leaked - came
        old.mass_error = max(old.mass_error, abs(gap) / came)
        scale = old.start_energy + totals.enthalpy_in
        gap = totals.energy + totals.enthalpy_out + totals.work - scale
        old.energy_error = max(old.energy_error, abs(gap) / scale)
        gas.so_far = None

    def stable_dt(self, gas: SwitchingState) -> float:
        """That of the gas it is now."""
        return self.uniform.stable_dt(gas.uniform) if gas.switched else self.corpuscular.stable_dt(gas.corpuscular)

    # --- what users see --------------------------------------------------------------------------------------------

    def totals(self, gas: SwitchingState) -> GasTotals:
        if not gas.switched:
            return self.corpuscular.totals(gas.corpuscular)
        if gas.so_far is None:
            gas.so_far = self.corpuscular.totals(gas.corpuscular)
        return _together(gas.so_far, self.uniform.totals(gas.uniform))

    def fields(self, gas: SwitchingState) -> dict[str, np.ndarray]:
        if not gas.switched:
            return self.corpuscular.fields(gas.corpuscular)
        chambers, uniform = self.chambers, gas.uniform
        side = np.where(chambers.behind != OUTSIDE, chambers.behind, chambers.ahead)
        return self.uniform.fields(uniform) | {
            "gas_temperature": uniform.temperature[side],
            "gas_density": (uniform.masses.sum(axis=1) / uniform.volume)[side],
            "gas_velocity": np.zeros((len(side), 3)),
        }

    def cells(self, gas: SwitchingState) -> dict[str, np.ndarray]:
        """After the switch, a box about each chamber."""
        if not gas.switched:
            return self.corpuscular.cells(gas.corpuscular)
        triangles, positions = self.corpuscular.surface.triangles, gas.corpuscular.positions
        corners = [positions[self.chambers.boundary(c, triangles)].reshape(-1, 3) for c in range(self.chambers.count)]
        low, high = (np.array([extreme(places, axis=0) for places in corners]) for extreme in (np.min, np.max))
        uniform, nothing = gas.uniform, np.zeros(len(low))
        return {
            "centre": 0.5 * (low + high),
            "size": high - low,
            "pressure": uniform.pressure.copy(),
            "temperature": uniform.temperature.copy(),
            "density": uniform.masses.sum(axis=1) / uniform.volume,
            "velocity": np.zeros_like(low),
            "particles": nothing,
        }

    def points(self, gas: SwitchingState) -> dict[str, np.ndarray]:
        """The particles; after the switch there are none."""
        return self.corpuscular.points(gas.corpuscular)

    def at(self, gas: SwitchingState, places: np.ndarray) -> dict[str, np.ndarray]:
        if not gas.switched:
            return self.corpuscular.at(gas.corpuscular, places)
        uniform, ambient, bag = gas.uniform, self.ambient, self.corpuscular.inside(gas.corpuscular)
        air = ambient.pressure / (mixture_gas_constant(self.table, ambient.mass_fractions) * ambient.temperature)
        rows = np.tile([ambient.pressure, ambient.temperature, air], (len(places), 1))
        for c in range(self.chambers.count):
            within = ~bag.outside(places, np.full(len(places), c))
            rows[within] = uniform.pressure[c], uniform.temperature[c], uniform.masses[c].sum() / uniform.volume[c]
        return {
            "pressure": rows[:, 0],
            "temperature": rows[:, 1],
            "density": rows[:, 2],
            "velocity": np.zeros((len(places), 3)),
        }


def _together(before: GasTotals, now: GasTotals) -> GasTotals:
    """The state now, sums since the start."""
    sums = (
        "injected", "vented", "leaked", "drawn_in", "enthalpy_in", "enthalpy_out", "work", "ambient_work", "jet_work",
        "jet_impulse_in", "jet_impulse_out", "heat_lost", "escaped",
    )  # fmt: skip
    split = ("vented_by", "leaked_by", "passed")
    return replace(
        now,
        **{name: getattr(before, name) + getattr(now, name) for name in sums},
        **{name: _added(getattr(before, name), getattr(now, name)) for name in split},
        mass_error=max(before.mass_error, now.mass_error),
        energy_error=max(before.energy_error, now.energy_error),
    )


def _added(before, now) -> dict[str, float]:
    return {name: before[name] + now[name] for name in now}
