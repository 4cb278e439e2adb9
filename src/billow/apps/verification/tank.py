"""V1 to V4: tank tests, prediction against closed forms and evaluation of predicted tests (docs/tank.md, Accuracy)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.apps.tank.filling import InflowTemperature, Tank, Trajectory, make_tank, predict
from billow.apps.tank.inverse import Solution, flow_of_gas_temperature, flow_of_temperature, flow_of_total_mass
from billow.apps.tank.trace import Trace
from billow.apps.verification.check import Measurement
from billow.apps.verification.gas import GAMMA, GAS_CONSTANT, IDEAL, PYRO
from billow.parts.gas.supply.species import AIR, thermo_table

VOLUME = 0.060
FLOW_TIMES, FLOW = np.array([0.0, 0.008, 0.050]), np.array([0.0, 2.0, 0.0])
HOT = InflowTemperature.constant(650.0)
NOISE = 0.01  # of peak pressure


def ideal_tank(mass: float, temperature: float, conductance: float = 0.0, wall: float = 300.0) -> Tank:
    """60 l with a gas of constant cp: this mass [kg] at the start, temperature [K], conductance [W/K] to a wall [K]."""
    return Tank(VOLUME, thermo_table(IDEAL), np.array([mass]), temperature, np.ones(1), conductance, wall)


def filling() -> Iterator[Measurement]:
    """V1: 30 g at 600 K into 60 l, evacuated as T1; with gas in it the pressure rises by as much, g R T_in m / V, as
    p V = (g - 1) U. The balance has no discretisation error; 1e-11 kg are left in the evacuated tank."""
    times, steady = np.linspace(0.0, 0.04, 41), (np.array([0.0, 0.03]), np.ones(2), InflowTemperature.constant(600.0))
    state = predict(ideal_tank(1e-11, 300.0), times, *steady)
    rise = GAMMA * GAS_CONSTANT * 600.0 * 0.03 / VOLUME
    yield Measurement("temperature in the evacuated tank [K]", state.temperature[-1], 840.0, 1e-8)
    yield Measurement("pressure in the evacuated tank [Pa]", state.pressure[-1], rise, 1e-8)
    state = predict(ideal_tank(0.07, 300.0), times, *steady)
    yield Measurement("pressure rise in a full tank [Pa]", np.ptp(state.pressure), rise, 1e-10)


def cooling() -> Iterator[Measurement]:
    """V2: 70 g at 900 K cool at a wall of 300 K: T - T_wall falls as exp(-hA t / (m cv)). Trapezoid rule, 20 us in a
    time constant of 50 ms: error (dt/tau)^2 / 12 = 1e-8 for each time constant, two of them."""
    capacity = 0.07 * GAS_CONSTANT / (GAMMA - 1.0)
    tank = ideal_tank(0.07, 900.0, conductance=capacity / 0.050)
    times = np.linspace(0.0, 0.1, 11)
    state = predict(tank, times, np.array([0.0, 0.1]), np.zeros(2), HOT)
    yield Measurement("cooled gas [K]", state.temperature[-1], 300.0 + 600.0 * np.exp(-2.0), 1e-7)
    lost = capacity * (900.0 - state.temperature[-1])
    yield Measurement("heat to the wall [J]", state.heat[-1], lost, 1e-12)


def driver_test(rows: int = 1001) -> tuple[Tank, Trajectory]:
    """50 g of pyrotechnic gas in 50 ms into 60 l of air that cool at the wall, and what it makes in 100 ms."""
    tank = make_tank(VOLUME, 101325.0, 295.0, AIR, PYRO, conductance=30.0)
    return tank, predict(tank, np.linspace(0.0, 0.1, rows), FLOW_TIMES, FLOW, HOT)


def _true_flow(found: Solution) -> np.ndarray:
    """Flow [kg/s] of `driver_test` at the knots."""
    return np.interp(found.knots, FLOW_TIMES, FLOW)


def _flow_error(found: Solution, known: str) -> Measurement:
    error = float(np.abs(found.flow - _true_flow(found)).max() / FLOW.max())
    return Measurement(f"flow from pressure and {known}, error of peak [-], absolute", error, 0.0, 0.01)


def inverse() -> Iterator[Measurement]:
    """V3: the flow found from a predicted test is the flow that made it; likewise a temperature that was left out. The
    estimate is straight between knots 0.33 ms apart, which may cut off the tip of the curve by an eighth of the spacing
    times the change of slope there, 0.3 kg/s per ms: 0.6 % of the peak."""
    tank, state = driver_test()
    trace = Trace(state.times, state.pressure, state.temperature)
    found = flow_of_temperature(tank, trace, HOT)
    yield _flow_error(found, "temperature")
    yield Measurement("mass from pressure and temperature [kg]", found.mass, 0.050, 1e-4)
    found = flow_of_total_mass(tank, trace, 0.050)
    yield _flow_error(found, "weight")
    yield Measurement("temperature from pressure and weight [K]", found.temperature.values[0], 650.0, 1e-4)
    found = flow_of_gas_temperature(tank, trace)
    yield _flow_error(found, "gas temperature")
    middle = found.temperature.at(0.02)
    yield Measurement("temperature from pressure and gas temperature [K]", middle, 650.0, 1e-3)


def coverage(draws: int) -> tuple[np.ndarray, np.ndarray]:
    """Whether the 95 % band holds the true flow, (draws, knots), and the true mass, (draws,), in noise of 1 %."""
    tank, state = driver_test(rows=401)
    noise = np.random.default_rng(5).standard_normal((draws, len(state.times))) * NOISE * state.pressure.max()
    inside, mass = [], []
    for drawn in noise:
        found = flow_of_temperature(tank, Trace(state.times, state.pressure + drawn), HOT)
        true = _true_flow(found)
        inside.append((found.low <= true) & (true <= found.high))
        mass.append(abs(found.mass - 0.050) <= found.mass_half_width)
    return np.array(inside), np.array(mass)


def band() -> Iterator[Measurement]:
    """V4: the 95 % band holds the true flow for 90 to 100 % of the time, in the mean of 12 tests with 1 % of noise and
    in the worst of them."""
    inside, _ = coverage(12)
    yield Measurement("share of time inside the band, mean [-], absolute", inside.mean(), 0.95, 0.05)
    yield Measurement("share of time inside the band, worst test [-], absolute", inside.mean(axis=1).min(), 0.95, 0.05)
