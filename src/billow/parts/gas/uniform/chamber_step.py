"""One step of all chambers: inflow, exchange, heat, work, and the books of every one of them.

Rates from the old state; work W = (p_old + p_new)/2 dV with p_new found by iteration; U_new = U + H_in - H_out - W -
W_jets - Q; temperature from U, pressure from p V = T sum(m_i R_i). The numbers that change the state are the numbers
that are added to the books, and the books are held against the state in every step.
"""

from __future__ import annotations

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.supply.curve import interpolate
from billow.parts.gas.supply.heat_loss import heat_lost
from billow.parts.gas.supply.inflator import delivered_mass
from billow.parts.gas.supply.mixture import mixture_cp, mixture_enthalpy, mixture_gas_constant, mixture_temperature
from billow.parts.gas.supply.passages import AHEAD, BEHIND, FABRIC, KIND
from billow.parts.gas.uniform.exchange import flows

PRESSURE_ITERATIONS = 3

(
    INJECTED,
    RECEIVED,
    ENTHALPY_IN,
    ENTHALPY_OUT,
    EXCHANGED_IN,
    EXCHANGED_OUT,
    WORK,
    JET_WORK,
    HEAT,
    START_MASS,
    START_ENERGY,
) = range(11)
"""Columns of the books of a chamber (chambers, BOOKS): injected mass and mass received through passages [kg]; enthalpy
from inflators and surroundings, to the surroundings, from and to other chambers [J]; work, work of jets, heat lost [J];
mass and energy at the start [kg], [J]."""
BOOKS = 11

(
    PRESSURE, TEMPERATURE, VOLUME, ENERGY, ALL_INJECTED, VENTED, LEAKED, DRAWN_IN, ALL_IN, ALL_OUT, ALL_WORK,
    ALL_JET_WORK, ALL_HEAT, BLOCKED_AREA, MASS_ERROR, ENERGY_ERROR,
) = range(16)  # fmt: skip
"""Entries of the sums over all chambers (SUMS,), units as in GasTotals."""
SUMS = 16

SUMMED = (
    (ALL_INJECTED, INJECTED), (ALL_IN, ENTHALPY_IN), (ALL_OUT, ENTHALPY_OUT), (ALL_WORK, WORK),
    (ALL_JET_WORK, JET_WORK), (ALL_HEAT, HEAT),
)  # fmt: skip
"""Entries of the sums that are columns of the books added up."""


