"""How much gas goes through each passage within a step (docs/theory.md, Stiff exchange). New pressures only serve to
find the flows: the state follows from the books."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gamma, mixture_gas_constant
from billow.parts.gas.supply.outflow import conductance
from billow.parts.gas.supply.passages import AHEAD, BEHIND, BURSTS_AT, LAW, OPENS_AT, effective_area

LARGEST_SHARE = 0.5
"""Largest share of a chamber's mass that may leave within one step, so that no mass turns negative."""

IMPLICIT, MIDPOINT = 0.0, 0.5
"""Largest weight of the pressures at the start of a step in the difference that drives a flow: none, first order in the
step, or as much as those at its end, second order."""

MOST_TRIES = 8
"""Times that the flows of a step are found, while gas goes another way than was thought, or more than there is."""

LEAST_PRESSURE = 0.1
"""Least pressure half-way through a step, of that at its start, where a step is far too long for its gas."""


class Reservoirs(NamedTuple):
    """The gas that may flow: each chamber's and, in the last row, the air outside.

    fraction: of each species by mass (chambers + 1, species); pressure [Pa], temperature [K], gamma = cp/cv [-], rt =
    R T [J/kg] and enthalpy [J/kg], (chambers + 1,); mass [kg], (chambers + 1,), zero for the air outside.
    """

    fraction: np.ndarray
    pressure: np.ndarray
    temperature: np.ndarray
    gamma: np.ndarray
    rt: np.ndarray
    enthalpy: np.ndarray
    mass: np.ndarray


@scalar
def reservoirs(table, masses, chamber_pressure, chamber_temperature, ambient):
    """The Reservoirs of chambers that hold `masses` [kg] (chambers, species), and of the Ambient."""
    chambers, species = masses.shape
    fraction, of = np.empty((chambers + 1, species)), np.zeros((6, chambers + 1))
    pressure, temperature, gamma, rt, enthalpy, mass = of[0], of[1], of[2], of[3], of[4], of[5]
    for c in range(chambers + 1):
        pressure[c], t = ambient.pressure, ambient.temperature
        if c < chambers:
            pressure[c], t = chamber_pressure[c], chamber_temperature[c]
            for i in range(species):
                mass[c] += masses[c, i]
        for i in range(species):
            fraction[c, i] = masses[c, i] / mass[c] if c < chambers else ambient.mass_fractions[i]
        temperature[c] = t
        gamma[c], rt[c] = mixture_gamma(table, fraction[c], t), mixture_gas_constant(table, fraction[c]) * t
        enthalpy[c] = mixture_enthalpy(table, fraction[c], t)
    return Reservoirs(fraction, pressure, temperature, gamma, rt, enthalpy, mass)


@scalar
def lift(table, fraction, enthalpy, gamma, temperature):
    """Pressure times volume [J/kg] that a chamber gains by gas of this enthalpy [J/kg] and composition, per mass of it.

    gamma, temperature [K]: of the chamber. Of the energy that came, the new gas needs its part at this temperature, and
    what is left warms all of the gas. For the chamber's own gas it is gamma R T.
    """
    rt = mixture_gas_constant(table, fraction) * temperature
    return rt + (gamma - 1.0) * (enthalpy - mixture_enthalpy(table, fraction, temperature) + rt)


@scalar
def open_passages(passages, is_open, pressure, time, dt):
    """Open what opens by the pressures [Pa] (chambers + 1,) at `time` [s], or bursts in the step, in is_open."""
    plan, numbers, outside = passages.plan, passages.numbers, len(pressure) - 1
    for k in range(len(plan)):
        b, a = plan[k, BEHIND] % (outside + 1), plan[k, AHEAD] % (outside + 1)  # OUTSIDE, -1, is the last entry
        if pressure[b] - pressure[a] >= numbers[k, OPENS_AT] or time + dt >= numbers[k, BURSTS_AT]:
            is_open[k] = True


