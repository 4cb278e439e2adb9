"""The molecules that a particle represents, and its internal energy (docs/theory.md, Internal degrees of freedom of
particles)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.supply.mixture import species_cp, species_enthalpy
from billow.parts.gas.supply.species import MOLAR_GAS_CONSTANT

AVOGADRO = 6.02214076e23  # 1/mol, SI definition
BOLTZMANN = MOLAR_GAS_CONSTANT / AVOGADRO  # J/K

SPREAD = 0.1
"""Relative step for derivatives by temperature: about the size of the fluctuation that they describe."""


@dataclass(frozen=True)
class ParticleKinds:
    """One kind of particle per species.

    table: (species, 16), species.thermo_table. molecules: that one particle represents [-]. mass: of one particle of
    each species [kg], (species,). heat: k times molecules [J/K]: a particle's mean kinetic energy is 3/2 heat T.
    """

    table: np.ndarray
    molecules: float
    mass: np.ndarray = field(init=False)
    heat: float = field(init=False)

    def __post_init__(self):
        heat = BOLTZMANN * self.molecules
        object.__setattr__(self, "heat", heat)
        object.__setattr__(self, "mass", heat / self.table[:, 0])  # m R = k molecules for every species

    @classmethod
    def sharing(cls, table: np.ndarray, masses: np.ndarray, particles: int) -> ParticleKinds:
        """Kinds for a total number of particles; masses [kg] (species,) of all the gas, initial and injected."""
        moles = float(np.sum(masses * table[:, 0])) / MOLAR_GAS_CONSTANT
        return cls(table, moles * AVOGADRO / particles)


@scalar
def degrees_of_freedom(row, temperature):
    """Internal degrees of freedom zeta [-] of a species (its row of the thermo table) at temperature [K]."""
    return max(0.0, 2.0 * species_enthalpy(row, temperature) / (row[0] * temperature) - 5.0)


@scalar
def cell_temperature(table, masses, heat, energy, guess):
    """Temperature [K] of a cell with masses [kg] (species,) and thermal energy [J], without that of the mean motion.

    sum(m_i e_i(T)) - 3/2 heat T = energy, by Newton's method until the first change below 1e-3 T (docs/theory.md,
    Collisions). guess [K]: of a similar gas. nan if there is no energy.
    """
    if not energy > 0.0:
        return np.nan
    t = guess
    for _ in range(60):
        content, slope = -1.5 * heat * t, -1.5 * heat
        for k in range(len(masses)):
            if masses[k] > 0.0:
                content += masses[k] * (species_enthalpy(table[k], t) - table[k, 0] * t)
                slope += masses[k] * (species_cp(table[k], t) - table[k, 0])
        change = max((energy - content) / slope, -0.5 * t)  # never below zero
        t += change
        if abs(change) < 1e-3 * t:
            break
    return t


@scalar
def cell_degrees_of_freedom(table, masses, heat, energy, temperature, dof_out):
    """Degrees of freedom zeta_i [-] (species,) for collisions in a cell, of the species that are there; energy [J],
    temperature [K]: cell_temperature.

    zeta_i(T) - F^2 (heat/C)^3 (T zeta_i' + T^2 zeta_i''/2), F = energy/(heat T) (docs/theory.md, Collisions).
    """
    half = energy / (heat * temperature)
    capacity = -1.5
    for k in range(len(masses)):
        if masses[k] > 0.0:
            capacity += masses[k] / heat * (species_cp(table[k], temperature) - table[k, 0])
    weight = half * half / capacity**3
    for k in range(len(masses)):
        if masses[k] == 0.0:
            continue
        here = degrees_of_freedom(table[k], temperature)
        above = degrees_of_freedom(table[k], temperature * (1.0 + SPREAD))
        below = degrees_of_freedom(table[k], temperature * (1.0 - SPREAD))
        slope = (above - below) / (2.0 * SPREAD)
        bend = (above - 2.0 * here + below) / (SPREAD * SPREAD)
        dof_out[k] = max(0.0, here - weight * (slope + 0.5 * bend))
