"""Uniform pressure: one well-mixed gas fills each chamber (docs/theory.md, Uniform pressure)."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from billow.parts.gas.gas_model import Bag, ChamberTotals, GasModel, GasTotals, Vitals
from billow.parts.gas.supply.inflator import InflowTable
from billow.parts.gas.supply.jets import (
    UPDATE_INTERVAL,
    JetPattern,
    aim,
    blow,
)  # fmt: skip
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gas_constant
from billow.parts.gas.supply.supply import Source, Supply
from billow.parts.gas.uniform.chamber_step import (
    ALL_JET_WORK,
    ALL_WORK,
    BOOKS,
    ENERGY,
    PRESSURE,
    START_ENERGY,
    START_MASS,
    SUMS,
    TEMPERATURE,
    VOLUME,
    Books,
    Contents,
    SupplyTable,
    advance_chambers,
    plain,
    sum_up,
)  # fmt: skip
from billow.parts.part import VARYING, Loads


@dataclass
class UniformState:
    """Everything about the gas that changes.

    Of the chambers: masses [kg] (chambers, species); energy [J], volume [m^3], pressure [Pa] absolute, temperature [K],
    (chambers,). Of the passages: is_open (passages,) bool; passed (passages, 2), mass [kg] gone from behind to ahead
    and back. Books: through (chambers, species), mass [kg] gained by passages; start_masses [kg]; books (chambers,
    BOOKS) and sums (sums,), columns named in chamber_step.py. areas: present and blocked areas of the passages [m^2],
    (chunks, 2) of Passages.measure. start_volume [m^3] of all chambers. pattern, next_aim [s]: what the jets of each
    inflator fall on, and when that is looked for again, (inflators,); jet impulses [N s].
    """

    masses: np.ndarray
    energy: np.ndarray
    volume: np.ndarray
    pressure: np.ndarray
    temperature: np.ndarray
    is_open: np.ndarray
    passed: np.ndarray
    through: np.ndarray
    start_masses: np.ndarray
    books: np.ndarray
    sums: np.ndarray
    areas: np.ndarray
    start_volume: float
    pattern: tuple[JetPattern, ...] = field(metadata=VARYING)
    next_aim: np.ndarray
    jet_impulse_in: float = 0.0
    jet_impulse_out: float = 0.0

    @property
    def contents(self) -> tuple[np.ndarray, ...]:
        """The fields of `Contents`."""
        return self.masses, self.energy, self.volume, self.pressure, self.temperature

    @property
    def accounts(self) -> tuple[np.ndarray, ...]:
        """The fields of `Books`."""
        return self.passed, self.through, self.start_masses, self.books, self.sums


@dataclass(frozen=True)
class UniformPressure(GasModel):
    """Parameters of the gas: what it is supplied with."""

    supply: Supply
    looks_back: ClassVar[bool] = False

    @cached_property
    def _table(self) -> tuple:
        supply, given = self.supply, self.supply.heat_conductance
        conductance = np.zeros(supply.chambers.count) if given is None else given
        inflow = InflowTable.build(supply.inflators)
        return plain(SupplyTable(supply.table, inflow, supply.passages.table, supply.ambient, conductance))

    def start(self, bag: Bag) -> UniformState:
        """The initial gas in the start shape."""
        initial, table = self.supply.start_gas, self.supply.table
        volume = self.supply.chambers.volumes(bag.surface.triangles, bag.positions)
        masses = self.supply.start_amount(volume)[:, None] * initial.mass_fractions
        filled = zip(masses, initial.temperature, strict=True)
        energy = np.array([mixture_enthalpy(table, m, t) - mixture_gas_constant(table, m) * t for m, t in filled])
        pressure, temperature = initial.pressure.copy(), initial.temperature.copy()
        return self.holding(bag, masses, energy, volume, pressure, temperature, 0.0)

    def holding(
        self, bag: Bag, masses: np.ndarray, energy: np.ndarray, volume: np.ndarray, pressure: np.ndarray,
        temperature: np.ndarray, time: float,
    ) -> UniformState:  # fmt: skip
        """State at a time [s] with this gas in the bag and new books; arrays as in UniformState, which keeps them.

        What inflators delivered before is no gain of these books.
        """
        passages, sources = self.supply.passages, len(self.supply.sources)
        start_masses = masses - self.supply.delivered(time)
        books = np.zeros((len(volume), BOOKS))
        books[:, START_MASS], books[:, START_ENERGY] = start_masses.sum(axis=1), energy
        rows = len(passages.rows)
        state = UniformState(
            masses, energy, volume, pressure, temperature, np.zeros(rows, np.bool_), np.zeros((rows, 2)),
            np.zeros_like(masses), start_masses, books, np.zeros(len(SUMS)), self._areas(bag),
            float(volume.sum()), tuple(JetPattern.nothing() for _ in range(sources)), np.zeros(sources),
        )  # fmt: skip
        sum_up(Contents(*state.contents), passages.table.plan, Books(*state.accounts), np.zeros(rows))
        return state

    def advance(self, gas: UniformState, bag: Bag, time: float, dt: float, loads: Loads) -> None:
        jet_work = self._blow(gas, bag, time, dt, loads.node_force)
        areas, volumes = self._areas(bag), bag.volumes
        advance_chambers(
            self._table, gas.contents, gas.accounts, gas.is_open, jet_work, gas.areas, areas, volumes, loads.gauge,
            time, dt,
        )  # fmt: skip
        gas.areas = areas

    def _areas(self, bag: Bag) -> np.ndarray:
        return self.supply.passages.measure(bag.surface.triangles, bag.positions, bag.touched)

    def press(self, gas: UniformState, loads: Loads) -> None:
        """Let the pressure act."""
        np.subtract(gas.pressure, self.supply.ambient.pressure, out=loads.gauge[:-1])

    def _blow(self, gas: UniformState, bag: Bag, time: float, dt: float, node_force: np.ndarray) -> np.ndarray:
        """Add the jets' force; returns their work in this step [J], (chambers,): the mean force over the motion."""
        work = np.zeros(self.supply.chambers.count)
        for k, source in enumerate(self.supply.sources):
            if source.jets is not None and not source.diffuse:
                work[source.inflator.chamber] += self._blow_one(gas, k, source, bag, time, dt, node_force)
        return work

    def _blow_one(
        self, gas: UniformState, k: int, source: Source, bag: Bag, time: float, dt: float, node_force: np.ndarray
    ) -> float:
        jets, pattern, triangles, after = source.jets, gas.pattern[k], bag.surface.triangles, time + dt
        count, due = jets.ring.count, bool(after >= gas.next_aim[k])
        where = triangles, bag.positions, bag.velocities, jets.mouth_nodes, node_force
        thrust, last, power = blow(self._blown[k], count, after, due, pattern.for_kernels, *where)
        if not thrust:
            if len(pattern.force):
                vars(pattern).update(vars(JetPattern.nothing()))
            return 0.5 * last * dt
        if due:
            vars(pattern).update(vars(aim(jets, triangles, bag.positions, after)))
            gas.next_aim[k] = after + UPDATE_INTERVAL
            _, _, power = blow(self._blown[k], count, after, False, pattern.for_kernels, *where)
        gas.jet_impulse_in += count * thrust * dt
        gas.jet_impulse_out += pattern.seen * thrust * dt
        return 0.5 * (last + power) * dt

    @cached_property
    def _blown(self) -> list[tuple[np.ndarray, ...]]:
        """Of each inflator, what says how much and how hot."""
        return [
            (self.supply.table, i.mass_fractions, i.flow_time, i.mass_flow, i.temperature_time, i.temperature)
            for i in self.supply.inflators
        ]

    def vitals(self, gas: UniformState) -> Vitals:
        sums = gas.sums.tolist()
        volume = sums[VOLUME]
        work = sums[ALL_WORK] - self.supply.ambient.pressure * (volume - gas.start_volume) + sums[ALL_JET_WORK]
        volumes = [volume] if len(gas.volume) == 1 else gas.volume.tolist()
        return Vitals(work, sums[PRESSURE], sums[TEMPERATURE], sums[ENERGY], volumes)

    def totals(self, gas: UniformState) -> GasTotals:
        sums = dict(zip(SUMS, gas.sums.tolist(), strict=True))
        vented_by, leaked_by, passed = self.supply.outflow_by_name(gas.passed.tolist())
        single = self.supply.chambers.count == 1
        return GasTotals(
            **sums,
            mass_by_species=gas.masses[0].copy() if single else gas.masses.sum(axis=0),
            ambient_work=self.supply.ambient.pressure * (sums["volume"] - gas.start_volume),
            jet_impulse_in=gas.jet_impulse_in,
            jet_impulse_out=gas.jet_impulse_out,
            vented_by=vented_by,
            leaked_by=leaked_by,
            passed=passed,
            chambers=() if single else self._each(gas),
        )

    def _each(self, gas: UniformState) -> tuple[ChamberTotals, ...]:
        columns = (gas.pressure, gas.temperature, gas.volume, gas.masses.sum(axis=1), gas.energy)
        return tuple(map(ChamberTotals, self.supply.chambers.names, *(column.tolist() for column in columns)))

    def fields(self, gas: UniformState) -> dict[str, np.ndarray]:
        gauge, chambers = np.append(gas.pressure - self.supply.ambient.pressure, 0.0), self.supply.chambers
        return {"gauge_pressure": gauge[chambers.behind] - gauge[chambers.ahead]}