@scalar
def flows(passages, is_open, areas, at, start, mass, expected, volume, time, dt, explicit, flow_out, pressure_out):
    """Mass [kg] that goes through each passage from behind to ahead within a step, into flow_out (passages,), and the
    pressures [Pa] at its end, into pressure_out (chambers + 1,).

    passages: PassageTable. areas: present and blocked area [m^2] of each passage, (passages, 2). at: Reservoirs by
    which the flow laws are read. start: pressures [Pa], and mass [kg], at the start, (chambers + 1,). expected: p* [Pa]
    and volume [m^3] at the end of the step, (chambers,). time: its middle [s]. explicit: IMPLICIT or MIDPOINT.
    """
    chambers, plan, pressure = len(volume), passages.plan, at.pressure
    doors, passes, back = np.zeros(chambers + 1), np.zeros(len(plan)), np.zeros(len(plan), np.bool_)
    for k in range(len(plan)):
        if is_open[k]:
            b, a = plan[k, BEHIND] % (chambers + 1), plan[k, AHEAD] % (chambers + 1)  # OUTSIDE, -1, is the last entry
            back[k] = pressure[b] < pressure[a]
            up, down = (a, b) if back[k] else (b, a)
            area = effective_area(passages, k, areas[k, 0], areas[k, 1], time, pressure[b], pressure[a])
            passes[k] = dt * area * conductance(plan[k, LAW], pressure[up], pressure[down], at.gamma[up], at.rt[up])
            doors[b] += 1.0
            doors[a] += 1.0
    doors[chambers] = 0.0
    held = np.zeros(len(plan), np.bool_)
    for _ in range(MOST_TRIES):
        _new_pressures(plan, at, start, expected, volume, passes, back, held, doors, explicit, flow_out, pressure_out)
        again = False
        for k in range(len(plan)):
            if not held[k] and flow_out[k] != 0.0 and (flow_out[k] < 0.0) != back[k]:
                back[k], again = not back[k], True
        if not again and not hold_back(plan, mass, flow_out, held):
            return
    while hold_back(plan, mass, flow_out, held):  # of flows that do not settle
        pass


@scalar
def _new_pressures(plan, at, start, expected, volume, passes, back, held, doors, explicit, flow_out, pressure_out):
    """flow_out and pressure_out of `flows`.

    passes: mass per pressure difference [kg/Pa], back: whether gas comes from ahead, and held: whether flow_out says
    what flows already, (passages,). doors: open passages of each chamber, none outside, (chambers + 1,).
    """
    chambers, gamma, rt, new = len(volume), at.gamma, at.rt, pressure_out
    matrix, early = np.zeros((chambers, chambers)), np.zeros(len(plan))
    for c in range(chambers):
        matrix[c, c], new[c] = 1.0, expected[c]
    new[chambers] = start[chambers]
    for k in range(len(plan)):
        b, a = plan[k, BEHIND] % (chambers + 1), plan[k, AHEAD] % (chambers + 1)
        warmth = (flow_out[k] if held[k] else passes[k]) * (rt[a] if back[k] else rt[b])
        if warmth == 0.0:
            continue
        lost = gamma[b] * warmth / volume[b] if b < chambers else 0.0
        gained = gamma[a] * warmth / volume[a] if a < chambers else 0.0
        if held[k]:
            new[b] -= lost
            new[a] += gained
            continue
        # Each passage has an equal part of what may come from the start without that any pressure overshoots.
        early[k] = min(explicit, 1.0 / (max(doors[b], doors[a]) * (lost + gained)))
        if b < chambers:
            _add_flow(matrix, new, b, a, lost, early[k], start)
        if a < chambers:
            _add_flow(matrix, new, a, b, gained, early[k], start)
    _solve(matrix, new)
    for k in range(len(plan)):
        b, a = plan[k, BEHIND] % (chambers + 1), plan[k, AHEAD] % (chambers + 1)
        if not held[k]:
            flow_out[k] = passes[k] * ((1.0 - early[k]) * (new[b] - new[a]) + early[k] * (start[b] - start[a]))


@scalar
def _add_flow(matrix, right, here, other, response, early, start):
    """Add a passage to `other` to the row of chamber `here`; response: pressure lost per pressure difference [-]."""
    chambers, late = len(matrix), (1.0 - early) * response
    right[here] += early * response * (start[other] - start[here])
    matrix[here, here] += late
    if other < chambers:
        matrix[here, other] -= late
    else:
        right[here] += late * right[other]


