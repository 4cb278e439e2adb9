"""The part of the gas: what every gas model is asked in a run, whatever model it is."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import truediv

import numpy as np

from billow.base.errors import Concern, NumericalStop
from billow.base.quality import SHORT, SMALLER_STEPS, Criterion, criterion
from billow.geometry.chambers import OUTSIDE
from billow.geometry.surface import Surface
from billow.parts.gas.gas_model import Bag, GasModel, GasTotals
from billow.parts.gas.supply.concerns import supply_concerns
from billow.parts.gas.supply.passages import FABRIC
from billow.parts.gas.supply.supply import Supply
from billow.parts.part import (
    RECEIVED,
    WHOLE_MODEL,
    Account,
    Booking,
    Frame,
    Loads,
    Moment,
    Owner,
    Part,
    Quantity,
    Setting,
)

GAS_WORK = Account("gas_work", RECEIVED, renewed=True)
"""Net work of the gas on the fabric, pressure against ambient and jets, since the start."""

COLDEST, HOTTEST = 150.0, 3000.0
"""Gas temperatures [K] outside mean a wrong input."""

SMALLEST_VOLUME = 1e-3
"""Of a chamber's volume at the start; even a flat bag holds air."""

SQUEEZED = 0.1
"""Likewise; gas that is too hot in there is hot because of it."""

SECONDS_PER_TRIANGLE = 12e-9
"""Rough cost in a step of volume and pressure on a triangle."""

RUN_ON = 1.2
"""A run should end no earlier than at this many times the time of its pressure peak."""

UNITS = {
    "pressure": "Pa", "temperature": "K", "volume": "m^3", "mass": "kg", "energy": "J", "injected": "kg",
    "vented": "kg", "leaked": "kg", "drawn_in": "kg", "enthalpy_in": "J", "enthalpy_out": "J", "heat_lost": "J",
    "work": "J", "jet_work": "J", "jet_impulse_in": "N s", "jet_impulse_out": "N s", "blocked_area": "m^2",
}  # fmt: skip
"""Totals that histories hold of the whole gas."""

OF_CHAMBERS = ("pressure", "temperature", "volume", "mass", "energy")
"""Those that they hold of each chamber of several."""

RENAMED = {"mass": "gas_mass", "energy": "gas_energy", "work": "pressure_work"}
"""Their names in histories, of the whole gas."""

IMPOSSIBLE_TEMPERATURE = NumericalStop.declare(
    "E-NUM-002",
    f"the gas left its range: {{temperature:.1f}} K (allowed {COLDEST:.0f} to {HOTTEST:.0f} K)",
    where="{when}",
    why="pressure {pressure:.4g} Pa, volume {volume:.4g} m^3, mass {mass:.4g} kg",
    cause="mass flow or temperature of the inflator in another unit",
    remedy="check inflator.mass_flow (kg/s, seconds) and inflator.temperature (K)",
)
CHAMBER_COLLAPSED = NumericalStop.declare(
    "E-NUM-009",
    "chamber {chamber} has collapsed: {volume:.3g} l of {start:.3g} l at the start",
    where="chamber {chamber}, {when}",
    why="its walls passed through each other, or were pushed together by more than the gas can bear; its pressure, "
    "{pressure:.4g} Pa, has no meaning any more",
    cause="a start shape that is too flat, gas.initial.pressure far below the ambient pressure, or an obstacle that "
    "squeezes all gas out of a chamber",
    remedy="look at the last frames; reduce run.dt_scale, or raise bag.initial_gap or gas.initial.pressure",
)


@dataclass
class GasState:
    """content: the gas model's own state."""

    content: object

    # After the last step: what the guards look at.
    vitals = None


