"""State of the gas in a control volume from its totals: mixture of ideal gases with cp(T)."""

from __future__ import annotations

import math

from billow.base.compiled import scalar
from billow.parts.gas.supply.mixture import species_cp, species_enthalpy
from billow.parts.gas.supply.species import COLDEST, HOTTEST

RHO, U, P, C, G, T, Y = 0, 1, 4, 5, 6, 7, 8
"""Columns of a state: density [kg/m^3], velocity [m/s] (three), pressure [Pa], speed of sound [m/s], 1 + p/(rho e) [-],
temperature [K], and mass fractions. With the fifth, energy per volume is p/(G - 1) + rho u^2/2 for any mixture."""

ITERATIONS = 40
EXACT = 1e-7
"""Last change of temperature, relative; its square is left, as Newton's method converges."""
USUAL = 300.0
"""First guess of a temperature [K] where there was no gas."""


@scalar
def mixture_row(table, totals, i, species, temperature):
    """Heat capacity of the masses totals[i, :species] [kg] as a + b t + c t^2 + d t^3 + e t^4 [J/K], what its integral
    lacks of the enthalpy [J], and the range of temperatures [K] about this one within which that holds."""
    t, low, high = temperature, COLDEST, HOTTEST
    a, b, c, d, e, offset = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for s in range(species):
        m, middle = totals[i, s], table[s, 1]
        if t < middle:
            k, add, high = 2, table[s, 14], min(high, middle)
        else:
            k, add, low = 7, table[s, 15], max(low, middle)
        a, b, c = a + m * table[s, k], b + m * table[s, k + 1], c + m * table[s, k + 2]
        d, e, offset = d + m * table[s, k + 3], e + m * table[s, k + 4], offset + m * add
    return a, b, c, d, e, offset, low, high


@scalar
def heat_content(table, totals, i, species, temperature):
    """Enthalpy [J] and heat capacity at constant pressure [J/K] of the masses totals[i, :species] [kg]."""
    enthalpy, capacity = 0.0, 0.0
    for s in range(species):
        enthalpy += totals[i, s] * species_enthalpy(table[s], temperature)
        capacity += totals[i, s] * species_cp(table[s], temperature)
    return enthalpy, capacity


@scalar
def temperature_of(table, totals, i, species, gas_constant, thermal, guess):
    """Temperature [K] and heat capacity at constant pressure [J/K] of masses with this internal energy [J], by Newton's
    method. gas_constant: of all of them [J/K]."""
    t = guess if guess > 1.0 else USUAL
    a, b, c, d, e, offset, low, high = mixture_row(table, totals, i, species, t)
    for _ in range(ITERATIONS):
        if not low < t < high:
            break
        cp = a + t * (b + t * (c + t * (d + t * e)))
        enthalpy = offset + t * (a + t * (b / 2.0 + t * (c / 3.0 + t * (d / 4.0 + t * e / 5.0))))
        change = (enthalpy - gas_constant * t - thermal) / (cp - gas_constant)
        t -= change
        if abs(change) <= EXACT * t and low < t < high:
            return t, cp
    t, cp = guess if guess > 1.0 else USUAL, 0.0  # across the ranges of the species
    for _ in range(ITERATIONS):
        enthalpy, cp = heat_content(table, totals, i, species, t)
        change = (enthalpy - gas_constant * t - thermal) / (cp - gas_constant)
        change = min(max(change, -t), 0.5 * t)  # never below zero, at most doubled
        t -= change
        if abs(change) <= EXACT * t:
            break
    return t, cp


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
def primitive(table, totals, i, species, volume, guess, state, row):
    """State of a control volume of `volume` [m^3] that holds totals[i], into state[row]. Returns whether there is one:
    positive mass and internal energy."""
    m, gas_constant, thermal = contents(table, totals, i, species)
    if not (m > 0.0 and volume > 0.0 and thermal > 0.0):
        return False
    t, cp = temperature_of(table, totals, i, species, gas_constant, thermal, guess)
    heat, share, density = gas_constant * t, 1.0 / m, 1.0 / volume
    state[row, RHO], state[row, P] = m * density, heat * density
    for d in range(3):
        state[row, U + d] = share * totals[i, species + d]
    state[row, C] = math.sqrt(cp / (cp - gas_constant) * heat * share)
    state[row, G] = 1.0 + heat / thermal
    state[row, T] = t
    for s in range(species):
        state[row, Y + s] = share * totals[i, s]
    return True


@scalar
def new_state(table, totals, i, species, volume, guess, state, c):
    """State of totals[i] in `volume` [m^3] into state[c], zeros if there is no gas or no room; returns whether there
    are both and yet no state."""
    if primitive(table, totals, i, species, volume, guess, state, c):
        return False
    some = False
    for s in range(species):
        some = some or totals[i, s] != 0.0
    for k in range(Y + species):
        state[c, k] = 0.0
    return some and volume > 0.0
