"""What a user does: predict, measure, evaluate, paste; and what traces may look like."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from billow.apps.tank.tank_case import TankCase
from billow.apps.tank.trace import MOST_ROWS, Trace, check_trace, load_trace
from billow.base.errors import InputError
from billow.case.schema import Case
from billow.cli.tank import app
from billow.results.histories import read_histories

EXAMPLES = Path(__file__).parents[2] / "examples" / "tank"


def billow_tank(*arguments: object) -> str:
    ran = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if ran.exception is not None and not isinstance(ran.exception, SystemExit):
        raise ran.exception
    assert ran.exit_code == 0, ran.output
    return ran.output


def test_forward_then_inverse_without_noise(tmp_path):
    billow_tank("forward", EXAMPLES / "tank_test.toml", "--out", tmp_path / "predicted")
    case = (EXAMPLES / "tank_test.toml").read_text(encoding="utf-8")
    for old, new in (('"gauge"', '"absolute"'), ("uncertainty = 20.0", "uncertainty = 0.0"), ('"0.1 l"', "0.0")):
        assert old in case
        case = case.replace(old, new)
    (tmp_path / "case.toml").write_text(case)
    trace = tmp_path / "predicted" / "trace.csv"
    said = billow_tank("inverse", trace, "--case", tmp_path / "case.toml", "--out", tmp_path / "found")
    assert "mass 50 g" in said
    pasted = tomllib.loads((tmp_path / "found" / "inflator.toml").read_text())
    deployment = Case.from_dict(pasted)
    flow = deployment.inflator.mass_flow
    assert np.trapezoid(flow.value, flow.time) == pytest.approx(0.05, rel=1e-4)
    true = np.interp(np.array(flow.time) - 0.003, [0.0, 0.008, 0.050], [0.0, 2.0, 0.0])
    assert np.abs(np.array(flow.value) - true).max() <= 0.01 * 2.0
    assert deployment.inflator.temperature == 650.0


def test_the_measured_example(tmp_path):
    files = (EXAMPLES / "tank_measured.csv", "--case", EXAMPLES / "tank_test.toml")
    billow_tank("inverse", *files, "--out", tmp_path / "found")
    summary = tomllib.loads((tmp_path / "found" / "summary.toml").read_text())
    assert summary["total_mass"] == pytest.approx(0.050, abs=summary["total_mass_half_width"])
    curves = read_histories(tmp_path / "found" / "flow.csv")
    true = np.interp(curves["time [s]"] - 0.003, [0.0, 0.008, 0.050], [0.0, 2.0, 0.0])
    low, high = curves["mass flow, 2.5 % [kg/s]"], curves["mass flow, 97.5 % [kg/s]"]
    assert np.mean((low <= true) & (true <= high)) >= 0.90
    assert (tmp_path / "found" / "tank.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InputError, match="E-RES-009"):
        billow_tank("inverse", *files, "--out", tmp_path / "found")
    assert not list(tmp_path.glob("*.partial"))


def test_help_teaches():
    assert "tank_measured.csv" in billow_tank("--help")


def write(path: Path, header: str, *columns: np.ndarray) -> Path:
    rows = "\n".join(",".join(map(repr, row)) for row in np.stack(columns, axis=1).tolist())
    path.write_text(f"{header}\n{rows}\n")
    return path


def test_units_order_and_gauge(tmp_path):
    time, pressure = np.linspace(-0.01, 0.1, 111), np.linspace(0.0, 2e5, 111)
    first = load_trace(write(tmp_path / "a.csv", "time [s],pressure [Pa]", time, pressure), gauge=1e5)
    second = load_trace(
        write(tmp_path / "b.csv", "x,Pressure [bar],Time [ms]", time, pressure / 1e5, 1e3 * time), gauge=1e5
    )
    assert first.times == pytest.approx(second.times)
    assert first.pressure == pytest.approx(second.pressure)
    assert first.times[0] >= 0.0
    assert first.rest == pytest.approx(1e5 + pressure[time < 0.0].mean())


def test_a_long_trace_is_averaged_over_blocks(tmp_path):
    """Means over six rows are exact for a line, and have noise smaller by the root of six (2,000 of them: 5 %)."""
    time = np.linspace(0.0, 0.1, 10_001)
    noise = 1000.0 * np.random.default_rng(0).standard_normal(len(time))
    trace = load_trace(write(tmp_path / "long.csv", "time [s],pressure [Pa]", time, 1e5 + 1e6 * time + noise))
    assert 1000 < len(trace.times) <= MOST_ROWS
    assert np.ptp(np.diff(trace.times)) < 1e-12
    left = trace.pressure - 1e5 - 1e6 * trace.times
    assert left.std() == pytest.approx(1000.0 / np.sqrt(6.0), rel=0.05)


def test_a_trace_may_begin_after_ignition():
    """Without a row at ignition nothing tells whether the start pressure is right: the trace is taken as it is."""
    times = np.linspace(0.002, 0.1, 200)
    check_trace(Trace(times, 101325.0 + 2e5 * (1.0 - np.exp(-times / 0.01))), 101325.0, False, "a trace")


def test_a_delay_moves_flow_and_temperature():
    tables = {"tank": {"volume": "60 l"}, "inflator": {"gas": {"N2": 1.0}, "delay": "5 ms"}}
    tables["inflator"]["temperature"] = {"time": [0.0, 0.02], "value": [900.0, 600.0]}
    case = TankCase.from_dict(tables)
    assert case.tank.volume == pytest.approx(0.06)
    assert case.inflow_temperature.times == pytest.approx([0.005, 0.025])
