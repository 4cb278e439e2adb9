"""Result folders of tank tests: curves as CSV, an [inflator] table to paste into a case, a summary, a figure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import tomli_w

from billow.apps.tank.figures import draw_evaluation, draw_prediction
from billow.apps.tank.filling import Trajectory
from billow.apps.tank.inverse import Solution
from billow.apps.tank.tank_case import TankCase
from billow.apps.tank.trace import Trace
from billow.results.atomic import whole_folder, write_atomically
from billow.results.histories import write_histories

DIGITS = 6
"""Significant digits of pasted curves: 1e-6 of the mass, far below any measurement."""


def write_prediction(case: TankCase, state: Trajectory, folder: str | Path) -> None:
    """Folder with trace.csv (which `load_trace` reads) and tank.png. Raises InputError E-RES-009 if it exists."""
    curves = {
        "time [s]": state.times,
        "pressure [Pa]": state.pressure,
        "gas temperature [K]": state.temperature,
        "mass delivered [kg]": state.mass,
        "heat to the wall [J]": state.heat,
    }
    summary = {
        "title": case.title,
        "peak_pressure": float(state.pressure.max()),
        "end_pressure": float(state.pressure[-1]),
        "end_temperature": float(state.temperature[-1]),
        "mass_delivered": float(state.mass[-1]),
        "heat_to_the_wall": float(state.heat[-1]),
    }
    _publish(folder, {"trace.csv": curves}, {"summary.toml": tomli_w.dumps(summary)}, draw_prediction(state))


def write_evaluation(case: TankCase, trace: Trace, found: Solution, folder: str | Path) -> None:
    """Folder with flow.csv, fit.csv, inflator.toml, summary.toml and tank.png.

    Raises InputError E-RES-009 if it exists.
    """
    flow = {
        "time [s]": found.knots,
        "mass flow [kg/s]": found.flow,
        "mass flow, 2.5 % [kg/s]": found.low,
        "mass flow, 97.5 % [kg/s]": found.high,
        "inflow temperature [K]": np.interp(found.knots, found.temperature.times, found.temperature.values),
        "inflow temperature, half-width [K]": np.interp(
            found.knots, found.temperature.times, found.temperature_half_width
        ),
    }
    explained = {
        "time [s]": trace.times,
        "measured pressure [Pa]": trace.pressure,
        "explained pressure [Pa]": found.state.pressure,
        "gas temperature [K]": found.state.temperature,
        "mass delivered [kg]": found.state.mass,
        "heat to the wall [J]": found.state.heat,
    }
    peak = int(np.argmax(found.flow))
    summary = {
        "title": case.title,
        "total_mass": found.mass,
        "total_mass_half_width": found.mass_half_width,
        "peak_flow": float(found.flow[peak]),
        "peak_flow_half_width": float(found.half_width[peak]),
        "time_of_peak_flow": float(found.knots[peak]),
        "pressure_noise": found.noise,
        "time_resolution": found.resolution,
        "residual_correlation": found.pattern,
    }
    texts = {"inflator.toml": inflator_table(case, found), "summary.toml": tomli_w.dumps(summary)}
    _publish(folder, {"flow.csv": flow, "fit.csv": explained}, texts, draw_evaluation(trace, found))


def inflator_table(case: TankCase, found: Solution) -> str:
    """The [inflator] table of a case, as TOML: gas, mass_flow from its start to its end, temperature."""
    flowing = np.flatnonzero(found.flow)
    first, last = max(flowing[0] - 1, 0), min(flowing[-1] + 2, len(found.knots))
    temperature = found.temperature
    if len(temperature.values) > 1:
        said = f"temperature = {_curve(temperature.times, temperature.values)}"
    else:
        said = f"temperature = {_number(temperature.values[0])}"
    gas = ", ".join(f"{name} = {share!r}" for name, share in case.inflator.gas.items())
    return (
        f"# From a tank test: {case.title}. {found.mass:.4g} kg in all, +- {found.mass_half_width:.2g} kg (95 %).\n"
        f"[inflator]\ngas = {{ {gas} }}\n"
        f"mass_flow = {_curve(found.knots[first:last], found.flow[first:last])}\n{said}\n"
    )


def _curve(times: np.ndarray, values: np.ndarray) -> str:
    return f"{{ time = [{', '.join(map(_number, times))}], value = [{', '.join(map(_number, values))}] }}"


def _number(value: float) -> str:
    return repr(float(f"{value:.{DIGITS}g}"))


def _publish(folder: str | Path, tables: dict, texts: dict[str, str], picture: bytes) -> None:
    with whole_folder(folder) as partial:
        for name, curves in tables.items():
            write_histories(partial / name, curves)
        for name, text in texts.items():
            write_atomically(partial / name, text)
        write_atomically(partial / "tank.png", picture)
