"""Figures of a tank test: measurement, fit, and the inflow with its band."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from billow.apps.tank.filling import Trajectory
from billow.apps.tank.inverse import Solution
from billow.apps.tank.trace import Trace
from billow.base.plot_style import GREY, STYLE, png

PRESSURE, FLOW, HEAT = "#0072b2", "#0f9d76", "#d55e00"  # told apart with any colour vision
MILLI, KILO = 1e3, 1e-3


def draw_prediction(state: Trajectory) -> bytes:
    """Pressure, temperature and mass flow of a prediction, as PNG."""
    with matplotlib.rc_context(STYLE):
        figure, (left, middle, right) = _panels(3)
        time = state.times * MILLI
        left.plot(time, state.pressure * KILO, color=PRESSURE)
        left.set(title="Pressure, absolute [kPa]", ylim=(0, None))
        middle.plot(time, state.temperature, color=HEAT)
        middle.set(title="Gas temperature [K]")
        right.plot(time, state.mass * MILLI, color=FLOW)
        right.set(title="Mass delivered [g]", ylim=(0, None))
        return png(figure)


def draw_evaluation(trace: Trace, found: Solution) -> bytes:
    """Measured and fitted pressure, residual, mass flow and temperature of the inflow, as PNG."""
    with matplotlib.rc_context(STYLE):
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