@scalar
def advance_chambers(
    table, masses, energy, volume_old, pressure, temperature, volume, time, dt, jet_work, heat_conductance,
    flow_start, flow_time, mass_flow, cumulative, heat_start, heat_time, inflow_heat, inflow_fractions, inflow_chamber,
    ambient_pressure, ambient_temperature, ambient_fractions,
    plan, numbers, curve_start, curve_x, curve_y, first_chunk, areas, is_open, passed, through, start_masses, books,
    sums,
):  # fmt: skip
    """From `time` to `time + dt` [s]; volume: at the end of the step [m^3], (chambers,).

    Changes the state (masses, energy, volume_old, pressure, temperature, is_open) and the books: passed (passages, 2),
    mass [kg] that went from behind to ahead and back; through (chambers, species), mass [kg] gained by passages; books;
    sums. inflow_heat: temperature curves of the inflators [K].
    """
    chambers, species = masses.shape
    outside = chambers
    # The old state of whatever may flow: the chambers, and in the last row the surroundings.
    fraction = np.empty((chambers + 1, species))
    mass, p, gamma = np.empty(chambers), np.empty(chambers + 1), np.empty(chambers + 1)
    rt, enthalpy = np.empty(chambers + 1), np.empty(chambers + 1)
    expected = np.empty(chambers)
    for c in range(chambers + 1):
        if c < chambers:
            mass[c] = 0.0
            for i in range(species):
                mass[c] += masses[c, i]
            for i in range(species):
                fraction[c, i] = masses[c, i] / mass[c]
            p[c], t = pressure[c], temperature[c]
        else:
            for i in range(species):
                fraction[c, i] = ambient_fractions[i]
            p[c], t = ambient_pressure, ambient_temperature
        gas_constant, cp = mixture_gas_constant(table, fraction[c]), mixture_cp(table, fraction[c], t)
        gamma[c], rt[c] = cp / (cp - gas_constant), gas_constant * t
        enthalpy[c] = mixture_enthalpy(table, fraction[c], t)
        if c < chambers:
            expected[c] = p[c] * (volume_old[c] / volume[c]) ** gamma[c]
            heat = heat_lost(mass[c] * (cp - gas_constant), t - ambient_temperature, heat_conductance[c], dt)
            energy[c] -= heat
            books[c, HEAT] += heat

    for k in range(len(inflow_chamber)):
        c, first, end = inflow_chamber[k], flow_start[k], flow_start[k + 1]
        delivered = cumulative[first:end]
        injected = delivered_mass(flow_time[first:end], mass_flow[first:end], delivered, time + dt)
        injected -= delivered_mass(flow_time[first:end], mass_flow[first:end], delivered, time)
        first, end = heat_start[k], heat_start[k + 1]
        t = interpolate(heat_time[first:end], inflow_heat[first:end], time + 0.5 * dt)
        gained = injected * mixture_enthalpy(table, inflow_fractions[k], t)
        expected[c] += gamma[c] * injected * mixture_gas_constant(table, inflow_fractions[k]) * t / volume[c]
        energy[c] += gained
        books[c, ENTHALPY_IN] += gained
        books[c, INJECTED] += injected
        for i in range(species):
            masses[c, i] += injected * inflow_fractions[k, i]

    flow, blocked = np.empty(len(plan)), np.empty(len(plan))
    flows(
        plan, numbers, curve_start, curve_x, curve_y, first_chunk, areas, is_open, p, gamma, rt, mass, volume, expected,
        time + 0.5 * dt, dt, blocked, flow,
    )  # fmt: skip
    for k in range(len(plan)):
        b, a = plan[k, BEHIND] % (chambers + 1), plan[k, AHEAD] % (chambers + 1)  # OUTSIDE, -1, is the last row
        up, down = (b, a) if flow[k] > 0.0 else (a, b)
        moved = abs(flow[k])
        carried = moved * enthalpy[up]
        passed[k, 0 if flow[k] > 0.0 else 1] += moved
        if up != outside:
            energy[up] -= carried
            books[up, ENTHALPY_OUT if down == outside else EXCHANGED_OUT] += carried
        if down != outside:
            energy[down] += carried
            books[down, RECEIVED] += moved
            books[down, ENTHALPY_IN if up == outside else EXCHANGED_IN] += carried
        for i in range(species):
            if up != outside:
                masses[up, i] -= moved * fraction[up, i]
                through[up, i] -= moved * fraction[up, i]
            if down != outside:
                masses[down, i] += moved * fraction[up, i]
                through[down, i] += moved * fraction[up, i]

    for c in range(chambers):
        new_constant = mixture_gas_constant(table, masses[c])
        heated = energy[c] - jet_work[c]
        new_pressure, new_temperature, work = expected[c], temperature[c], 0.0
        for _ in range(PRESSURE_ITERATIONS):
            work = 0.5 * (p[c] + new_pressure) * (volume[c] - volume_old[c])
            new_temperature = mixture_temperature(table, masses[c], heated - work, new_temperature)
            new_pressure = new_constant * new_temperature / volume[c]
        energy[c] = heated - work
        temperature[c], pressure[c], volume_old[c] = new_temperature, new_pressure, volume[c]
        books[c, WORK] += work
        books[c, JET_WORK] += jet_work[c]

    all_delivered = np.zeros((chambers, species))
    for k in range(len(inflow_chamber)):
        first, end = flow_start[k], flow_start[k + 1]
        total = delivered_mass(flow_time[first:end], mass_flow[first:end], cumulative[first:end], time + dt)
        for i in range(species):
            all_delivered[inflow_chamber[k], i] += total * inflow_fractions[k, i]
    sum_up(masses, energy, volume, pressure, temperature, plan, passed, books, blocked, sums)
    close_books(masses, energy, start_masses, all_delivered, through, books, sums)


@scalar
def sum_up(masses, energy, volume, pressure, temperature, plan, passed, books, blocked, sums):
    """Sums over all chambers; the pressure is the mean over volume, the temperature the mean over mass."""
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
            sums[entry] += books[c, column]
    sums[PRESSURE], sums[TEMPERATURE] = pressure[0], temperature[0]
    for c in range(1, chambers):
        sums[PRESSURE] += (pressure[c] - pressure[0]) * volume[c] / sums[VOLUME]
        for i in range(species):
            sums[TEMPERATURE] += (temperature[c] - temperature[0]) * masses[c, i] / mass
    for k in range(len(plan)):
        sums[BLOCKED_AREA] += blocked[k]
    for k in range(len(plan)):
        out, back = (0, 1) if plan[k, AHEAD] < 0 else (1, 0)
        if plan[k, AHEAD] < 0 or plan[k, BEHIND] < 0:
            sums[LEAKED if plan[k, KIND] == FABRIC else VENTED] += passed[k, out]
            sums[DRAWN_IN] += passed[k, back]


@scalar
def close_books(masses, energy, start_masses, delivered, through, books, sums):
    """Every chamber's books against its state, and all of them together; keeps the largest relative error.

    Mass is checked species by species, against the closed form of the inflators' curves (delivered: (chambers, species)
    [kg]).
    """
    chambers, species = masses.shape
    whole, scale = 0.0, 0.0
    for c in range(chambers):
        book = books[c]
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
        whole += books[c, START_MASS]
        scale += books[c, START_ENERGY]
        for i in range(species):
            whole += delivered[c, i]
            mass += masses[c, i]
    gap = mass - whole - sums[DRAWN_IN] + sums[VENTED] + sums[LEAKED]
    sums[MASS_ERROR] = max(sums[MASS_ERROR], abs(gap) / (whole + sums[DRAWN_IN]))
    gap = sums[ENERGY] - scale - sums[ALL_IN] + sums[ALL_OUT] + sums[ALL_WORK] + sums[ALL_JET_WORK] + sums[ALL_HEAT]
    sums[ENERGY_ERROR] = max(sums[ENERGY_ERROR], abs(gap) / (scale + sums[ALL_IN]))
