"""How much gas goes through each passage within a step: one flow per passage, all from the same old state.

A flow taken from the old pressures alone overshoots where a hole is large for the chamber behind it, and then pressure
chatters about equality. Each flow is therefore taken as conductance (the chord of its law, from the old state) times
the difference of the *new* pressures, which are found for all chambers together from the linear system

    p_new = p* + dt sum(g R_u T_u gamma/V (p_new,other - p_new)),

with p* the pressure that inflow and change of volume alone would give. Its matrix is an M-matrix: new pressures lie
between the old ones, for any step and any passage (Varga, Matrix Iterative Analysis, section 3.5). Where the step is
small the flow is that of the old state; the error is of first order. The pressures serve only to find the flows; the
state follows from the books.
"""

from __future__ import annotations

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.chambers import OUTSIDE
from billow.parts.gas.supply.curve import curve_value
from billow.parts.gas.supply.outflow import conductance
from billow.parts.gas.supply.passages import (
    ABSOLUTE,
    AHEAD,
    AREA,
    BEHIND,
    BURSTS_AT,
    COEFFICIENT,
    FIRST_CURVE,
    LAW,
    OPENS_AT,
    PRESSURE_CURVE,
    PRESSURE_READ,
    SECOND_CURVE,
    THROUGH_BLOCKED,
    X0,
    X1,
    X2,
    X3,
    Passages,
)

LARGEST_SHARE = 0.5
"""Of a chamber's mass that may leave it within one step, so that no mass turns negative."""


@scalar
def effective_area(plan, numbers, curve_start, curve_x, curve_y, present, blocked, time, upstream, downstream, lead):
    """Area [m^2] of one passage times its coefficient; see billow.parts.gas.supply.passages for the formula.

    plan, numbers: its row. present, blocked: its present area and the blocked part of it [m^2]. upstream, downstream:
    pressures [Pa]; lead: pressure behind minus ahead [Pa].
    """
    ratio = upstream / downstream
    flat = numbers[AREA]
    area = numbers[X0] * flat + numbers[X1] * present + ratio * (numbers[X2] * flat + numbers[X3] * present)
    if present > 0.0:
        area *= 1.0 - blocked / present * (1.0 - numbers[THROUGH_BLOCKED])
    factor = numbers[COEFFICIENT]
    factor *= curve_value(curve_start, curve_x, curve_y, plan[FIRST_CURVE], time)
    factor *= curve_value(curve_start, curve_x, curve_y, plan[SECOND_CURVE], time)
    at = upstream if plan[PRESSURE_READ] == ABSOLUTE else lead
    return max(area, 0.0) * factor * curve_value(curve_start, curve_x, curve_y, plan[PRESSURE_CURVE], at)


def outflow(
    passages: Passages, kind: int, time: float, inside: float, outside: float, rt: float, gamma: float = 1.3
) -> float:
    """Mass flow [kg/s] to the surroundings through all open passages of a kind, at their flat areas.

    inside, outside: pressures [Pa]; rt: R T of the gas inside [J/kg]; gamma: its cp/cv [-].
    """
    total, curves = 0.0, passages.curves
    for row, plan, numbers in zip(passages.rows, passages.plan, passages.numbers, strict=True):
        if row.kind == kind and row.ahead == OUTSIDE:
            area = effective_area(
                plan, numbers, curves.start, curves.x, curves.y, row.area, 0.0, time, inside, outside, inside - outside
            )
            total += area * conductance(row.law, inside, outside, gamma, rt) * (inside - outside)
    return total


@scalar
def flows(
    plan, numbers, curve_start, curve_x, curve_y, first_chunk, areas, is_open,
    pressure, gamma, rt, mass, volume, expected, time, dt, blocked_out, flow_out,
):  # fmt: skip
    """Mass [kg] that goes through each passage from behind to ahead within a step, into flow_out (passages,).

    pressure [Pa], gamma [-] and rt = R T [J/kg] of the old state: (chambers + 1,), the last entry the surroundings.
    mass [kg], volume [m^3] at the end of the step, expected: p* [Pa]: (chambers,). time: middle of the step [s]. areas:
    (chunks, 2) of Passages.measure. Opens passages in `is_open`; blocked_out: blocked area [m^2], (passages,).
    """
    chambers = len(mass)
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
        lead = pressure[b] - pressure[a]
        if lead >= numbers[k, OPENS_AT] or time + 0.5 * dt >= numbers[k, BURSTS_AT]:
            is_open[k] = True
        flow_out[k] = 0.0
        if not is_open[k]:
            continue
        up, down = (b, a) if lead >= 0.0 else (a, b)
        area = effective_area(
            plan[k], numbers[k], curve_start, curve_x, curve_y, present, blocked, time, pressure[up], pressure[down],
            lead,
        )  # fmt: skip
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
        b, a = plan[k, BEHIND] % (chambers + 1), plan[k, AHEAD] % (chambers + 1)
        up = b if flow_out[k] > 0.0 else a
        if up < chambers and leaving[up] > LARGEST_SHARE * mass[up]:
            flow_out[k] *= LARGEST_SHARE * mass[up] / leaving[up]


@scalar
def _add_flow(matrix, right, here, other, response):
    """Row of chamber `here` for a passage to `other`; response: pressure given up per pressure difference [-]."""
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
