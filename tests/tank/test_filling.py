"""The tank obeys the first law, and its linearised response is the derivative of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.apps.tank.filling import InflowTemperature, fill, make_tank, predict, pressure_response
from billow.apps.verification import tank as cases
from billow.parts.gas.supply.species import AIR

PYRO = cases.PYRO


@pytest.mark.parametrize("case", [cases.filling, cases.cooling])
def test_closed_forms(case):
    for measurement in case():
        assert measurement.passed, measurement


@settings(max_examples=25, deadline=None)
@given(
    pressure=st.sampled_from([0.0, 2e4, 101325.0]),
    conductance=st.sampled_from([0.0, 5.0, 200.0]),
    hot=st.lists(st.floats(400.0, 2000.0), min_size=3, max_size=3),
    values=st.lists(st.floats(0.0, 4.0), min_size=4, max_size=4),
)
def test_energy_and_mass_close_for_any_inflow(pressure, conductance, hot, values):
    tank = make_tank(0.06, pressure, 295.0, AIR, PYRO, conductance)
    knots = np.array([0.002, 0.01, 0.011, 0.04])
    temperature = InflowTemperature(np.array([0.0, 0.02, 0.05]), np.array(hot))
    state = predict(tank, np.linspace(0.0, 0.06, 31), knots, np.array(values), temperature)
    stored = tank.internal_energy(state.mass[-1], state.temperature[-1]) - tank.start_energy
    assert stored == pytest.approx(state.enthalpy[-1] - state.heat[-1], rel=1e-11, abs=1e-8)
    # The trapezoid rule is exact for a piecewise linear flow.
    assert state.mass[-1] == pytest.approx(np.trapezoid(values, knots), rel=1e-12, abs=1e-15)
    gas = tank.start_constant + state.mass * tank.inflow_constant
    assert state.pressure * tank.volume == pytest.approx(gas * state.temperature, rel=1e-13)


def test_enthalpy_of_a_varying_temperature_is_its_integral():
    tank = make_tank(0.06, 101325.0, 295.0, AIR, PYRO)
    knots, flow = np.array([0.0, 0.01, 0.04]), np.array([0.0, 2.0, 0.5])
    temperature = InflowTemperature(np.array([0.0, 0.015, 0.03]), np.array([900.0, 600.0, 700.0]))
    _, enthalpy = temperature.integrals(tank, np.array([0.0, 0.05]), knots)
    fine = np.linspace(0.0, 0.04, 40_001)
    power = np.interp(fine, knots, flow) * [
        tank.inflow_enthalpy(t) for t in np.interp(fine, temperature.times, temperature.values)
    ]
    # Trapezoid rule: relative error about (dt/T)^2 = (1e-6/0.01)^2.
    assert enthalpy[-1] @ flow == pytest.approx(np.trapezoid(power, fine), rel=1e-8)


@pytest.mark.parametrize("conductance", [0.0, 40.0])
def test_response_is_the_derivative(conductance):
    """Central differences of relative step 1e-4: truncation and rounding both below 1e-7."""
    tank = make_tank(0.06, 2e4, 295.0, AIR, PYRO, conductance)
    times, knots = np.linspace(0.0, 0.06, 301), np.linspace(0.0, 0.06, 7)
    mass, enthalpy = InflowTemperature.constant(700.0).integrals(tank, times, knots)
    flow = np.array([0.5, 2.0, 1.5, 1.0, 0.5, 0.2, 0.1])
    state = fill(tank, times, mass @ flow, enthalpy @ flow)
    response = pressure_response(tank, state, mass, enthalpy)
    for k in range(len(knots)):
        up, down = flow.copy(), flow.copy()
        up[k] += 1e-4
        down[k] -= 1e-4
        change = (
            fill(tank, times, mass @ up, enthalpy @ up).pressure
            - fill(tank, times, mass @ down, enthalpy @ down).pressure
        )
        assert response[:, k] == pytest.approx(change / 2e-4, rel=1e-5, abs=1e-6 * np.abs(response[:, k]).max())


def test_an_evacuated_tank_with_loss_starts_at_the_wall_and_stays_sane():
    tank = make_tank(0.06, 0.0, 295.0, AIR, PYRO, conductance=50.0, wall_temperature=350.0)
    state = predict(
        tank, np.linspace(0.0, 0.05, 51), np.array([0.01, 0.02, 0.04]), np.array([0.0, 1.0, 0.0]), cases.HOT
    )
    assert state.temperature[5] == pytest.approx(350.0, abs=0.01)  # next to no gas takes the temperature of the wall
    assert state.temperature.min() >= 295.0
    assert state.temperature.max() < 900.0
