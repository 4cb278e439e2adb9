"""Thermodynamics of mixtures: temperature and energy are each other's inverse, cp is the slope of enthalpy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.parts.gas.supply.mixture import (
    mixture_enthalpy,
    mixture_gas_constant,
    mixture_temperature,
    species_cp,
    species_enthalpy,
)
from billow.parts.gas.supply.species import SPECIES, Species, find_species, mass_fractions, thermo_table

NAMES = tuple(SPECIES)
TABLE = thermo_table([SPECIES[name] for name in NAMES])
# Around every seam of the fits (200, 1000, 3000 K) and anywhere else.
temperatures = st.one_of(st.floats(50.0, 4500.0), *[st.floats(t - 1e-3, t + 1e-3) for t in (200.0, 1000.0, 3000.0)])
mixtures = st.lists(st.floats(0.0, 1.0), min_size=len(NAMES), max_size=len(NAMES)).filter(lambda m: sum(m) > 1e-3)


def energy(masses, temperature):
    return mixture_enthalpy(TABLE, masses, temperature) - mixture_gas_constant(TABLE, masses) * temperature


@given(masses=mixtures, temperature=temperatures, guess=st.floats(60.0, 5000.0))
def test_temperature_is_found_from_energy(masses, temperature, guess):
    masses = np.array(masses)
    found = mixture_temperature(TABLE, masses, energy(masses, temperature), guess)
    assert found == pytest.approx(temperature, rel=1e-11)


@pytest.mark.parametrize("name", NAMES)
def test_cp_is_the_slope_of_enthalpy(name):
    row = TABLE[NAMES.index(name)]
    for t in [60.0, 199.0, 201.0, 500.0, 995.0, 1005.0, 2000.0, 2999.0, 3001.0, 4000.0]:
        slope = (species_enthalpy(row, t + 0.05) - species_enthalpy(row, t - 0.05)) / 0.1
        assert slope == pytest.approx(species_cp(row, t), rel=1e-7)
    for seam in (200.0, 1000.0, 3000.0):
        above, below = np.nextafter(seam, 1e4), np.nextafter(seam, 0.0)
        assert species_enthalpy(row, above) == pytest.approx(species_enthalpy(row, below), rel=1e-13)
        assert species_cp(row, above) == pytest.approx(species_cp(row, below), rel=1e-3)  # the fits themselves
    assert species_enthalpy(row, 0.0) == 0.0


def test_no_gas_or_no_energy_has_no_temperature():
    masses = np.zeros(len(NAMES))
    assert np.isnan(mixture_temperature(TABLE, masses, 100.0, 300.0))
    masses[0] = 1.0
    assert np.isnan(mixture_temperature(TABLE, masses, -100.0, 300.0))


def test_other_ways_to_describe_a_gas():
    row = thermo_table([Species.ideal("any", 287.0, 1.4)])[0]
    assert species_cp(row, 1234.0) == pytest.approx(1004.5, rel=1e-12)
    row = thermo_table([Species.polynomial("any", 0.028, 27.3, 6.23e-3, -9.5e-7)])[0]
    assert species_cp(row, 800.0) == pytest.approx((27.3 + 6.23e-3 * 800.0 - 9.5e-7 * 640000.0) / 0.028, rel=1e-12)
    shares = mass_fractions({"Ar": 0.95, "O2": 0.05})
    assert sum(shares.values()) == pytest.approx(1.0, rel=1e-15)
    assert shares["Ar"] / shares["O2"] == pytest.approx(0.95 * 39.948 / (0.05 * 31.9988), rel=1e-12)


def test_an_unknown_gas_is_refused():
    with pytest.raises(InputError, match="E-GAS-001") as caught:
        find_species("n2", "inflator.gas.n2")
    assert "inflator.gas.n2" in str(caught.value)
    assert "N2" in caught.value.remedy
