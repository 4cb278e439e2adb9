"""A study grows until the error is as small as wanted, where the model is least certain."""

from types import SimpleNamespace

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.design import adaptive
from billow.design.adaptive import BATCH, Aim, grow, learning_curve, spread_out
from billow.design.figures import draw
from trust.small_surfaces import PARAMETERS


def test_aims_are_read():
    assert Aim.read("rmse < 3 mm") == Aim("rmse", 3.0, "mm")
    assert Aim.read("hic15<40") == Aim("hic15", 40.0, "")
    for wrong in ("rmse", "rmse < -1 mm", "rmse < 3 kg", "rmse > 3 mm", ""):
        with pytest.raises(InputError) as caught:
            Aim.read(wrong)
        assert caught.value.code == "E-DES-050"


def test_designs_are_chosen_where_the_deviation_is_and_no_run():
    known = np.array([[35.0, 5.0, 0.0], [20.0, 3.0, 1.0]])
    rows = spread_out(lambda unit: np.where(unit[:, 0] > 0.5, 1.0, 0.01), known, PARAMETERS)
    assert len(rows) == BATCH == len(np.unique(rows, axis=0))
    assert (rows[:, 0] > 35.0).all()
    assert set(rows[:, 2]) <= {0.0, 1.0}


def test_designs_are_chosen_among_those_that_the_study_may_have():
    known = np.array([[35.0, 5.0, 0.0]])
    drawable = lambda designs: designs[designs[:, 0] + designs[:, 1] < 27.0]  # noqa: E731
    rows = spread_out(lambda unit: np.ones(len(unit)), known, PARAMETERS, drawable)
    assert len(rows) == BATCH
    assert (rows[:, 0] + rows[:, 1] < 27.0).all()
    assert len(spread_out(lambda unit: np.ones(len(unit)), known, PARAMETERS, lambda designs: designs[:3])) == 3


@pytest.fixture
def growing(monkeypatch):
    """A study whose error is 100 over its runs."""
    runs = {f"{k}": (float(k),) for k in range(16)}

    def with_run(values):
        runs[f"{len(runs)}"] = tuple(values)
        return study, f"{len(runs) - 1}"

    variable = SimpleNamespace(stepped=float)
    study = SimpleNamespace(runs=runs, train=runs, with_run=with_run, run=lambda **running: f"summary of {len(runs)}")
    study.definition = SimpleNamespace(variables=[variable])
    monkeypatch.setattr(adaptive, "Study", SimpleNamespace(open=lambda folder: study))
    monkeypatch.setattr(adaptive, "Dataset", SimpleNamespace(open=lambda folder: SimpleNamespace(trusted=list(runs))))
    choose = lambda known: np.arange(BATCH)[:, None] + len(known)  # noqa: E731
    monkeypatch.setattr(adaptive, "_judged", lambda folder, aim: (100.0 / len(runs), choose))
    return runs


def test_it_ends_when_the_error_is_reached(growing):
    told = []
    grown = grow("study", Aim("hic15", 3.0, ""), say=told.append, workers=1, progress=None)
    stages = grown.stages
    assert grown.reached
    assert grown.summary == "summary of 40"  # of all runs, those added too
    assert told[0] == "16 runs: hic15 6.25, wanted below 3"
    assert [stage.runs for stage in stages] == [16, 24, 32, 40]
    assert stages[-1].error < 3.0 < stages[-2].error
    assert len(told) == 4
    assert b"<svg" in draw(learning_curve, stages, Aim("hic15", 3.0, ""))


@pytest.mark.parametrize(
    ("runs", "errors"),
    [((16, 24, 32, 40), (3.8, 3.6, 3.4, 3.33)), ((16, 24, 31), (0.89, 0.93, 0.69)), ((16, 400), (40.0, 2.2))],
)
def test_the_learning_curve_says_plain_numbers(runs, errors):
    axes = learning_curve(
        [adaptive.Stage(*stage) for stage in zip(runs, errors, strict=True)], Aim("hic15", 3.0, "")
    ).axes[0]
    for axis, values in ((axes.xaxis, runs), (axes.yaxis, errors)):
        said = [label.get_text() for label in (*axis.get_majorticklabels(), *axis.get_minorticklabels())]
        ticks = [float(text) for text in said if text]  # not "$\\mathdefault{2\\times10^{1}}$"
        assert len(ticks) >= 3
        low, high = sorted(axis.get_view_interval())
        assert low <= min(values)
        assert max(values) <= high
        assert all(low <= tick <= high for tick in ticks)


def test_it_ends_when_no_other_design_is_left(growing, monkeypatch):
    study = adaptive.Study.open("study")
    study.with_run = lambda values: (study, "0")  # the study has it
    grown = grow("study", Aim("hic15", 3.0, ""))
    assert not grown.reached
    assert "no other design" in grown.why


def test_it_ends_when_the_error_is_level(growing, monkeypatch):
    choose = lambda known: np.arange(BATCH)[:, None] + len(known)  # noqa: E731
    monkeypatch.setattr(adaptive, "_judged", lambda folder, aim: (10.0 + 1.0 / len(growing), choose))
    grown = grow("study", Aim("hic15", 3.0, ""))
    assert len(grown.stages) == adaptive.LEVEL_STAGES
    assert not grown.reached
    assert "level" in grown.why


def test_what_falls_slowly_but_arrives_is_no_level():
    stages = [adaptive.Stage(runs, 30.0 / runs**0.5) for runs in (16, 24, 32, 40, 48)]
    assert adaptive.out_of_reach(stages, Aim("hic15", 2.0, "")) == ""  # 225 runs
    assert "about 9e+02 runs" in adaptive.out_of_reach(stages, Aim("hic15", 1.0, ""))


def test_it_ends_when_the_time_is_over(growing):
    grown = grow("study", Aim("hic15", 1e-9, ""), hours=0.0)
    assert len(grown.stages) == 1
    assert grown.why == "0 hours are over"
    assert grown.summary is None
