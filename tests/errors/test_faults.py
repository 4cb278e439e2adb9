"""Seeded faults: the cause is named, and nothing goes wrong in silence."""

from __future__ import annotations

import dataclasses

import pytest

from trust.faults import FAULTS, Fault, findings, run_faults


@pytest.fixture(scope="module")
def results():
    return {result.name: result for result in run_faults()}


def test_nothing_is_found_in_a_sound_case():
    assert findings(Fault("none", "", ())) == []


def test_there_are_faults_enough_and_each_has_a_name_of_its_own(results):
    assert len(FAULTS) == len(results) >= 30


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_the_cause_is_named(fault, results):
    result = results[fault.name]
    assert not result.silent
    assert result.named, [str(finding) for finding in findings(fault)]


def test_a_fault_that_is_not_expected_is_not_counted_as_named(monkeypatch):
    """The measure itself: another code, another word, or no fault at all."""
    thick = next(fault for fault in FAULTS if fault.name == "thickness in mm")
    others = [
        dataclasses.replace(thick, name="another code", codes="E-CASE-003"),
        dataclasses.replace(thick, name="another word", words=("density",)),
        dataclasses.replace(thick, name="no fault", changes={}),
    ]
    monkeypatch.setattr("trust.faults.FAULTS", others)
    assert [(result.named, result.silent) for result in run_faults()] == [(False, False), (False, False), (False, True)]
