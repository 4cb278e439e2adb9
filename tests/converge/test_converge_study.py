"""A convergence study of a real case, as small as it can be: runs once, says the same twice, and goes on."""

from __future__ import annotations

import csv
import json
import tomllib

import pytest

from billow.apps.converge import sweep as sweeps
from billow.apps.converge.study import report, run_study
from billow.apps.converge.sweep import Sweep
from billow.base.errors import InputError, NumericalStop
from billow.case.schema import Case

TINY = {
    "gas": {"model": "corpuscular"},
    "bag": {"element_size": 0.05, "initial_gap": 0.03},
    "obstacles": [
        {"shape": "plate"},
        {"shape": "super-ellipsoid", "name": "head", "clearance": 0.031, "locked": False},
    ],
    "run": {"end_time": 0.002, "frames": 2, "histories_per_frame": 5},
}


def quiet(*_) -> None:
    pass


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("converge") / "out"
    sweep = Sweep.of(Case.from_dict(TINY), [2e3, 1e3], 2)
    return sweep, folder, run_study(sweep, folder, 0.02, quiet)


def test_every_quantity_is_compared_and_told(study):
    _, folder, found = study
    names = [one.quantity.name for one in found]
    assert names[:2] == ["pressure [Pa]", "volume [m^3]"]
    assert names[-1] == "shape at the end [m]"
    assert all((one.noise > 0.0).all() for one in found)
    rows = list(csv.reader((folder / "convergence.csv").open()))
    assert len(rows) == 1 + 2 * len(found)
    summary = tomllib.loads((folder / "summary.toml").read_text())
    assert set(summary["quantities"]) == set(names)
    assert "pressure" in report(found, 0.02)
    for picture in ("errors.png", "curves.png", "shapes.png"):
        assert (folder / picture).read_bytes().startswith(b"\x89PNG")


def test_what_is_there_is_not_run_again(study, monkeypatch):
    sweep, folder, before = study
    monkeypatch.setattr(sweeps, "simulate", None)
    after = run_study(sweep, folder, 0.02, quiet)
    assert [one.deviation.tolist() for one in after] == [one.deviation.tolist() for one in before]


def test_another_case_is_refused(study):
    _, folder, _ = study
    other = Sweep.of(Case.from_dict(TINY).vary({"fabric.permeability": 0.01}), [1e3, 2e3], 2)
    with pytest.raises(InputError, match="E-CONV-003"):
        run_study(other, folder, 0.02, quiet)


def test_a_stopped_run_is_left_out_and_named(study, monkeypatch):
    sweep, folder, _ = study
    real = sweeps.Result.open

    def stopped(path):
        result = real(path)
        if path.name == "1000_seed2":
            return sweeps.Result(path, result.record | {"status": "stopped", "reason": "E-NUM-003"})
        return result

    monkeypatch.setattr(sweeps.Result, "open", stopped)
    with pytest.raises(NumericalStop, match="E-NUM-007"):  # one count of two is left
        run_study(sweep, folder, 0.02, quiet)


@pytest.mark.parametrize(("counts", "seeds"), [([1e3], 3), ([1e3, 1000.2], 3), ([1e3, 2e3], 1)])
def test_nothing_to_compare(counts, seeds):
    with pytest.raises(InputError, match="E-CONV-001"):
        Sweep.of(Case.from_dict(TINY), counts, seeds)


def test_a_count_out_of_range_is_refused_before_the_first_run():
    with pytest.raises(InputError, match="E-CASE-005"):
        Sweep.of(Case.from_dict(TINY), [10, 1e3], 2)


def test_runs_differ_in_count_and_seed_alone():
    sweep = Sweep.of(Case.from_dict(TINY), [1e3, 2e3], 2)
    one, two = (json.loads(json.dumps(sweep.case_of(n, s).to_dict())) for n, s in ((1000, 1), (2000, 2)))
    assert one["gas"].pop("particles") == 1000
    assert two["gas"].pop("seed") == 2
    del one["gas"]["seed"], two["gas"]["particles"]
    assert one == two
