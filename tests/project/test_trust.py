"""The measures of `make trust` that take seconds: they keep up with the code, and hold."""

from __future__ import annotations

import shutil

import pytest

from trust import conservation, determinism, mutants


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


@pytest.mark.parametrize("mutant", mutants.MUTANTS, ids=lambda mutant: mutant.name)
def test_a_mutant_still_fits_the_code_and_names_a_test_there_is(mutant, tmp_path):
    """What `python -m trust.mutants` tries, without running it."""
    copy = tmp_path / mutant.file
    copy.parent.mkdir(parents=True)
    shutil.copy(mutants.PACKAGE / mutant.file, copy)
    mutant.apply(tmp_path)
    compile(copy.read_text(encoding="utf-8"), mutant.file, "exec")
    file, _, test = mutant.test.partition("::")
    assert f"def {test}" in (mutants.ROOT / file).read_text(encoding="utf-8")
