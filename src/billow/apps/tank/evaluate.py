"""Evaluation of a tank test as its case describes it: which temperature is known, and which values are uncertain."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from billow.apps.tank.inverse import (
    Solution,
    flow_of_gas_temperature,
    flow_of_temperature,
    flow_of_total_mass,
    with_uncertainty,
)
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
    tank, smaller = case.make_tank(), case.make_tank(-how.volume_uncertainty)
    changes = []  # what is uncertain moves the flow as a whole: one solution for each tells by how much
    if temperature is not None:
        best = flow_of_temperature(tank, trace, temperature)
        if how.temperature_uncertainty:
            warmer = temperature.raised(how.temperature_uncertainty)
            changes.append(flow_of_temperature(tank, trace, warmer, best.smoothing))
        if how.volume_uncertainty:
            changes.append(flow_of_temperature(smaller, trace, temperature, best.smoothing))
    elif total is not None:
        best = flow_of_total_mass(tank, trace, total)
        # The weighed mass is known; the precision with which the pressure determines a mass is that of the temperature.
        heavier = total + float(np.hypot(best.mass_half_width, how.mass_uncertainty))
        changes.append(flow_of_total_mass(tank, trace, heavier, best.smoothing))
        if how.volume_uncertainty:
            changes.append(flow_of_total_mass(smaller, trace, total, best.smoothing))
        best = replace(best, mass_half_width=how.mass_uncertainty)
        changes = [replace(change, mass=total) for change in changes]
    elif trace.gas_temperature is not None:
        best = flow_of_gas_temperature(tank, trace)
        if how.volume_uncertainty:
            changes.append(flow_of_gas_temperature(smaller, trace))
    else:
        raise NOT_GIVEN(
            quantity="the temperature of the inflow, or what it can be found from,",
            table="inflator",
            why="pressure alone tells the enthalpy that flows in, not how much gas carries it",
            remedy="add temperature or total_mass to [inflator], or a column gas temperature [K] to the trace",
        )
    return with_uncertainty(best, changes)


def warnings(case: TankCase, trace: Trace, found: Solution) -> list[Concern]:
    """Reasons to doubt the flow or the band of an evaluation."""
    made = []
    if found.pattern > PATTERN and found.noise > 1e-4 * np.ptp(trace.pressure):
        made.append(CORRELATED_RESIDUALS(correlation=found.pattern))
    weighed, how = case.inflator.total_mass, case.measurement
    if weighed is not None and abs(found.mass - weighed) > np.hypot(found.mass_half_width, how.mass_uncertainty):
        made.append(OTHER_MASS(found=found.mass, weighed=weighed))
    return made
