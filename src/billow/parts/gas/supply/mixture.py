"""Ideal-gas mixtures as scalar functions (docs/theory.md, Gas mixture).

table: (species, 16) from `species.thermo_table`; masses: (species,) [kg].
"""

from __future__ import annotations

import math

from billow.base.compiled import scalar
from billow.parts.gas.supply.species import COLDEST, HOTTEST


@scalar
def species_cp(row, temperature):
    """Heat capacity at constant pressure [J/(kg K)] at temperature [K]."""
    t = temperature
    if t <= COLDEST:
        return row[12]
    if t >= HOTTEST:
        return row[13]
    k = 2 if t < row[1] else 7
    return row[k] + t * (row[k + 1] + t * (row[k + 2] + t * (row[k + 3] + t * row[k + 4])))


@scalar
def species_enthalpy(row, temperature):
    """Enthalpy above 0 K [J/kg] at temperature [K]."""
    t = temperature
    if t <= COLDEST:
        return row[12] * t
    beyond = 0.0
    if t > HOTTEST:
        beyond = row[13] * (t - HOTTEST)
        t = HOTTEST
    k, offset = (2, row[14]) if t < row[1] else (7, row[15])
    quartic = row[k + 1] / 2.0 + t * (row[k + 2] / 3.0 + t * (row[k + 3] / 4.0 + t * row[k + 4] / 5.0))
    return offset + t * (row[k] + t * quartic) + beyond


@scalar
def mixture_cp(table, masses, temperature):
    """Heat capacity at constant pressure times mass [J/K]."""
    total = 0.0
    for i in range(len(masses)):
        total += masses[i] * species_cp(table[i], temperature)
    return total


@scalar
def mixture_enthalpy(table, masses, temperature):
    """Enthalpy [J] of these masses at temperature [K]."""
    total = 0.0
    for i in range(len(masses)):
        total += masses[i] * species_enthalpy(table[i], temperature)
    return total


@scalar
def mixture_gas_constant(table, masses):
    """Sum of mass times specific gas constant [J/K]."""
    total = 0.0
    for i in range(len(masses)):
        total += masses[i] * table[i, 0]
    return total


@scalar
def mixture_cv(table, masses, temperature):
    """Heat capacity at constant volume times mass [J/K]."""
    return mixture_cp(table, masses, temperature) - mixture_gas_constant(table, masses)


@scalar
def mixture_gamma(table, masses, temperature):
    """Ratio of the heat capacities cp/cv [-]."""
    cp = mixture_cp(table, masses, temperature)
    return cp / (cp - mixture_gas_constant(table, masses))


@scalar
def mixture_temperature(table, masses, internal_energy, guess):
    """Temperature [K] at which sum(m_i e_i(T)) equals internal_energy [J], by Newton's method from a guess [K].

    Returns nan if there is no gas or the energy is negative.
    """
    gas_constant = mixture_gas_constant(table, masses)
    if not (gas_constant > 0.0 and internal_energy > 0.0):
        return math.nan
    t = guess
    for _ in range(60):
        residual = mixture_enthalpy(table, masses, t) - gas_constant * t - internal_energy
        change = residual / (mixture_cp(table, masses, t) - gas_constant)
        change = min(max(change, -t), 0.5 * t)  # never below zero, at most doubled
        t -= change
        if abs(change) <= 1e-14 * t:
            break
    return t
