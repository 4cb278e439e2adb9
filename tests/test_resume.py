"""A run that was interrupted ends in the same bits as one that was not."""

from __future__ import annotations

import pytest
from run_fingerprint import fingerprint

from billow.base.errors import InputError, IntegrityError
from billow.run.checkpoint_file import SLOTS
from billow.run.interrupts import STOP_FILE, RunInterrupted
from billow.run.simulate import resume, simulate


@pytest.fixture
def brief(small_case):
    return small_case.vary({"run.end_time": 0.009})


def interrupted(case, folder):
    """A run stopped at its first frame; returns its .partial folder."""
    partial = folder.with_name(folder.name + ".partial")
    with pytest.raises(RunInterrupted):
        simulate(case, folder, progress=lambda progress: (partial / STOP_FILE).touch())
    return partial


def test_the_same_bits_with_and_without_interruption(in_two, brief, tmp_path):
    straight = simulate(brief, tmp_path / "straight", threads=1)
    resumed = in_two(brief, tmp_path / "resumed")
    assert fingerprint(resumed.folder) == fingerprint(straight.folder)
    assert resumed.record["ledger"] == straight.record["ledger"]


def test_one_damaged_slot_is_passed_over_and_two_are_refused(brief, tmp_path):
    partial = interrupted(brief, tmp_path / "run")
    good = (partial / SLOTS[0]).read_bytes()
    (partial / SLOTS[1]).write_bytes(good[:-5])
    (partial / SLOTS[0]).write_bytes(good[:200] + b"x" + good[201:])
    with pytest.raises(IntegrityError, match="E-RES-031"):
        resume(tmp_path / "run")
    (partial / SLOTS[0]).write_bytes(good)
    assert resume(tmp_path / "run").status == "completed"


def test_a_checkpoint_of_another_case_is_refused(brief, tmp_path):
    partial = interrupted(brief, tmp_path / "run")
    other = brief.vary({"fabric.permeability": 0.03})
    (partial / "case.toml").write_text(other.to_toml(), encoding="utf-8")
    with pytest.raises(IntegrityError, match="another case"):
        resume(tmp_path / "run")


def test_starting_over_does_not_lose_a_checkpoint(brief, tmp_path):
    interrupted(brief, tmp_path / "run")
    with pytest.raises(InputError, match="E-RES-022"):
        simulate(brief, tmp_path / "run")


def test_a_finished_run_has_nothing_to_resume(brief, tmp_path):
    simulate(brief, tmp_path / "run")
    with pytest.raises(InputError, match="E-RES-021"):
        resume(tmp_path / "run")
