"""Prediction and evaluation of a tank test as its case describes it: which temperature is known, and which values are
uncertain."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from billow.apps.tank import inverse
from billow.apps.tank.filling import Trajectory, predict
from billow.apps.tank.inverse import Solution
from billow.apps.tank.tank_case import NOT_GIVEN, TankCase
from billow.apps.tank.trace import Trace, check_trace, load_trace
from billow.base.errors import Concern

CORRELATED_RESIDUALS = Concern.declare(
    "W-TANK-001",
    "neighbouring residuals are correlated by {correlation:.2f}",
    where="the trace",
    why="the band holds for independent noise: a filtered or ringing signal, or a loss that the case lacks, makes it "
    "too narrow",
    remedy="give every n-th row of the trace, so that filtered noise is independent, or correct the loss to the wall",
)
OTHER_MASS = Concern.declare(
    "W-TANK-002",
    "{found:.4g} kg were found, {weighed:.4g} kg were weighed",
    where="inflator.total_mass",
    why="temperature, volume, composition or loss to the wall do not fit the weight",
    remedy="leave out temperature to have it found from the weight, or correct what is wrong",
)

PATTERN = 0.3
"""Correlation of neighbouring residuals that white noise of a hundred rows exceeds once in a thousand traces."""


def predict_case(case: TankCase) -> Trajectory:
    """The test a case describes, from ignition. Raises InputError E-TANK-012 without mass flow or temperature."""
    temperature, curve = case.inflow_temperature, case.inflator.mass_flow
    if temperature is None or curve is None:
        lacks = f"the {'temperature' if temperature is None else 'mass flow'} of the inflow"
        raise NOT_GIVEN(quantity=lacks, table="inflator", why="a prediction needs mass_flow and temperature")
    count = max(round(case.forward.end_time / case.forward.step), 1)
    times = np.linspace(0.0, case.forward.end_time, count + 1)
    flow_times = np.array(curve.time) + case.inflator.delay
    return predict(case.make_tank(), times, flow_times, np.array(curve.value), temperature)


def measured(case: TankCase, path: str | Path) -> Trace:
    """The trace in a CSV file, checked against the case. Raises the InputErrors of `load_trace` and `check_trace`, and
    E-TANK-012 if the case does not say what the pressure is measured from."""
    how = case.measurement
    if how.pressure is None:
        raise NOT_GIVEN(
            quantity="whether the pressure is absolute or gauge",
            table="measurement",
            why="it decides how much gas there was at the start",
            remedy='add pressure = "absolute" or pressure = "gauge" to [measurement]',
        )
    gauge = how.ambient_pressure if how.pressure == "gauge" else 0.0
    trace = load_trace(path, gauge, how.end_time)
    check_trace(trace, case.tank.pressure, case.tank.heat_transfer * case.tank.wall_area > 0.0, str(path))
    return trace


def evaluate(case: TankCase, trace: Trace) -> Solution:
    """Mass flow of a test; its band includes noise, smoothing and the uncertainties of the case.

    The temperature of the inflow is that of the case; else it follows from total_mass, else from the gas temperature of
    the trace. Raises InputError E-TANK-012 if none of these is given, E-TANK-013 if total_mass is impossible.
    """
    temperature, total, how = case.inflow_temperature, case.inflator.total_mass, case.measurement
    weighed = temperature is None and total is not None
    known, solve = (total, inverse.flow_of_total_mass) if weighed else (temperature, inverse.flow_of_temperature)
    if known is None and trace.gas_temperature is None:
        raise NOT_GIVEN(
            quantity="the temperature of the inflow, or what it can be found from,",
            table="inflator",
            why="pressure alone tells the enthalpy that flows in, not how much gas carries it",
            remedy="add temperature or total_mass to [inflator], or a column gas temperature [K] to the trace",
        )

    def solved(tank, known, smoothing=None) -> Solution:
        return inverse.flow_of_gas_temperature(tank, trace) if known is None else solve(tank, trace, known, smoothing)

    tank, others = case.make_tank(), []
    best = solved(tank, known)
    # What is uncertain moves the flow as a whole: one solution for each tells by how much.
    if weighed:
        # The weighed mass is known; the precision with which the pressure determines a mass is that of the temperature.
        others.append(total + float(np.hypot(best.mass_half_width, how.mass_uncertainty)))
    elif known is not None and how.temperature_uncertainty:
        others.append(replace(temperature, values=temperature.values + how.temperature_uncertainty))
    changes = [solved(tank, other, best.smoothing) for other in others]
    if how.volume_uncertainty:
        changes.append(solved(case.make_tank(-how.volume_uncertainty), known, best.smoothing))
    if weighed:
        best = replace(best, mass_half_width=how.mass_uncertainty)
        changes = [replace(change, mass=total) for change in changes]
    return inverse.with_uncertainty(best, changes)


def warnings(case: TankCase, trace: Trace, found: Solution) -> list[Concern]:
    """Reasons to doubt the flow or the band of an evaluation."""
    made = []
    if found.pattern > PATTERN and found.noise > 1e-4 * np.ptp(trace.pressure):
        made.append(CORRELATED_RESIDUALS(correlation=found.pattern))
    weighed, how = case.inflator.total_mass, case.measurement
    if weighed is not None and abs(found.mass - weighed) > np.hypot(found.mass_half_width, how.mass_uncertainty):
        made.append(OTHER_MASS(found=found.mass, weighed=weighed))
    return made