@scalar
def _solve(matrix, right):
    """Gaussian elimination in place; the matrix is strictly diagonally dominant, so no pivots are needed."""
    n = len(matrix)
    for k in range(n):
        for i in range(k + 1, n):
            if matrix[i, k] != 0.0:
                share = matrix[i, k] / matrix[k, k]
                for j in range(k, n):
                    matrix[i, j] -= share * matrix[k, j]
                right[i] -= share * right[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]


@scalar
def leaving(plan, flow, chambers):
    """Mass [kg] that the flow [kg] (passages,) takes from each chamber and from outside, (chambers + 1,)."""
    total = np.zeros(chambers + 1)
    for k in range(len(plan)):
        total[plan[k, BEHIND if flow[k] > 0.0 else AHEAD] % (chambers + 1)] += abs(flow[k])
    return total


@scalar
def hold_back(plan, mass, flow, held):
    """Whether a chamber would lose more than LARGEST_SHARE of its mass [kg], (chambers + 1,). If so, reduce the flow
    [kg] (passages,) out of the one that lacks most to that share, and note it in held (passages,) bool."""
    outside = len(mass) - 1
    gone, worst, share = leaving(plan, flow, outside), -1, (1.0 + 1e-12) * LARGEST_SHARE
    for c in range(outside):
        if gone[c] > share * mass[c]:
            worst, share = c, gone[c] / mass[c]
    if worst >= 0:
        for k in range(len(plan)):
            if plan[k, BEHIND if flow[k] > 0.0 else AHEAD] == worst:
                flow[k] *= LARGEST_SHARE / share
                held[k] = True
    return worst >= 0


@scalar
def half_way(table, plan, old, masses, flow, expected, volume_old, volume, ambient):
    """The Reservoirs half-way through a step with these flows [kg] (passages,), within the second order of the step.

    old: Reservoirs at the start. masses: [kg] (chambers, species), injection added. expected: p* [Pa] (chambers,);
    corrected for gas that is not like that of the chamber it comes to, of which `flows` knows nothing.
    """
    chambers, species = masses.shape
    after, middle, warm = masses.copy(), np.empty(chambers), np.empty(chambers)
    for c in range(chambers):
        middle[c] = expected[c]
    for k in range(len(plan)):
        b, a = plan[k, BEHIND] % (chambers + 1), plan[k, AHEAD] % (chambers + 1)
        up, down = (b, a) if flow[k] > 0.0 else (a, b)
        moved, fraction = abs(flow[k]), old.fraction[up]
        if up < chambers:
            middle[up] -= moved * old.gamma[up] * old.rt[up] / volume[up]
            for i in range(species):
                after[up, i] -= moved * fraction[i]
        if down < chambers:
            lifted = lift(table, fraction, old.enthalpy[up], old.gamma[down], old.temperature[down])
            middle[down] += moved * lifted / volume[down]
            expected[down] += moved * (lifted - old.gamma[down] * old.rt[up]) / volume[down]
            for i in range(species):
                after[down, i] += moved * fraction[i]
    for c in range(chambers):
        middle[c] = max(0.5 * (old.pressure[c] + middle[c]), LEAST_PRESSURE * old.pressure[c])
        for i in range(species):
            after[c, i] = 0.5 * (old.fraction[c, i] * old.mass[c] + after[c, i])
        warm[c] = 0.5 * middle[c] * (volume_old[c] + volume[c]) / mixture_gas_constant(table, after[c])
    return reservoirs(table, after, middle, warm, ambient)


@scalar
def affordable(plan, flow, donors, old, masses):
    """Whether every chamber can give the flow [kg] (passages,) with the composition and enthalpy of the donors.

    None may lose more of a species or of enthalpy than LARGEST_SHARE of its mass takes along at the start. old:
    Reservoirs at the start. masses: [kg] (chambers, species), injection added.
    """
    chambers, species = masses.shape
    gone = leaving(plan, flow, chambers)
    for c in range(chambers):
        if gone[c] > LARGEST_SHARE * old.mass[c]:
            return False
        if gone[c] * donors.enthalpy[c] > LARGEST_SHARE * old.mass[c] * old.enthalpy[c]:
            return False
        for i in range(species):
            if gone[c] * donors.fraction[c, i] > LARGEST_SHARE * masses[c, i]:
                return False
    return True
