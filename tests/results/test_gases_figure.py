"""`billow paper --gas`: one case by several gases, a column for each."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from billow.cli.main import app
from billow.injury.filters import channel_filter
from billow.reproductions.gas_paper.gases import write_gases
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


def test_what_the_bag_strikes_has_its_curves_and_times_stand_beside_the_papers(runs, tmp_path):
    """A free obstacle adds its highest acceleration and last velocity; a case of the paper adds what the paper took."""
    results = [Result.open(run) for run in runs[:2]]
    for result in results:
        result.case_toml["title"] = "Flat driver bag"
        assert result.free_obstacles
    write_gases(tmp_path, results)
    for result, row in zip(results, json.loads((tmp_path / "gases.json").read_text()).values(), strict=True):
        name, h = result.free_obstacles[0], result.histories
        assert row["velocity_m_s"] == pytest.approx(h[f"{name}_velocity_z [m/s]"][-1])
        filtered = channel_filter(h["time [s]"], h[f"{name}_acceleration_z [m/s^2]"], 60)
        assert row["acceleration_m_s2"] == pytest.approx(filtered.max())
    page = (tmp_path / "gases.md").read_text()
    later, h = results[0].times[-1] * 2.0 / 3.0, results[0].histories
    volume = 1e3 * np.interp(later, h["time [s]"], h["volume [m^3]"])
    line = next(line for line in page.splitlines() if line.startswith("| volume [l], 1: uniform pressure |"))
    assert line.split(" | ")[3] == f"{volume:.3g}"
    assert f" | {results[0].record['processor_seconds']:.0f} | 1 | 2,546 |" in page
    assert "2,546 |" in page
    assert "110,050 |" in page
