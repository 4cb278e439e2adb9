"""The verdict of a run, criterion by criterion."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from billow.base.quality import VERDICTS, criterion, overall
from billow.parts.gas.corpuscular.corpuscular import Corpuscular

PARTICLES = 100_000


@pytest.mark.parametrize(
    ("escaped", "verdict"), [(0, "PASS"), (1, "PASS"), (10, "PASS"), (11, "REVIEW"), (1000, "FAIL")]
)
def test_few_particles_outside_are_no_fault_and_many_are(escaped, verdict):
    """Of 100,000: up to one in 10,000 no book and no curve notices, one in a hundred means broken walls."""
    gas = SimpleNamespace(particles=PARTICLES)
    books = Corpuscular.books(gas, SimpleNamespace(escaped=escaped))
    (found,) = (c for c in Corpuscular.verdicts(gas, books) if "particles" in c.name)
    assert found.verdict == verdict


@pytest.mark.parametrize(("measured", "verdict"), [(1.0, 0), (1.01, 1), (4.99, 1), (5.0, 2), (np.nan, 2), (-np.inf, 2)])
def test_a_criterion_passes_up_to_one_bound_and_fails_from_another(measured, verdict):
    assert criterion("energy gain", measured, 1.0, 5.0, "%", "smaller steps").verdict == VERDICTS[verdict]


def test_a_run_is_as_good_as_its_worst_criterion():
    good = criterion("energy gain", 0.0, 1.0, 5.0, "%", "smaller steps")
    assert overall([]) == overall([good]) == "PASS"
    assert overall([good, dataclasses.replace(good, verdict="REVIEW"), good]) == "REVIEW"
    assert overall([dataclasses.replace(good, verdict=v) for v in ("FAIL", "REVIEW")]) == "FAIL"


def test_every_line_of_a_verdict_says_what_to_try(small_run):
    criteria = small_run.record["quality"]["criteria"]
    assert len(criteria) > 8
    assert all(line["remedy"] for line in criteria)
    log = (small_run.folder / "solver.log").read_text(encoding="utf-8")
    doubtful = [line for line in criteria if line["verdict"] != "PASS"]
    assert doubtful  # it ends before its pressure peak is over
    for line in doubtful:
        assert f"{line['verdict']}: {line['name']} = " in log
        assert f"; try: {line['remedy']}\n" in log
