"""`billow paper --gas`: one case by several gases, a column for each."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from billow.cli.main import app
from billow.results.result import Result
from billow.run.simulate import simulate


@pytest.fixture(scope="module")
def runs(small_case, tmp_path_factory):
    folder = tmp_path_factory.mktemp("gases")
    brief = small_case.vary({"bag.initial_gap": 0.04, "run.end_time": 0.001})
    cases = {"uniform": brief} | {
        f"mesh{cell}": brief.vary({"gas.model": "mesh", "gas.cell": cell}) for cell in (0.06, 0.08)
    }
    return [simulate(case, folder / name, threads=1).folder for name, case in cases.items()]


def test_a_column_for_each_run(runs, tmp_path):
    told = [text for run in runs for text in ("--gas", str(run))]
    done = CliRunner().invoke(app, ["paper", "--out", str(tmp_path / "out"), *told])
    assert done.exit_code == 0, done.output
    table = json.loads((tmp_path / "out" / "gases.json").read_text())
    assert list(table) == ["1: uniform pressure", "2: mesh, 60 mm", "3: mesh, 80 mm"]
    for run, row in zip(runs, table.values(), strict=True):
        h = Result.open(run).histories
        assert row["volume_l"] == pytest.approx(1e3 * h["volume [m^3]"][-1])
        assert row["outgoing_g"] == pytest.approx(1e3 * h["vented [kg]"][-1])
        assert row["highest_kPa"] == pytest.approx(1e-3 * (h["pressure [Pa]"].max() - 101325.0))
    first, second, third = (row["apart_percent"] for row in table.values())
    assert first == 0.0
    assert second > 0.0
    assert second != third
    page = (tmp_path / "out" / "gases.md").read_text()
    assert page.count("\n| ") >= 4
    assert (tmp_path / "out" / "gases.png").stat().st_size > 10_000
