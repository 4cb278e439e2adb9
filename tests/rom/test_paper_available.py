"""Which nested designs a report may speak about when a study is not complete."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from billow.base.errors import InputError
from billow.reproductions.rom_paper.available import available

TRAIN, TEST = [f"{run:04d}" for run in range(40)], [f"{run:04d}" for run in range(40, 45)]


def dataset(done: int, unseen: int = 5, **verdicts):
    """The first `done` training runs and `unseen` test runs; verdicts: of runs that have not passed, "r0003"="FAIL"."""
    return SimpleNamespace(
        title="Made up",
        train=tuple(TRAIN[:done]),
        test=tuple(TEST[:unseen]),
        verdict=lambda run: verdicts.get(f"r{run}", "PASS"),
        result=lambda run: SimpleNamespace(record={"quality": {"verdict": verdicts.get(f"r{run}", "PASS")}}),
        doubts=lambda run: ("short", "shooting nodes") if run == "0003" else ("short",),
    )


def test_a_complete_study_leaves_nothing_to_say():
    there = available(dataset(40), TRAIN, TEST, (10, 20, 40))
    assert {size: len(runs) for size, runs in there.sizes.items()} == {10: 10, 20: 20, 40: 40}
    assert there.notes == ()
    assert there.unseen == tuple(TEST)


def test_designs_that_are_not_in_are_named():
    there = available(dataset(27, unseen=3), TRAIN, TEST, (10, 20, 40))
    assert list(there.sizes) == [10, 20]
    assert there.largest == 20
    assert there.sizes[20] == tuple(TRAIN[:20])  # the other seven belong to no Latin hypercube
    assert any("N_DOE = 40 is left out: only 27 of its 40" in note for note in there.notes)
    assert any("3 of 5 unseen" in note for note in there.notes)
    assert there.unseen == tuple(TEST[:3])


def test_a_failed_run_leaves_its_design_standing():
    there = available(dataset(40, r0003="FAIL"), TRAIN, TEST, (10, 20, 40))
    assert len(there.sizes[10]) == 9
    assert "0003" not in there.sizes[40]
    assert any("left out: 1 of 10, 1 of 20, 1 of 40" in note for note in there.notes)


def test_a_run_to_review_is_used_and_counted():
    there = available(dataset(40, r0003="REVIEW", r0030="REVIEW"), TRAIN, TEST, (10, 20, 40))
    assert len(there.sizes[40]) == 40
    assert there.notes == ("2 of the 40 training runs used carry the verdict REVIEW: short (2), shooting nodes (1).",)


def test_an_unseen_run_that_failed_is_no_truth():
    there = available(dataset(40, r0041="FAIL"), TRAIN, TEST, (10, 20, 40))
    assert "0041" not in there.unseen
    assert any("0041" in note for note in there.notes)


def test_fewer_runs_than_the_smallest_design_stand_for_one():
    there = available(dataset(6), TRAIN, TEST, (10, 20, 40))
    assert there.sizes == {6: tuple(TRAIN[:6])}
    assert any("are used as one" in note for note in there.notes)


@pytest.mark.parametrize(("done", "unseen", "code"), [(40, 0, "E-ROM-015"), (1, 5, "E-ROM-007")])
def test_nothing_to_learn_or_to_compare(done, unseen, code):
    with pytest.raises(InputError) as raised:
        available(dataset(done, unseen), TRAIN, TEST, (10, 20, 40))
    assert raised.value.code == code
