"""Temperatures of many gases at once."""

from __future__ import annotations

import numpy as np
import pytest

from billow.parts.gas.mesh.thermodynamics import CAPACITY, FOUND, GAS, LANES, MASS, temperatures
from billow.parts.gas.supply.mixture import mixture_cp, mixture_enthalpy, mixture_gas_constant
from billow.parts.gas.supply.species import SPECIES, thermo_table


def test_internal_energy_at_the_temperature_is_what_the_gas_holds():
    """From guesses near and far, across the bounds of the species at 200, 1000 and 6000 K; none without gas."""
    random, table = np.random.default_rng(3), thermo_table([SPECIES[name] for name in ("N2", "CO2", "He")])
    exact = np.concatenate([random.uniform(100.0, 7000.0, LANES - 2), [999.9, 1000.1]])
    totals, rows = np.zeros((2 * LANES, 7)), np.arange(LANES)[::-1] + LANES
    totals[rows, :3] = random.uniform(0.0, 1e-3, (LANES, 3))
    totals[rows, 3:6] = random.normal(size=(LANES, 3)) * 1e-2
    for row, t in zip(rows, exact, strict=True):
        masses, momentum = totals[row, :3], totals[row, 3:6]
        totals[row, 6] = mixture_enthalpy(table, masses, t) - mixture_gas_constant(table, masses) * t
        totals[row, 6] += 0.5 * momentum @ momentum / masses.sum()
    totals[rows[4]], totals[rows[5], 6] = 0.0, 0.0
    guess = exact * random.uniform(0.5, 1.5, LANES)
    guess[:3] = 0.0, exact[1], 1.001 * exact[2]
    found = np.empty((4, LANES))
    temperatures(LANES, table, totals, rows, guess, found)
    assert found[FOUND, 4:6].tolist() == [0.0, 0.0]
    for k in (*range(4), *range(6, LANES)):
        masses = totals[rows[k], :3]
        assert found[FOUND, k] == pytest.approx(exact[k], rel=1e-11), k
        assert found[CAPACITY, k] == pytest.approx(mixture_cp(table, masses, exact[k]), rel=1e-6), k
        assert found[GAS, k] == pytest.approx(mixture_gas_constant(table, masses), rel=1e-14), k
        assert found[MASS, k] == pytest.approx(masses.sum(), rel=1e-14), k
