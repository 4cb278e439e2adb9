"""One step of all chambers (docs/theory.md, Uniform pressure). What changes the state is what is added to the
books, which are checked against the state in every step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.supply.ambient import Ambient, heat_lost
from billow.parts.gas.supply.curve import CurveTable, curve_value
from billow.parts.gas.supply.inflator import InflowTable, delivered_mass
from billow.parts.gas.supply.mixture import mixture_cv, mixture_enthalpy, mixture_gas_constant, mixture_temperature
from billow.parts.gas.supply.passages import AHEAD, BEHIND, FABRIC, KIND, THROUGH_BLOCKED, PassageTable
from billow.parts.gas.uniform.exchange import (
    IMPLICIT,
    MIDPOINT,
    affordable,
    flows,
    half_way,
    lift,
    open_passages,
    reservoirs,
)

PRESSURE_ITERATIONS = 3

(
    INJECTED, RECEIVED, ENTHALPY_IN, ENTHALPY_OUT, EXCHANGED_IN, EXCHANGED_OUT, WORK, JET_WORK, HEAT, START_MASS,
    START_ENERGY,
) = range(11)  # fmt: skip
"""Columns of the books of a chamber (chambers, BOOKS): injected mass and mass received through passages [kg]; enthalpy
from inflators and surroundings, to the surroundings, from and to other chambers [J]; work, work of jets, heat lost [J];
mass and energy at the start [kg], [J]."""
BOOKS = 11

(
    PRESSURE, TEMPERATURE, VOLUME, ENERGY, ALL_INJECTED, VENTED, LEAKED, DRAWN_IN, ALL_IN, ALL_OUT, ALL_WORK,
    ALL_JET_WORK, ALL_HEAT, BLOCKED_AREA, MASS_ERROR, ENERGY_ERROR,
) = range(16)  # fmt: skip
SUMS = (
    "pressure", "temperature", "volume", "energy", "injected", "vented", "leaked", "drawn_in", "enthalpy_in",
    "enthalpy_out", "work", "jet_work", "heat_lost", "blocked_area", "mass_error", "energy_error",
)  # fmt: skip
"""Entries of the sums over all chambers (sums,), and their names in GasTotals."""

SUMMED = (
    (ALL_INJECTED, INJECTED), (ALL_IN, ENTHALPY_IN), (ALL_OUT, ENTHALPY_OUT), (ALL_WORK, WORK),
    (ALL_JET_WORK, JET_WORK), (ALL_HEAT, HEAT),
)  # fmt: skip
"""Sums that add up a column of the books over the chambers: (entry, column)."""


class SupplyTable(NamedTuple):
    """What never changes: the thermo table (species, 16), inflators, passages, the air outside, and the heat transfer
    coefficient times the outer area of each chamber [W/K], (chambers,)."""

    table: np.ndarray
    inflow: InflowTable
    passages: PassageTable
    ambient: Ambient
    heat_conductance: np.ndarray


class Contents(NamedTuple):
    """The gas in the chambers: masses [kg] (chambers, species); energy [J], volume [m^3], pressure [Pa] absolute,
    temperature [K], (chambers,)."""

    masses: np.ndarray
    energy: np.ndarray
    volume: np.ndarray
    pressure: np.ndarray
    temperature: np.ndarray


class Books(NamedTuple):
    """What went in and out since the start.

    passed: (passages, 2), mass [kg] that went from behind to ahead and back. through: (chambers, species), mass [kg]
    gained through passages. start_masses: [kg] (chambers, species). chambers: (chambers, BOOKS). sums: as SUMS.
    """

    passed: np.ndarray
    through: np.ndarray
    start_masses: np.ndarray
    chambers: np.ndarray
    sums: np.ndarray


def plain(group: tuple) -> tuple:
    """A NamedTuple of arrays and NamedTuples as plain tuples, whose type numba finds three times as fast."""
    return tuple(plain(item) if isinstance(item, tuple) else item for item in group)


@scalar
def advance_chambers(supply, contents, accounts, is_open, jet_work, areas_before, areas, volume, gauge_out, time, dt):
    """From `time` to `time + dt` [s]. Changes the contents, the accounts and is_open (passages,) bool; gauge_out: the
    pressures above ambient [Pa] after it, of `Loads`.

    supply, contents, accounts: `plain` tuples of SupplyTable, Contents and Books. jet_work [J] and volume [m^3] at the
    end of the step: (chambers,). areas_before, areas: at the start and at the end of the step, (chunks, 2) of
    Passages.measure.
    """
    table, inflow, passages, ambient, heat_conductance = supply
    inflow = InflowTable(CurveTable(*inflow[0]), inflow[1], CurveTable(*inflow[2]), inflow[3], inflow[4])
    passages = PassageTable(passages[0], passages[1], CurveTable(*passages[2]), passages[3])
    ambient, gas, books = Ambient(*ambient), Contents(*contents), Books(*accounts)
    masses, energy, volume_old, pressure, temperature = contents
    chambers, each, plan = len(volume), books.chambers, passages.plan
    old = reservoirs(table, masses, pressure, temperature, ambient)
    expected, cooled = np.empty(chambers + 1), np.empty(chambers)
    for c in range(chambers):
        capacity = old.mass[c] * mixture_cv(table, old.fraction[c], temperature[c])
        heat = heat_lost(capacity, temperature[c] - ambient.temperature, heat_conductance[c], dt)
        cooled[c] = heat / capacity
        expected[c] = pressure[c] * (volume_old[c] / volume[c]) ** old.gamma[c]
        expected[c] -= (old.gamma[c] - 1.0) * (heat + jet_work[c]) / volume[c]
    _inject(table, masses, energy, each, inflow, old, expected, volume, time, dt)
    # Flows of first order, by the gas as it is at the start, lead half-way through the step; the gas there gives the
    # flows of second order, with its composition and enthalpy.
    flow, first, passed_areas = np.empty(len(plan)), np.empty(len(plan)), np.empty((len(plan), 2))
    blocked, donors, middle = np.empty(len(plan)), old, time + 0.5 * dt
    _sum_areas(passages, areas_before, areas, passed_areas, blocked)
    open_passages(passages, is_open, old.pressure, time, dt)
    start, mass, alone = old.pressure, old.mass, expected[:chambers].copy()
    flows(passages, is_open, passed_areas, old, start, mass, alone, volume, middle, dt, IMPLICIT, first, expected)
    half = half_way(table, plan, old, masses, first, alone, volume_old, volume, ambient)
    flows(passages, is_open, passed_areas, half, start, mass, alone, volume, middle, dt, MIDPOINT, flow, expected)
    if affordable(plan, flow, half, old, masses):
        donors = half
    else:
        flow = first
    for c in range(chambers):
        warmer = half.temperature[c] + 0.5 * cooled[c] - ambient.temperature  # without the heat lost in this step
        capacity = half.mass[c] * mixture_cv(table, half.fraction[c], half.temperature[c])
        heat = heat_lost(capacity, warmer, heat_conductance[c], dt)
        energy[c] -= heat
        each[c, HEAT] += heat
    _exchange(gas, books, plan, donors, flow)
    for c in range(chambers):
        gas_constant = mixture_gas_constant(table, masses[c])
        heated = energy[c] - jet_work[c]
        p, work = expected[c], 0.0
        t = p * volume[c] / gas_constant if p > 0.0 else temperature[c]
        for _ in range(PRESSURE_ITERATIONS):
            work = 0.5 * (pressure[c] + p) * (volume[c] - volume_old[c])
            t = mixture_temperature(table, masses[c], heated - work, t)
            p = gas_constant * t / volume[c]
        energy[c] = heated - work
        temperature[c], pressure[c], volume_old[c], gauge_out[c] = t, p, volume[c], p - ambient.pressure
        each[c, WORK] += work
        each[c, JET_WORK] += jet_work[c]
    sum_up(gas, plan, books, blocked)
    delivered = np.zeros_like(masses)
    for k in range(len(inflow.chamber)):
        total = _delivered(inflow, k, time + dt)
        for i in range(delivered.shape[1]):
            delivered[inflow.chamber[k], i] += total * inflow.mass_fractions[k, i]
    _close_books(gas, books, delivered)


@scalar
def _sum_areas(passages, before, after, passed_out, blocked_out):
    """Present and blocked area [m^2] of each passage, means over a step, (passages, 2); the blocked one at its end, of
    those on which contact has an effect, (passages,). before, after: (chunks, 2)."""
    first_chunk = passages.first_chunk
    for k in range(len(passages.plan)):
        passed_out[k, 0], passed_out[k, 1], blocked_out[k] = 0.0, 0.0, 0.0
        for chunk in range(first_chunk[k], first_chunk[k + 1]):
            passed_out[k, 0] += 0.5 * (before[chunk, 0] + after[chunk, 0])
            passed_out[k, 1] += 0.5 * (before[chunk, 1] + after[chunk, 1])
            if passages.numbers[k, THROUGH_BLOCKED] < 1.0:
                blocked_out[k] += after[chunk, 1]


@scalar
def _delivered(inflow, k, time):
    """Mass [kg] that inflator k has delivered up to time [s]."""
    flow = inflow.flow
    first, end = flow.start[k], flow.start[k + 1]
    return delivered_mass(flow.x[first:end], flow.y[first:end], inflow.cumulative[first:end], time)


@scalar
def _inject(table, masses, energy, each, inflow, old, expected, volume, time, dt):
    """Add what the inflators deliver from `time` to `time + dt` [s], also to the expected pressure [Pa]. old:
    Reservoirs at the start."""
    for k in range(len(inflow.chamber)):
        c, fractions = inflow.chamber[k], inflow.mass_fractions[k]
        injected = _delivered(inflow, k, time + dt) - _delivered(inflow, k, time)
        t = curve_value(inflow.temperature, k, time + 0.5 * dt)
        enthalpy = mixture_enthalpy(table, fractions, t)
        gained = injected * enthalpy
        expected[c] += injected * lift(table, fractions, enthalpy, old.gamma[c], old.temperature[c]) / volume[c]
        energy[c] += gained
        each[c, ENTHALPY_IN] += gained
        each[c, INJECTED] += injected
        for i in range(len(fractions)):
            masses[c, i] += injected * fractions[i]


@scalar
def _exchange(gas, books, plan, donors, flow):
    """Move the flow [kg] (passages,) of each passage, with composition and enthalpy of where it comes from. donors:
    Reservoirs."""
    masses, energy, each, through, fraction = gas.masses, gas.energy, books.chambers, books.through, donors.fraction
    chambers, species = masses.shape
    outside = chambers
    for k in range(len(plan)):
        b, a = plan[k, BEHIND] % (chambers + 1), plan[k, AHEAD] % (chambers + 1)  # OUTSIDE, -1, is the last row
        up, down = (b, a) if flow[k] > 0.0 else (a, b)
        moved = abs(flow[k])
        carried = moved * donors.enthalpy[up]
        books.passed[k, 0 if flow[k] > 0.0 else 1] += moved
        if up != outside:
            energy[up] -= carried
            each[up, ENTHALPY_OUT if down == outside else EXCHANGED_OUT] += carried
        if down != outside:
            energy[down] += carried
            each[down, RECEIVED] += moved
            each[down, ENTHALPY_IN if up == outside else EXCHANGED_IN] += carried
        for i in range(species):
            if up != outside:
                masses[up, i] -= moved * fraction[up, i]
                through[up, i] -= moved * fraction[up, i]
            if down != outside:
                masses[down, i] += moved * fraction[up, i]
                through[down, i] += moved * fraction[up, i]


@scalar
def sum_up(gas, plan, books, blocked):
    """Sums over all chambers; the pressure is the mean over volume, the temperature the mean over mass.

    plan: of the PassageTable. blocked: blocked area [m^2] of each passage, (passages,).
    """
    masses, energy, volume, pressure, temperature = gas
    passed, each, sums = books.passed, books.chambers, books.sums
    chambers, species = masses.shape
    for k in range(MASS_ERROR):
        sums[k] = 0.0
    mass = 0.0
    for c in range(chambers):
        for i in range(species):
            mass += masses[c, i]
        sums[VOLUME] += volume[c]
        sums[ENERGY] += energy[c]
        for entry, column in SUMMED:
            sums[entry] += each[c, column]
    sums[PRESSURE], sums[TEMPERATURE] = pressure[0], temperature[0]
    for c in range(1, chambers):
        sums[PRESSURE] += (pressure[c] - pressure[0]) * volume[c] / sums[VOLUME]
        for i in range(species):
            sums[TEMPERATURE] += (temperature[c] - temperature[0]) * masses[c, i] / mass
    for k in range(len(plan)):
        sums[BLOCKED_AREA] += blocked[k]
        out, back = (0, 1) if plan[k, AHEAD] < 0 else (1, 0)
        if plan[k, AHEAD] < 0 or plan[k, BEHIND] < 0:
            sums[LEAKED if plan[k, KIND] == FABRIC else VENTED] += passed[k, out]
            sums[DRAWN_IN] += passed[k, back]


@scalar
def _close_books(gas, books, delivered):
    """Check the books of every chamber, and of all together, against the state; keep the largest relative errors.

    Mass is checked species by species, against the closed form of the inflators' curves, delivered [kg] (chambers,
    species).
    """
    masses, energy, start_masses, through = gas.masses, gas.energy, books.start_masses, books.through
    each, sums = books.chambers, books.sums
    chambers, species = masses.shape
    whole, scale = 0.0, 0.0
    for c in range(chambers):
        book = each[c]
        size = book[START_MASS] + book[RECEIVED]
        for i in range(species):
            size += delivered[c, i]
        for i in range(species):
            gap = masses[c, i] - start_masses[c, i] - delivered[c, i] - through[c, i]
            sums[MASS_ERROR] = max(sums[MASS_ERROR], abs(gap) / size)
        gap = energy[c] - book[START_ENERGY] - book[ENTHALPY_IN] - book[EXCHANGED_IN] + book[ENTHALPY_OUT]
        gap += book[EXCHANGED_OUT] + book[WORK] + book[JET_WORK] + book[HEAT]
        size = book[START_ENERGY] + book[ENTHALPY_IN] + book[EXCHANGED_IN]
        sums[ENERGY_ERROR] = max(sums[ENERGY_ERROR], abs(gap) / size)
    mass = 0.0
    for c in range(chambers):
        whole += each[c, START_MASS]
        scale += each[c, START_ENERGY]
        for i in range(species):
            whole += delivered[c, i]
            mass += masses[c, i]
    gap = mass - whole - sums[DRAWN_IN] + sums[VENTED] + sums[LEAKED]
    sums[MASS_ERROR] = max(sums[MASS_ERROR], abs(gap) / (whole + sums[DRAWN_IN]))
    gap = sums[ENERGY] - scale - sums[ALL_IN] + sums[ALL_OUT] + sums[ALL_WORK] + sums[ALL_JET_WORK] + sums[ALL_HEAT]
    sums[ENERGY_ERROR] = max(sums[ENERGY_ERROR], abs(gap) / (scale + sums[ALL_IN]))
