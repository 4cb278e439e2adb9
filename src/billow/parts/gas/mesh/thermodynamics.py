"""State of the gas in a control volume from its totals: mixture of ideal gases with cp(T)."""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.supply.mixture import mixture_cp, mixture_enthalpy
from billow.parts.gas.supply.species import COLDEST, HOTTEST

RHO, U, P, C, G, T, Y = 0, 1, 4, 5, 6, 7, 8
"""Columns of a state: density [kg/m^3], velocity [m/s] (three), pressure [Pa], speed of sound [m/s], 1 + p/(rho e) [-],
temperature [K], and mass fractions. With the fifth, energy per volume is p/(G - 1) + rho u^2/2 for any mixture."""

ITERATIONS = 40
EXACT = 1e-7
"""Last change of temperature, relative; its square is left, as Newton's method converges."""
USUAL = 300.0
"""First guess of a temperature [K] where there was no gas."""
LANES = 64
"""Totals whose temperatures are found together."""
FOUND, CAPACITY, GAS, MASS = 0, 1, 2, 3
"""Rows of what is found of totals: temperature [K], or zero if they hold no gas or no internal energy; heat capacity at
constant pressure [J/K]; gas constant [J/K]; mass [kg]."""


@scalar
def contents(table, totals, i, species):
    """Mass [kg], gas constant times mass [J/K] and internal energy [J] of totals[i]: masses [kg] (species,), momentum
    [kg m/s] (3,) and energy [J]; the last is zero without mass."""
    m, gas_constant = 0.0, 0.0
    for s in range(species):
        m += totals[i, s]
        gas_constant += totals[i, s] * table[s, 0]
    if not m > 0.0:
        return m, gas_constant, 0.0
    u, v, w = totals[i, species], totals[i, species + 1], totals[i, species + 2]
    return m, gas_constant, totals[i, species + 3] - 0.5 * (u * u + v * v + w * w) / m


@scalar
def temperatures(n, table, totals, rows, guess, found_out):
    """What is found of n <= LANES totals, those in `rows`, into found_out (4, LANES), by Newton's method from a guess
    [K].

    All of them take a step together: numbers that lie side by side share an instruction. Within the ranges of the
    species the heat capacity of a mixture is one polynomial; totals that cross a bound start anew, each alone.
    """
    species, lane = len(table), np.empty((15, LANES))
    a, b, c, d, e, offset, low, high, thermal, gas, first, t, cp, wanted, masses = range(15)
    for k in range(n):
        found_out[MASS, k], lane[gas, k], lane[thermal, k] = contents(table, totals, rows[k], species)
        lane[first, k] = guess[k] if guess[k] > 1.0 else USUAL
    for k in range(n):
        lane[a, k], lane[b, k], lane[c, k], lane[d, k], lane[e, k], lane[offset, k] = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        lane[low, k], lane[high, k], lane[t, k], lane[cp, k] = COLDEST, HOTTEST, lane[first, k], 0.0
        lane[wanted, k] = 1.0 if lane[thermal, k] > 0.0 else 0.0
    for s in range(species):
        cold, middle, warm = table[s, 2:7], table[s, 1], table[s, 7:12]
        cold_offset, warm_offset = table[s, 14], table[s, 15]
        for k in range(n):
            lane[masses, k] = totals[rows[k], s]
        for k in range(n):
            x, below = lane[masses, k], lane[t, k] < middle
            lane[a, k] += x * (cold[0] if below else warm[0])
            lane[b, k] += x * (cold[1] if below else warm[1])
            lane[c, k] += x * (cold[2] if below else warm[2])
            lane[d, k] += x * (cold[3] if below else warm[3])
            lane[e, k] += x * (cold[4] if below else warm[4])
            lane[offset, k] += x * (cold_offset if below else warm_offset)
            lane[high, k] = min(lane[high, k], middle) if below else lane[high, k]
            lane[low, k] = lane[low, k] if below else max(lane[low, k], middle)
    for _ in range(ITERATIONS):
        for k in range(n):
            x, left = lane[t, k], lane[wanted, k]
            rate = lane[a, k] + x * (lane[b, k] + x * (lane[c, k] + x * (lane[d, k] + x * lane[e, k])))
            rest = lane[c, k] / 3.0 + x * (lane[d, k] / 4.0 + x * lane[e, k] / 5.0)
            enthalpy = lane[offset, k] + x * (lane[a, k] + x * (lane[b, k] / 2.0 + x * rest))
            change = (enthalpy - lane[gas, k] * x - lane[thermal, k]) / (rate - lane[gas, k])
            there, go = x - change, left > 0.5
            known = (lane[low, k] < x) & (x < lane[high, k])
            exact = (abs(change) <= EXACT * there) & (lane[low, k] < there) & (there < lane[high, k])
            after = (0.0 if exact else 1.0) if known else -1.0
            lane[t, k], lane[cp, k] = there if go else x, rate if go else lane[cp, k]
            lane[wanted, k] = after if go else left
        more = 0
        for k in range(n):
            more += lane[wanted, k] > 0.5
        if more == 0:
            break
    for k in range(n):
        found_out[FOUND, k] = lane[t, k] if lane[thermal, k] > 0.0 else 0.0
        found_out[CAPACITY, k], found_out[GAS, k] = lane[cp, k], lane[gas, k]
        if lane[wanted, k] != 0.0:
            found_out[FOUND, k], found_out[CAPACITY, k] = _across_ranges(
                table, totals, rows[k], lane[gas, k], lane[thermal, k], lane[first, k]
            )


@scalar
def _across_ranges(table, totals, i, gas_constant, thermal, guess):
    """Temperature [K] and heat capacity at constant pressure [J/K] of totals[i] with this internal energy [J]."""
    t, cp, species = guess, 0.0, len(table)
    for _ in range(ITERATIONS):
        cp = mixture_cp(table, totals[i, :species], t)
        change = mixture_enthalpy(table, totals[i, :species], t) - gas_constant * t - thermal
        change = min(max(change / (cp - gas_constant), -t), 0.5 * t)  # never below zero, at most doubled
        t -= change
        if abs(change) <= EXACT * t:
            break
    return t, cp


@scalar
def put_state(totals, i, species, volume, found, k, state_out, c):
    """State of totals[i] in `volume` [m^3], of which found[:, k] is known, into state_out[c]; zeros if there is no gas
    or no room. Returns whether there are both and yet no state."""
    t, cp, gas_constant, m = found[FOUND, k], found[CAPACITY, k], found[GAS, k], found[MASS, k]
    if not (t > 0.0 and volume > 0.0):
        some = False
        for s in range(species):
            some = some or totals[i, s] != 0.0
        for q in range(Y + species):
            state_out[c, q] = 0.0
        return some and volume > 0.0
    flow = 0.0
    heat, share, density = gas_constant * t, 1.0 / m, 1.0 / volume
    state_out[c, RHO], state_out[c, P] = m * density, heat * density
    for d in range(3):
        flow += totals[i, species + d] * totals[i, species + d]
        state_out[c, U + d] = share * totals[i, species + d]
    state_out[c, C] = math.sqrt(cp / (cp - gas_constant) * heat * share)
    state_out[c, G] = 1.0 + heat / (totals[i, species + 3] - 0.5 * flow / m)
    state_out[c, T] = t
    for s in range(species):
        state_out[c, Y + s] = share * totals[i, s]
    return False
