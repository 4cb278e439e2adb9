"""Thermodynamic data of gases (docs/theory.md, Gas mixture): NASA-7 coefficients of GRI-Mech 3.0 (Smith et al.,
gri-mech, thermo30.dat)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError

UNKNOWN_GAS = InputError.declare(
    "E-GAS-001",
    "unknown gas {name!r}",
    why="there are no thermodynamic data for it",
    cause="a misspelt formula",
    remedy="use one of {known}, or describe it under gas.species",
)

MOLAR_GAS_CONSTANT = 8.31446261815324  # J/(mol K), CODATA 2018
COLDEST, HOTTEST = 200.0, 3000.0  # K, range of the fits


@dataclass(frozen=True)
class Species:
    """One gas: molar mass [kg/mol]; cp/R as polynomials in T [K] below and above `middle` [K], 5 coefficients each."""

    name: str
    molar_mass: float
    low: tuple[float, ...]
    high: tuple[float, ...]
    middle: float = 1000.0

    @classmethod
    def polynomial(cls, name: str, molar_mass: float, a: float, b: float = 0.0, c: float = 0.0) -> Species:
        """Molar heat capacity cp = a + b T + c T^2 [J/(mol K)], as LS-DYNA's AIRBAG_HYBRID takes it."""
        coefficients = (a / MOLAR_GAS_CONSTANT, b / MOLAR_GAS_CONSTANT, c / MOLAR_GAS_CONSTANT, 0.0, 0.0)
        return cls(name, molar_mass, coefficients, coefficients)

    @classmethod
    def ideal(cls, name: str, gas_constant: float, gamma: float) -> Species:
        """Constant cp from the specific gas constant [J/(kg K)] and cp/cv [-]."""
        molar_mass = MOLAR_GAS_CONSTANT / gas_constant
        return cls.polynomial(name, molar_mass, MOLAR_GAS_CONSTANT * gamma / (gamma - 1.0))


_MONATOMIC = (2.5, 0.0, 0.0, 0.0, 0.0)
_NASA7 = [
    Species(
        "N2", 28.0134e-3, (3.298677, 1.4082404e-3, -3.963222e-6, 5.641515e-9, -2.444854e-12),
        (2.92664, 1.4879768e-3, -5.68476e-7, 1.0097038e-10, -6.753351e-15),
    ),
    Species(
        "O2", 31.9988e-3, (3.78245636, -2.99673416e-3, 9.84730201e-6, -9.68129509e-9, 3.24372837e-12),
        (3.28253784, 1.48308754e-3, -7.57966669e-7, 2.09470555e-10, -2.16717794e-14),
    ),
    Species(
        "H2O", 18.01528e-3, (4.19864056, -2.0364341e-3, 6.52040211e-6, -5.48797062e-9, 1.77197817e-12),
        (3.03399249, 2.17691804e-3, -1.64072518e-7, -9.7041987e-11, 1.68200992e-14),
    ),
    Species(
        "CO2", 44.0095e-3, (2.35677352, 8.98459677e-3, -7.12356269e-6, 2.45919022e-9, -1.43699548e-13),
        (3.85746029, 4.41437026e-3, -2.21481404e-6, 5.23490188e-10, -4.72084164e-14),
    ),
    Species(
        "CO", 28.0101e-3, (3.57953347, -6.1035368e-4, 1.01681433e-6, 9.07005884e-10, -9.04424499e-13),
        (2.71518561, 2.06252743e-3, -9.98825771e-7, 2.30053008e-10, -2.03647716e-14),
    ),
    Species(
        "H2", 2.01588e-3, (2.34433112, 7.98052075e-3, -1.9478151e-5, 2.01572094e-8, -7.37611761e-12),
        (3.3372792, -4.94024731e-5, 4.99456778e-7, -1.79566394e-10, 2.00255376e-14),
    ),
    Species("Ar", 39.948e-3, _MONATOMIC, _MONATOMIC),
    Species("He", 4.002602e-3, _MONATOMIC, _MONATOMIC),
]  # fmt: skip
SPECIES = {species.name: species for species in _NASA7}
AIR = {"N2": 0.79, "O2": 0.21}
"""Mole fractions of ambient air [-]."""


def find_species(name: str, where: str, own: Mapping[str, Species] | None = None) -> Species:
    """The species of that name, from `own` or from the library; raises InputError E-GAS-001."""
    if own and name in own:
        return own[name]
    if name not in SPECIES:
        known = ", ".join([*SPECIES, *(own or ())])
        raise UNKNOWN_GAS(where=where, name=name, known=known, remedy=f"use one of {known}" if own is None else None)
    return SPECIES[name]


def mass_fractions(mole_fractions: Mapping[str, float], own: Mapping[str, Species] | None = None) -> dict[str, float]:
    """Mass fractions [-] from mole fractions [-]; both sum to one. own: species besides those of the library."""
    known = {**SPECIES, **(own or {})}
    mass = {name: share * known[name].molar_mass for name, share in mole_fractions.items()}
    total = sum(mass.values())
    return {name: value / total for name, value in mass.items()}


def thermo_table(species: list[Species]) -> np.ndarray:
    """What kernels need of each species, (species, 16), specific (per kilogram) units.

    Column 0: gas constant [J/(kg K)]; 1: middle temperature [K]; 2-6 and 7-11: cp coefficients below and above it
    [J/(kg K^k+1)]; 12, 13: cp [J/(kg K)] at 200 and 3000 K; 14, 15: enthalpy [J/kg] offsets of the lower and upper
    polynomial, such that h is continuous and h(0) = 0.
    """
    powers = np.arange(5)
    table = np.zeros((len(species), 16))
    for row, gas in zip(table, species, strict=True):
        gas_constant = MOLAR_GAS_CONSTANT / gas.molar_mass
        low, high = gas_constant * np.array(gas.low), gas_constant * np.array(gas.high)

        def integral(coefficients, temperature):
            return float(np.sum(coefficients * temperature ** (powers + 1) / (powers + 1)))

        cp_cold = float(np.sum(low * COLDEST**powers))
        offset_low = cp_cold * COLDEST - integral(low, COLDEST)
        offset_high = offset_low + integral(low, gas.middle) - integral(high, gas.middle)
        row[0], row[1], row[2:7], row[7:12] = gas_constant, gas.middle, low, high
        row[12], row[13] = cp_cold, float(np.sum(high * HOTTEST**powers))
        row[14], row[15] = offset_low, offset_high
    return table
