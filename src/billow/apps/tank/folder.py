"""Result folders of tank tests: curves as CSV, an [inflator] table to paste into a case, a summary, a figure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import tomli_w
from matplotlib.figure import Figure

from billow.apps.tank.filling import Trajectory
from billow.apps.tank.inverse import Solution
from billow.apps.tank.tank_case import TankCase
from billow.apps.tank.trace import Trace
from billow.base.plot_style import GREY, png, styled
from billow.results.atomic import new_folder, write_atomically
from billow.results.histories import write_histories

PRESSURE, FLOW, HEAT = "#0072b2", "#0f9d76", "#d55e00"  # told apart with any colour vision
MILLI, KILO = 1e3, 1e-3
DIGITS = 6
"""Significant digits of pasted curves: 1e-6 of the mass, far below any measurement."""


def write_prediction(case: TankCase, state: Trajectory, folder: str | Path) -> None:
    """Folder with trace.csv (which `load_trace` reads) and tank.png. Raises InputError E-RES-009 if it exists."""
    curves = {"time [s]": state.times, "pressure [Pa]": state.pressure, **_states(state)}
    summary = {
        "title": case.title,
        "peak_pressure": float(state.pressure.max()),
        "end_pressure": float(state.pressure[-1]),
        "end_temperature": float(state.temperature[-1]),
        "mass_delivered": float(state.mass[-1]),
        "heat_to_the_wall": float(state.heat[-1]),
    }
    _publish(folder, {"trace.csv": curves}, {"summary.toml": tomli_w.dumps(summary)}, _draw_prediction(state))


def write_evaluation(case: TankCase, trace: Trace, found: Solution, folder: str | Path) -> None:
    """Folder with flow.csv, fit.csv, inflator.toml, summary.toml and tank.png.

    Raises InputError E-RES-009 if it exists.
    """
    temperature = found.temperature
    flow = {
        "time [s]": found.knots,
        "mass flow [kg/s]": found.flow,
        "mass flow, 2.5 % [kg/s]": found.low,
        "mass flow, 97.5 % [kg/s]": found.high,
        "inflow temperature [K]": temperature.at(found.knots),
        "inflow temperature, half-width [K]": np.interp(found.knots, temperature.times, found.temperature_half_width),
    }
    explained = {
        "time [s]": trace.times,
        "measured pressure [Pa]": trace.pressure,
        "explained pressure [Pa]": found.state.pressure,
        **_states(found.state),
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
    _publish(folder, {"flow.csv": flow, "fit.csv": explained}, texts, _draw_evaluation(trace, found))


def inflator_table(case: TankCase, found: Solution) -> str:
    """The [inflator] table of a case, as TOML: gas, mass_flow from its start to its end, temperature."""
    flowing = np.flatnonzero(found.flow)
    first, last = max(flowing[0] - 1, 0), min(flowing[-1] + 2, len(found.knots))
    temperature = found.temperature
    varies = len(temperature.values) > 1
    said = _curve(temperature.times, temperature.values) if varies else _number(temperature.values[0])
    gas = ", ".join(f"{name} = {share!r}" for name, share in case.inflator.gas.items())
    return (
        f"# From a tank test: {case.title}. {found.mass:.4g} kg in all, +- {found.mass_half_width:.2g} kg (95 %).\n"
        f"[inflator]\ngas = {{ {gas} }}\n"
        f"mass_flow = {_curve(found.knots[first:last], found.flow[first:last])}\ntemperature = {said}\n"
    )


def _states(state: Trajectory) -> dict[str, np.ndarray]:
    curves = (state.temperature, state.mass, state.heat)
    return dict(zip(("gas temperature [K]", "mass delivered [kg]", "heat to the wall [J]"), curves, strict=True))


def _curve(times: np.ndarray, values: np.ndarray) -> str:
    return f"{{ time = [{', '.join(map(_number, times))}], value = [{', '.join(map(_number, values))}] }}"


def _number(value: float) -> str:
    return repr(float(f"{value:.{DIGITS}g}"))


def _publish(folder: str | Path, tables: dict, texts: dict[str, str], picture: bytes) -> None:
    with new_folder(folder) as partial:
        for name, curves in tables.items():
            write_histories(partial / name, curves)
        for name, text in texts.items():
            write_atomically(partial / name, text)
        write_atomically(partial / "tank.png", picture)


def _draw_prediction(state: Trajectory) -> bytes:
    """Pressure, temperature and mass flow of a prediction, as PNG."""
    with styled():
        figure, (left, middle, right) = _panels(3)
        time = state.times * MILLI
        left.plot(time, state.pressure * KILO, color=PRESSURE)
        left.set(title="Pressure, absolute [kPa]", ylim=(0, None))
        middle.plot(time, state.temperature, color=HEAT)
        middle.set(title="Gas temperature [K]")
        right.plot(time, state.mass * MILLI, color=FLOW)
        right.set(title="Mass delivered [g]", ylim=(0, None))
        return png(figure)


def _draw_evaluation(trace: Trace, found: Solution) -> bytes:
    """Measured and fitted pressure, residual, mass flow and temperature of the inflow, as PNG."""
    with styled():
        figure, ((pressure, flow), (rest, temperature)) = _panels(2, rows=2)
        time, knots = trace.times * MILLI, found.knots * MILLI
        pressure.plot(time, trace.pressure * KILO, color=GREY, lw=0.8, label="measured")
        pressure.plot(time, found.state.pressure * KILO, color=PRESSURE, label="from the flow found")
        pressure.set(title="Pressure, absolute [kPa]", ylim=(0, None))
        pressure.legend(loc="lower right")
        flow.fill_between(knots, found.low, found.high, color=FLOW, alpha=0.22, lw=0, label="95 %")
        flow.plot(knots, found.flow, color=FLOW, label="estimate")
        flow.set(title=f"Mass flow [kg/s], {found.mass * MILLI:.4g} g in all", ylim=(0, None))
        flow.legend(loc="upper right")
        rest.plot(time, trace.pressure - found.state.pressure, color=GREY, lw=0.8)
        for sign in (-1.0, 1.0):
            rest.axhline(sign * found.noise, color=PRESSURE, lw=0.9, ls=":")
        rest.set(title=f"Measured minus explained [Pa], noise {found.noise:.0f} Pa")
        _draw_temperatures(temperature, trace, found)
        return png(figure)


def _draw_temperatures(axes, trace: Trace, found: Solution) -> None:
    time, inflow, half = trace.times * MILLI, found.temperature, found.temperature_half_width
    # The ends of the curve last: it is constant outside its times.
    at = np.unique(np.concatenate([trace.times[[0, -1]], inflow.times]))
    value, spread = (np.interp(at, inflow.times, y) for y in (inflow.values, half))
    axes.fill_between(at * MILLI, value - spread, value + spread, color=HEAT, alpha=0.22, lw=0)
    axes.plot(at * MILLI, value, color=HEAT, label="inflow, total")
    if trace.gas_temperature is not None:
        axes.plot(time, trace.gas_temperature, color=GREY, lw=0.8, label="gas, measured")
    axes.plot(time, found.state.temperature, color=PRESSURE, label="gas in the tank")
    top = max(found.state.temperature.max(), np.median(value + spread), value.max())
    axes.set(title="Temperature [K]", ylim=(min(found.state.temperature.min(), value.min()) - 50.0, 1.1 * top))
    axes.legend(loc="lower right")


def _panels(columns: int, rows: int = 1):
    figure = Figure(figsize=(9.2, 2.9 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True)
    for one in np.atleast_2d(axes)[-1]:
        one.set_xlabel("time [ms]")
    return figure, axes