@dataclass(frozen=True)
class GasPart(Part):
    """model: the gas. surface and start: the bag and its positions at time zero [m], (nodes, 3). supply: what the model
    is fed with, None for one without."""

    model: GasModel
    surface: Surface
    start_shape: np.ndarray
    supply: Supply | None = None

    accounts = (GAS_WORK,)

    @cached_property
    def start_volumes(self) -> list[float]:
        """Volume of each chamber at time zero [m^3]."""
        return self.surface.chambers.volumes(self.surface.triangles, self.start_shape).tolist()

    def start(self, bag: Bag) -> GasState:
        return GasState(self.model.start(bag))

    # --- in a step -------------------------------------------------------------------------------------------------

    def advance(self, gas: GasState, bag: Bag, time: float, dt: float, loads: Loads) -> list[Booking]:
        """From `time` to `time + dt` [s]; adds the gas' forces to the loads."""
        self.model.advance(gas.content, bag, time, dt, loads)
        gas.vitals = self.model.vitals(gas.content)
        return [(GAS_WORK, gas.vitals.work_on_fabric)]

    def totals(self, gas: GasState) -> GasTotals:
        return self.model.totals(gas.content)

    def stable_dt(self, gas: GasState, limit: float) -> float:
        """Step [s] of the structure that the gas takes, of those up to the limit that all else has."""
        return self.model.stable_dt(gas.content, limit)

    # --- what a run says of it -------------------------------------------------------------------------------------

    def owners(self) -> Iterator[Owner]:
        yield Owner(WHOLE_MODEL, "", tuple(RENAMED.get(name, name) for name in UNITS))
        if self.supply is None:
            return
        for row in self.supply.passages.rows:
            within = OUTSIDE not in (row.behind, row.ahead)
            kind = "fabric part" if row.kind == FABRIC else "opening" if within else "vent"
            flow = "passed" if within else "leaked" if row.kind == FABRIC else "vented"
            yield Owner(kind if len(row.triangles) or row.kind == FABRIC else "orifice", row.name, (flow,))
        if self.supply.chambers.count > 1:
            yield from (Owner("chamber", name, OF_CHAMBERS) for name in self.supply.chambers.names)

    def quantities(self, gas: GasState, moment: Moment) -> Iterator[Quantity]:
        totals = self.totals(gas)
        for name, unit in UNITS.items():
            yield Quantity("", RENAMED.get(name, name), unit, getattr(totals, name))
        for name, by in (("vented", totals.vented_by), ("leaked", totals.leaked_by), ("passed", totals.passed)):
            for passage, mass in by.items():
                yield Quantity(passage, name, "kg", mass)
        for chamber in totals.chambers:
            for name in OF_CHAMBERS:
                yield Quantity(chamber.name, name, UNITS[name], getattr(chamber, name))

    def readings(self, gas: GasState, sensors: Mapping[str, Sequence[float]]) -> Iterator[Quantity]:
        """What sensors read, by their names and places [m]; nothing of a gas that is the same everywhere."""
        view = self.model.view()
        if view is None or not sensors:
            return
        found = view.at(gas.content, np.array(list(sensors.values())))
        for k, name in enumerate(sensors):
            yield Quantity(name, "gas_pressure", "Pa", float(found["pressure"][k]))
            yield Quantity(name, "gas_temperature", "K", float(found["temperature"][k]))
            yield Quantity(name, "gas_density", "kg/m^3", float(found["density"][k]))
            yield Quantity(name, "gas_velocity", "m/s", found["velocity"][k])

    def boxes(self, gas: GasState) -> tuple[bool, dict[str, np.ndarray]]:
        """Boxes to look at, as `LocalGas.cells`, and whether they are of a lattice; nothing of a gas that is the same
        everywhere."""
        view = self.model.view()
        return (view.on_lattice, view.cells(gas.content)) if view else (False, {})

    def particles(self, gas: GasState) -> dict[str, np.ndarray]:
        """Particles to look at, as `LocalGas.points`."""
        view = self.model.view()
        return view.points(gas.content) if view else {}

    def frame(self, gas: GasState, moment: Moment) -> Frame:
        return Frame(cell=self.model.fields(gas.content))

    def guard(self, gas: GasState, moment: Moment) -> None:
        """Raises NumericalStop: E-NUM-009 a chamber without volume, E-NUM-002 gas outside its temperatures.

        A number that is not finite is found elsewhere.
        """
        now = gas.vitals
        if now.energy:  # without gas a chamber may have any volume
            shares = list(map(truediv, now.volumes, self.start_volumes))
            # Before what a lack of volume does to pressure and temperature.
            if min(shares) < (SQUEEZED if now.temperature >= HOTTEST else SMALLEST_VOLUME):
                worst, totals = shares.index(min(shares)), self.totals(gas)
                rooms = totals.chambers or (totals,)
                raise CHAMBER_COLLAPSED(
                    chamber=self.surface.chambers.names[worst],
                    volume=1e3 * rooms[worst].volume,
                    start=1e3 * self.start_volumes[worst],
                    pressure=rooms[worst].pressure,
                    when=moment.when,
                )
        if not COLDEST < now.temperature < HOTTEST and math.isfinite(now.temperature):
            totals = self.totals(gas)
            raise IMPOSSIBLE_TEMPERATURE(
                temperature=totals.temperature, pressure=totals.pressure, volume=totals.volume, mass=totals.mass,
                when=moment.when,
            )  # fmt: skip

    def books(self, gas: GasState, moment: Moment, history) -> dict[str, float]:
        totals = self.totals(gas)
        peak = history.time[np.argmax(history.of("").pressure)]
        return {
            "gas_mass_error": totals.mass_error,
            "gas_energy_error": totals.energy_error,
            "injected_mass_kg": totals.injected,
            "injected_enthalpy_joule": totals.enthalpy_in,
            "jet_impulse_delivered": totals.jet_impulse_out / totals.jet_impulse_in if totals.jet_impulse_in else 1.0,
            "missing_to_pressure_peak_s": max(0.0, RUN_ON * float(peak) - moment.time),
            **self.model.books(gas.content),
        }

    def verdicts(self, books: Mapping[str, float], history) -> Iterator[Criterion]:
        yield criterion("mass error of the gas", books["gas_mass_error"], 1e-12, 1e-9, "-", SMALLER_STEPS)
        yield criterion("energy error of the gas", books["gas_energy_error"], 1e-12, 1e-9, "-", SMALLER_STEPS)
        yield from self.model.verdicts(books)
        longer = f"a longer run.end_time, to {RUN_ON:g} times the time of the pressure peak"
        yield criterion(SHORT, 1e3 * books["missing_to_pressure_peak_s"], 1e-9, math.inf, "ms", longer)

    def remarks(self, gas: GasState) -> list[str]:
        return self.model.remarks(gas.content)

    def concerns(self, setting: Setting) -> Iterator[Concern]:
        if self.supply is not None:
            yield from supply_concerns(self.supply, setting)
        yield from self.model.concerns(setting)

    def seconds_per_step(self, gas: GasState, dt: float, end: float) -> float:
        return SECONDS_PER_TRIANGLE * self.surface.triangle_count + self.model.seconds_per_step(gas.content, dt, end)
