"""How much gas goes through each passage within a step: all from the same old state (docs/theory.md, Stiff
exchange). The new pressures only serve to find the flows: the state follows from the books."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gamma, mixture_gas_constant
from billow.parts.gas.supply.outflow import conductance
from billow.parts.gas.supply.passages import AHEAD, BEHIND, BURSTS_AT, LAW, OPENS_AT, THROUGH_BLOCKED, effective_area

LARGEST_SHARE = 0.5
"""Largest share of a chamber's mass that may leave within one step, so that no mass turns negative."""


class Reservoirs(NamedTuple):
    """The gas that may flow in a step, as it is at the start: each chamber's and, in the last row, the air outside.

    fraction: of each species by mass (chambers + 1, species); pressure [Pa], gamma = cp/cv [-], rt = R T [J/kg] and
    enthalpy [J/kg], (chambers + 1,); mass [kg], (chambers + 1,), zero for the air outside.
    """

    fraction: np.ndarray
    pressure: np.ndarray
    gamma: np.ndarray
    rt: np.ndarray
    enthalpy: np.ndarray
    mass: np.ndarray


@scalar
def reservoirs(table, gas, ambient):
    """The Reservoirs of the Contents of all chambers and of the Ambient."""
    masses = gas.masses
    chambers, species = masses.shape
    fraction, mass, pressure = np.empty((chambers + 1, species)), np.zeros(chambers + 1), np.empty(chambers + 1)
    gamma, rt, enthalpy = np.empty(chambers + 1), np.empty(chambers + 1), np.empty(chambers + 1)
    for c in range(chambers + 1):
        pressure[c], t = ambient.pressure, ambient.temperature
        if c < chambers:
            pressure[c], t = gas.pressure[c], gas.temperature[c]
            for i in range(species):
                mass[c] += masses[c, i]
        for i in range(species):
            fraction[c, i] = masses[c, i] / mass[c] if c < chambers else ambient.mass_fractions[i]
        gamma[c], rt[c] = mixture_gamma(table, fraction[c], t), mixture_gas_constant(table, fraction[c]) * t
        enthalpy[c] = mixture_enthalpy(table, fraction[c], t)
    return Reservoirs(fraction, pressure, gamma, rt, enthalpy, mass)


@scalar
def flows(passages, is_open, areas, old, expected, volume, time, dt, blocked_out, flow_out):
    """Mass [kg] that goes through each passage from behind to ahead within a step, into flow_out (passages,).

    passages: PassageTable. areas: (chunks, 2) of Passages.measure. old: Reservoirs. expected: p* [Pa] and volume [m^3]
    at the end of the step, (chambers,). time: middle of the step [s]. Opens passages in is_open (passages,) bool.
    blocked_out: blocked area [m^2], (passages,).
    """
    chambers, plan, numbers, first_chunk = len(volume), passages.plan, passages.numbers, passages.first_chunk
    pressure, gamma, rt, mass = old.pressure, old.gamma, old.rt, old.mass
    matrix, new = np.zeros((chambers, chambers)), np.empty(chambers + 1)
    for c in range(chambers):
        matrix[c, c], new[c] = 1.0, expected[c]
    new[chambers] = pressure[chambers]
    for k in range(len(plan)):
        b, a = plan[k, BEHIND] % (chambers + 1), plan[k, AHEAD] % (chambers + 1)  # OUTSIDE, -1, is the last entry
        present, blocked = 0.0, 0.0
        for chunk in range(first_chunk[k], first_chunk[k + 1]):
            present += areas[chunk, 0]
            blocked += areas[chunk, 1]
        blocked_out[k] = blocked if numbers[k, THROUGH_BLOCKED] < 1.0 else 0.0
        behind, ahead = pressure[b], pressure[a]
        if behind - ahead >= numbers[k, OPENS_AT] or time + 0.5 * dt >= numbers[k, BURSTS_AT]:
            is_open[k] = True
        flow_out[k] = 0.0
        if not is_open[k]:
            continue
        up, down = (b, a) if behind >= ahead else (a, b)
        area = effective_area(passages, k, present, blocked, time, behind, ahead)
        passes = dt * area * conductance(plan[k, LAW], pressure[up], pressure[down], gamma[up], rt[up])
        flow_out[k] = passes  # per pressure difference, until the new pressures are known
        if b < chambers:
            _add_flow(matrix, new, b, a, gamma[b] * rt[up] / volume[b] * passes)
        if a < chambers:
            _add_flow(matrix, new, a, b, gamma[a] * rt[up] / volume[a] * passes)
    _solve(matrix, new)
    leaving = np.zeros(chambers + 1)
    for k in range(len(plan)):
        b, a = plan[k, BEHIND] % (chambers + 1), plan[k, AHEAD] % (chambers + 1)
        flow_out[k] *= new[b] - new[a]
        leaving[b if flow_out[k] > 0.0 else a] += abs(flow_out[k])
    for k in range(len(plan)):
        up = plan[k, BEHIND if flow_out[k] > 0.0 else AHEAD] % (chambers + 1)
        if up < chambers and leaving[up] > LARGEST_SHARE * mass[up]:
            flow_out[k] *= LARGEST_SHARE * mass[up] / leaving[up]


@scalar
def _add_flow(matrix, right, here, other, response):
    """Add a passage to `other` to the row of chamber `here`; response: pressure lost per pressure difference [-]."""
    chambers = len(matrix)
    matrix[here, here] += response
    if other < chambers:
        matrix[here, other] -= response
    else:
        right[here] += response * right[other]


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
