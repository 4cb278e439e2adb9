"""Pressure and temperature of a tank test for a given inflator."""

from __future__ import annotations

import numpy as np

from billow.apps.tank.filling import Tank, Trajectory, fill
from billow.apps.tank.inflow_temperature import InflowTemperature
from billow.apps.tank.tank_case import NOT_GIVEN, TankCase

FINEST = 2e-5
"""s. Longest step of the loss to the wall: a hundredth of the shortest features of an inflator."""


def predict(
    tank: Tank, times: np.ndarray, flow_times: np.ndarray, flow: np.ndarray, temperature: InflowTemperature
) -> Trajectory:
    """The tank at times [s], (n,), for a mass flow [kg/s], (k,), at flow_times [s]: linear between, zero outside.

    Without loss to the wall the result is exact, whatever the times; with loss it is a trapezoid rule in steps of at
    most 20 us.
    """
    fine = np.unique(np.concatenate([times, np.arange(times[0], times[-1], FINEST)]))
    mass, enthalpy = temperature.integrals(tank, fine, flow_times)
    return fill(tank, fine, mass @ flow, enthalpy @ flow).at(np.searchsorted(fine, times))


def predict_case(case: TankCase) -> Trajectory:
    """The test a case describes, from ignition. Raises InputError E-TANK-012 without mass flow or temperature."""
    temperature, curve = case.inflow_temperature, case.inflator.mass_flow
    if temperature is None or curve is None:
        raise NOT_GIVEN(
            quantity=f"the {'temperature' if temperature is None else 'mass flow'} of the inflow",
            table="inflator",
            why="a prediction needs mass_flow and temperature",
        )
    count = max(round(case.forward.end_time / case.forward.step), 1)
    times = np.linspace(0.0, case.forward.end_time, count + 1)
    flow_times = np.array(curve.time) + case.inflator.delay
    return predict(case.make_tank(), times, flow_times, np.array(curve.value), temperature)
