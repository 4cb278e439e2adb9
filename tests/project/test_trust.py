"""The measures of `make trust` that take seconds: they keep up with the code, and hold."""

from __future__ import annotations

import pytest

from trust import conservation, determinism


def test_momentum_of_a_closed_scene_is_conserved():
    contact, scene = conservation.momentum_error()
    assert contact <= 1e-12
    assert 0.0 < scene <= 1e-11  # nothing was exchanged, nothing was measured


def test_books_of_the_gas_close_through_an_impact():
    mass, energy = conservation.gas_errors()
    assert max(mass, energy) <= 1e-12


def test_energy_of_fabric_that_vibrates_is_conserved():
    assert 0.0 < conservation.smooth_energy_error() <= 1e-3


@pytest.mark.parametrize("gas", determinism.GASES)
def test_a_restart_gives_the_same_bits(gas):
    assert all(determinism.restarts(gas).values())
