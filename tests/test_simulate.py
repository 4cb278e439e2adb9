"""A run from case to folder: complete, readable, balanced; and what is left when it does not get that far."""

from __future__ import annotations

import hashlib
import json
import signal

import numpy as np
import pytest

from billow.base.errors import InputError, NumericalStop, ResourceError
from billow.case.schema import Case
from billow.results.result import Result
from billow.run.simulate import simulate
from billow.solver import run as run_module

BRIEF = {"bag": {"element_size": 0.05}, "run": {"end_time": 0.001, "frames": 4, "histories_per_frame": 2}}


@pytest.fixture(scope="module")
def brief():
    return Case.from_dict(BRIEF)


def test_the_folder_is_complete(small_run, small_case):
    names = {path.name for path in small_run.folder.iterdir()}
    assert {"case.toml", "fabric.vtkhdf", "histories.csv", "run.json", "solver.log"} <= names
    assert not [name for name in names if "partial" in name or "checkpoint" in name or "journal" in name]
    assert not small_run.folder.with_name("run.partial").exists()
    record = json.loads((small_run.folder / "run.json").read_text())
    assert record["status"] == "completed"
    assert record["reason"] is None
    assert record["case_digest"] == small_case.digest()
    assert record["simulated_time"] == 0.015
    assert record["steps"] > 500
    for name, expected in record["files"].items():
        assert hashlib.sha256((small_run.folder / name).read_bytes()).hexdigest() == expected
    assert Case.load(small_run.folder / "case.toml") == small_case
    log = (small_run.folder / "solver.log").read_text()
    assert "612 triangles" in log
    assert "completed: mass error" in log


def test_the_result_reads_back(small_run):
    result = Result.open(small_run.folder)
    assert result.times == pytest.approx([0.0, 0.005, 0.010, 0.015], rel=1e-15)
    nodes, triangles = len(result.reference), len(result.triangles)
    assert (nodes, triangles) == (308, 612)
    assert result.displacement.shape == result.contact_force.shape == (4, nodes, 3)
    assert result.gauge_pressure.shape == (4, triangles)
    assert not result.displacement[0].any()
    assert result.displacement[-1, :, 2].max() > 0.1  # it inflated
    curves = result.histories
    assert curves["time [s]"] == pytest.approx(np.linspace(0.0, 0.015, 7), abs=1e-17)
    assert curves["volume [m^3]"][-1] > 20.0 * curves["volume [m^3]"][0]
    assert result.gauge_pressure[-1] == pytest.approx(curves["pressure [Pa]"][-1] - 101325.0, rel=1e-5)
    # What the nodes get from the impactor, it gets back.
    force = [curves[f"impactor_force_{axis} [N]"][-1] for axis in "xyz"]
    assert force[2] > 100.0
    assert -result.contact_force[-1].sum(axis=0) == pytest.approx(force, abs=1e-4 * force[2])


def test_the_ledger_is_within_its_limits(small_run):
    ledger = small_run.record["ledger"]
    assert ledger["gas_mass_error"] <= 1e-12
    assert ledger["gas_energy_error"] <= 1e-12
    assert 0.0 < ledger["energy_residual_of_injected"] <= 0.02
    assert ledger["injected_mass_kg"] == pytest.approx(0.5 * 0.008 * 2.0 + 0.007 * (2.0 - 0.5 * 0.007 / 0.042 * 2.0))
    assert ledger["jet_impulse_delivered"] == 1.0


def test_the_same_case_gives_the_same_bytes(brief, tmp_path):
    one, two = simulate(brief, tmp_path / "one"), simulate(brief, tmp_path / "two")
    for name in ("case.toml", "fabric.vtkhdf", "histories.csv"):
        assert one.record["files"][name] == two.record["files"][name], name


def test_progress_is_told(brief, tmp_path):
    told = []
    simulate(brief, tmp_path / "run", progress=told.append)
    times = [p.time for p in told]
    assert times == sorted(times)
    for frame in (0.0, 2.5e-4, 5e-4, 7.5e-4, 1e-3):  # and each second
        assert min(abs(time - frame) for time in times) < 1e-9
    assert all(p.end == 0.001 for p in told)


def test_a_result_is_never_overwritten(brief, tmp_path):
    folder = simulate(brief, tmp_path / "run").folder
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(InputError, match="E-RES-009") as caught:
        simulate(brief, folder)
    assert str(folder) in caught.value.where
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match="E-RES-009"):
        simulate(brief, tmp_path / "file")


def test_an_empty_folder_may_be_used(brief, tmp_path):
    (tmp_path / "run").mkdir()
    assert simulate(brief, tmp_path / "run").status == "completed"


def test_a_folder_that_cannot_be_made(brief, tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(ResourceError, match="E-RES-020") as caught:
        simulate(brief, tmp_path / "file" / "run")
    assert caught.value.exit_code == 4
    assert str(tmp_path / "file") in caught.value.where


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"bag.vents.distance": 0.34}, "E-GEO-010"),
        ({"inflator.gas": {"Xe": 1.0}}, "E-GAS-001"),
        ({"obstacles.plate.height": 0.01}, "E-GEO-020"),
    ],
)
def test_nothing_is_left_of_a_case_that_cannot_be_run(brief, tmp_path, changes, code):
    with pytest.raises(InputError, match=code):
        simulate(brief.vary(changes), tmp_path / "run")
    assert list(tmp_path.iterdir()) == []


def test_a_stopped_run_is_published_with_its_reason(brief, tmp_path, monkeypatch):
    check, seen = run_module.check_state, []

    def spoil(model, state, *others):
        if state.step == 25:
            state.velocities[7] = np.nan
        seen.append(state.step)
        check(model, state, *others)

    monkeypatch.setattr(run_module, "check_state", spoil)
    with pytest.raises(NumericalStop, match="E-NUM-001"):
        simulate(brief, tmp_path / "run")
    assert seen[-1] == 26
    result = Result.open(tmp_path / "run")
    assert result.status == "stopped"
    assert "E-NUM-001" in result.record["reason"]
    assert result.record["steps"] == 26
    assert 2 <= len(result.times) < 5  # the frames up to then
    assert np.isfinite(result.displacement).all()
    assert list(tmp_path.iterdir()) == [result.folder]


@pytest.mark.parametrize("by", ["signal", "exception"])
def test_an_interrupted_run_leaves_what_it_has(brief, tmp_path, by):
    pending = [signal.SIGINT]

    def interrupt(progress):
        if progress.time > 2e-4 and pending:  # after the first frame
            pending.clear()
            if by == "exception":
                raise KeyboardInterrupt
            signal.raise_signal(signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        simulate(brief, tmp_path / "run", progress=interrupt)
    assert signal.getsignal(signal.SIGINT) is before
    assert not (tmp_path / "run").exists()
    left = Result.open(tmp_path / "run.partial")
    assert left.status == "interrupted"
    assert 2 <= len(left.times) < 5
    assert np.isfinite(left.displacement).all()
    assert left.histories["time [s]"][-1] > 0.0
