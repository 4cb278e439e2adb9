"""A run that goes on can be watched: status.json, histories so far, contacts in its log; nothing of it remains."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from billow.cli.main import app
from billow.cli.watch import chambers, is_frame, table
from billow.pictures.source import is_running, open_source
from billow.results import journal as journals
from billow.results.journal import JOURNAL, STATUS, Journal, history_so_far
from billow.run import status as statuses
from billow.run.recorder import LOG_HEADER, fitted
from billow.run.simulate import simulate


def test_a_run_that_goes_on_says_how_far_it_is_and_can_be_drawn(small_case, tmp_path, monkeypatch):
    monkeypatch.setattr(statuses, "EVERY", 0.0)
    seen = []

    def look(progress):
        if progress.status is None:
            return
        told = json.loads((tmp_path / "run.partial" / STATUS).read_text())
        curves = open_source(tmp_path / "run", "plot").histories
        seen.append((told, curves.time[-1], is_running(tmp_path / "run"), progress.status))

    result = simulate(small_case, tmp_path / "run", progress=look)
    assert len(seen) == 7  # every row of histories
    for told, last, running, status in seen:
        assert running
        assert told["time_s"] == last == told["values"]["time [s]"]
        assert told["end_s"] == 0.015
        assert told == json.loads(json.dumps(status).replace("NaN", "null"))
    assert seen[0][0]["seconds_to_go"] is None
    assert seen[-1][0]["seconds_to_go"] == 0.0
    assert "triangle" in seen[0][0]["limited_by"]
    assert not is_running(tmp_path / "run")
    assert not (tmp_path / "run" / STATUS).exists()
    assert open_source(tmp_path / "run", "plot").result.status == result.status


def test_the_first_contact_with_a_body_is_said_once(small_run):
    log = (small_run.folder / "solver.log").read_text()
    told = [line for line in log.splitlines() if line.startswith("contact: the bag touches impactor")]
    assert len(told) == 1
    force = np.linalg.norm(small_run.body("impactor").force, axis=1)
    first = small_run.histories.time[np.flatnonzero(force)[0]]
    assert f"at {1e3 * first:.3f} ms" in told[0]


def test_histories_are_read_up_to_the_first_piece_that_is_not_whole(tmp_path):
    journal = Journal(tmp_path / JOURNAL)
    journal.columns(["time [s]", "force [N]"])
    for k in range(3):
        journal.row(np.array([float(k), 2.0 * k]))
        journal.frame({"time": np.zeros(1)})
    journal.close()
    whole = (tmp_path / JOURNAL).read_bytes()
    assert history_so_far(tmp_path / JOURNAL).time.tolist() == [0.0, 1.0, 2.0]
    assert journals.read_history(tmp_path / JOURNAL).keys() == history_so_far(tmp_path / JOURNAL).keys()
    lengths = set()
    for cut in range(0, len(whole), 7):
        (tmp_path / JOURNAL).write_bytes(whole[:cut])
        lengths.add(len(history_so_far(tmp_path / JOURNAL).get("time [s]", ())))
    assert lengths == {0, 1, 2, 3}


def test_the_table_shows_gas_bodies_and_energies(small_case, tmp_path, monkeypatch):
    monkeypatch.setattr(statuses, "EVERY", 0.0)
    shown = []
    simulate(small_case, tmp_path / "run", progress=lambda p: p.status and shown.append(p.status))
    console = Console(file=io.StringIO(), width=100)
    console.print(table(shown[-1]))
    text = console.file.getvalue()
    assert "15.00 of 15 ms" in text
    assert "impactor" in text
    assert "impactor_obstacle" not in text
    pressure = shown[-1]["values"]["pressure [Pa]"]
    assert f"{1e-3 * pressure:.4g}" in text
    assert "kinetic" in text
    assert chambers({"a_volume [m^3]": 1.0, "b_volume [m^3]": 1.0, "volume [m^3]": 2.0}) == ["a", "b"]


def test_lines_of_the_log_keep_their_columns(small_run):
    log = (small_run.folder / "solver.log").read_text().splitlines()
    frames = [line for line in log if is_frame(line)]
    assert frames[0] == LOG_HEADER
    assert len(frames) >= 5
    assert {len(line) for line in frames} == {len(LOG_HEADER)}
    assert len(LOG_HEADER) <= 100
    for value in (0.0, -0.0, 1e-9, -123456.789, 1e7, -1e-7, 99.99999, float("nan"), float("-inf")):
        assert len(fitted(value, 6)) == 6
        assert float(fitted(value, 6)) == pytest.approx(value, rel=0.2, nan_ok=True)
    assert not is_frame("612 triangles, 300 nodes, fabric 0.2 kg; triangle 3 (front) and its neighbours limit the step")


def test_the_end_of_a_run_tells_its_peaks(small_case, tmp_path):
    (tmp_path / "case.toml").write_text(small_case.to_toml())
    out = CliRunner().invoke(app, ["run", str(tmp_path / "case.toml"), "--out", str(tmp_path / "run")]).output
    assert "largest pressure" in out
    assert out.splitlines()[-1].endswith("completed")
