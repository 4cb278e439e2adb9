"""Mass flow and temperature of an inflator from the pressure in a closed tank, and the regularised regression behind it
(docs/tank.md, From pressure to mass flow)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import cho_solve, solve_triangular
from scipy.optimize import brentq, nnls

from billow.apps.tank.filling import InflowTemperature, Tank, Trajectory, fill, pressure_response
from billow.apps.tank.trace import Trace, noise_of
from billow.base.errors import InputError
from billow.parts.gas.supply.species import COLDEST, HOTTEST

IMPOSSIBLE_MASS = InputError.declare(
    "E-TANK-013",
    "{total:g} kg cannot have made this pressure",
    where="inflator.total_mass",
    why="the end state needs an inflow of {enthalpy:.4g} J/kg; no temperature from {low:g} to {high:g} K gives that",
    cause="a mass in another unit, a wrong volume, or gauge and absolute pressure confused",
    remedy="check total_mass, volume and gas, and whether the pressure is absolute or gauge",
)

WIDE = 1.959964
"""Standard deviations on either side that hold 95 % of a normal distribution."""
MOST_KNOTS = 300
MOST_ITERATIONS = 20
SETTLED = 1e-6
"""Change of the flow, of its peak, at which iterations end."""
_STRENGTHS = np.logspace(-14.0, 4.0, 361)


@dataclass(frozen=True)
class Solution:
    """Result of a tank test.

    knots [s], flow [kg/s], half_width [kg/s]: of the 95 % band, all (k,); temperature: of the inflow, and
    temperature_half_width [K] (one per value); mass, mass_half_width [kg]: delivered in all; state: of the tank at the
    times of the trace; noise [Pa]: standard deviation of the pressure; resolution [s]: shortest time over which the
    data resolve the flow; pattern [-]: correlation of one residual with the next.
    """

    knots: np.ndarray
    flow: np.ndarray
    half_width: np.ndarray
    temperature: InflowTemperature
    temperature_half_width: np.ndarray
    mass: float
    mass_half_width: float
    state: Trajectory
    noise: float
    resolution: float
    pattern: float
    smoothing: float

    @property
    def low(self) -> np.ndarray:
        """Lower end of the band [kg/s]; a flow is never negative."""
        return np.maximum(self.flow - self.half_width, 0.0)

    @property
    def high(self) -> np.ndarray:
        """Upper end of the band [kg/s]."""
        return self.flow + self.half_width


def flow_of_temperature(
    tank: Tank, trace: Trace, temperature: InflowTemperature, smoothing: float | None = None
) -> Solution:
    """Mass flow from the pressure of the trace [Pa] and the temperature of the inflow [K].

    Gauss-Newton: the pressure is nearly linear in the flow (exactly so for a constant cp and no loss). smoothing: that
    of an earlier solution, to see the effect of another setting alone.
    """
    times, knots = _from_start(trace.times), _knots(trace)
    rows = slice(len(times) - len(trace.times), None)
    mass, enthalpy = temperature.integrals(tank, times, knots)
    # A constant flow that gives about the final energy, with cv about that of air.
    rise = _level(trace.pressure) - tank.start_constant * tank.start_temperature / tank.volume
    flow = np.full(len(knots), 2.5 * max(rise, 0.0) * tank.volume / enthalpy[-1].sum())
    for _ in range(MOST_ITERATIONS):
        before = flow
        state = fill(tank, times, mass @ flow, enthalpy @ flow)
        design = pressure_response(tank, state, mass, enthalpy)[rows]
        found = fit(design, trace.pressure - state.pressure[rows] + design @ flow, knots, smoothing)
        flow = found.flow
        if np.abs(flow - before).max() <= SETTLED * flow.max():
            break
    state = fill(tank, times, mass @ flow, enthalpy @ flow).at(rows)
    return _solution(knots, found, temperature, state, trace)


def flow_of_total_mass(tank: Tank, trace: Trace, total: float, smoothing: float | None = None) -> Solution:
    """Mass flow and constant temperature of the inflow [K] that deliver this mass [kg].

    The temperature follows from the end state, iterated with the heat that follows from the flow. Raises InputError
    E-TANK-013 if no temperature of 200 to 3000 K does.
    """
    temperature, heat = 0.0, 0.0
    end = _level(trace.pressure)
    for _ in range(MOST_ITERATIONS):
        before = temperature
        gas = tank.start_constant + total * tank.inflow_constant
        energy = tank.internal_energy(total, end * tank.volume / gas) - tank.start_energy + heat
        temperature = _temperature_of(tank, energy / total)
        if not COLDEST < temperature < HOTTEST:
            raise IMPOSSIBLE_MASS(total=total, enthalpy=energy / total, low=COLDEST, high=HOTTEST)
        found = flow_of_temperature(tank, trace, InflowTemperature.constant(temperature), smoothing)
        smoothing = found.smoothing
        heat, end = found.state.heat[-1], found.state.pressure[-1]
        if abs(temperature - before) <= SETTLED * temperature:
            break
    return found


def flow_of_gas_temperature(tank: Tank, trace: Trace) -> Solution:
    """Mass flow and temperature of the inflow from pressure [Pa] and temperature [K] of the gas in the tank.

    Mass and enthalpy that have entered are differentiated separately; there is a temperature wherever the flow exceeds
    its band.
    """
    p, t, v = trace.pressure, trace.gas_temperature, tank.volume
    mass = (p * v / t - tank.start_constant) / tank.inflow_constant
    heat = tank.conductance * cumulative_trapezoid(t - tank.wall_temperature, trace.times, initial=0.0)
    energy = np.array([tank.internal_energy(*pair) for pair in zip(mass, t, strict=True)])
    enthalpy = energy - tank.start_energy + heat
    step = 1e-4 * t
    warmer = np.array([tank.internal_energy(*pair) for pair in zip(mass, t + step, strict=True)])
    inflow = np.array([tank.internal_energy(1.0, x) - tank.internal_energy(0.0, x) for x in t])
    mass_by = np.stack([v / (tank.inflow_constant * t), -p * v / (tank.inflow_constant * t**2)])  # of p, of T
    energy_by = inflow * mass_by + np.stack([np.zeros(len(t)), (warmer - energy) / step])
    noise = np.array([noise_of(p), noise_of(t)])[:, None]
    knots = _knots(trace)
    design = InflowTemperature.constant(300.0).integrals(tank, _from_start(trace.times), knots)[0][-len(p) :]
    fits = []
    for data, by in ((mass, mass_by), (enthalpy, energy_by)):
        spread = np.linalg.norm(by * noise, axis=0)
        spread /= spread.mean()
        fits.append(fit(design / spread[:, None], data / spread, knots))
    flow, power = fits
    told = flow.flow > WIDE * flow.deviation
    specific = power.flow[told] / flow.flow[told]
    limits = [tank.inflow_enthalpy(x) for x in (COLDEST, HOTTEST)]
    value = np.array([_temperature_of(tank, h) for h in np.clip(specific, *limits)])
    spread = np.hypot(power.deviation[told], specific * flow.deviation[told]) / flow.flow[told]
    cp = np.array([tank.inflow_cp(x) for x in value])
    state = fill(tank, trace.times, design @ flow.flow, design @ power.flow)
    found = _solution(knots, flow, InflowTemperature(knots[told], value), state, trace)
    return replace(found, temperature_half_width=WIDE * spread / cp, noise=float(noise[0, 0]))


def with_uncertainty(best: Solution, shifted: list[Solution]) -> Solution:
    """The best solution with its band widened by the change each shifted one shows, as independent 95 % half-widths."""
    half = np.hypot.reduce([best.half_width, *(s.flow - best.flow for s in shifted)])
    mass = np.hypot.reduce([best.mass_half_width, *(s.mass - best.mass for s in shifted)])
    moved = [s.temperature.at(best.temperature.times) - best.temperature.values for s in shifted]
    warm = np.hypot.reduce([best.temperature_half_width, *moved])
    return replace(best, half_width=half, mass_half_width=float(mass), temperature_half_width=warm)


def _solution(
    knots: np.ndarray, found: Fit, temperature: InflowTemperature, state: Trajectory, trace: Trace
) -> Solution:
    half = 0.5 * np.diff(knots)
    weights = np.append(half, 0.0) + np.append(0.0, half)
    residual = trace.pressure - state.pressure
    power = np.sum(residual**2)
    return Solution(
        knots=knots,
        flow=found.flow,
        half_width=WIDE * found.deviation,
        temperature=temperature,
        temperature_half_width=np.zeros(len(temperature.values)),
        mass=float(weights @ found.flow),
        mass_half_width=float(WIDE * np.sqrt(weights @ found.covariance @ weights)),
        state=state,
        noise=found.noise,
        resolution=float((knots[-1] - knots[0]) / found.freedom),
        pattern=float(np.sum(residual[1:] * residual[:-1]) / power) if power > 0.0 else 0.0,
        smoothing=found.smoothing,
    )


def _knots(trace: Trace) -> np.ndarray:
    """Evenly spaced from ignition to the end of the trace; at least two measured values per knot."""
    return np.linspace(0.0, trace.times[-1], min(MOST_KNOTS, len(trace.times) // 2))


def _from_start(times: np.ndarray) -> np.ndarray:
    """The times [s] with ignition (t = 0) before them."""
    return times if times[0] == 0.0 else np.concatenate([[0.0], times])


def _temperature_of(tank: Tank, specific_enthalpy: float) -> float:
    """Temperature [K] of an inflow of this enthalpy [J/kg], cut off at the ends of the data."""
    low, high = (tank.inflow_enthalpy(x) for x in (COLDEST, HOTTEST))
    if not low < specific_enthalpy < high:
        return COLDEST if specific_enthalpy <= low else HOTTEST
    return brentq(lambda t: tank.inflow_enthalpy(t) - specific_enthalpy, COLDEST, HOTTEST, xtol=1e-9)


def _level(values: np.ndarray) -> float:
    """Mean of the last twentieth."""
    return float(values[-max(len(values) // 20, 1) :].mean())


@dataclass(frozen=True)
class Fit:
    """flow (knots,): non-negative estimate; covariance (knots, knots): of the posterior without that constraint; noise:
    standard deviation of a datum of weight one; smoothing: ratio of noise to prior variance; freedom: effective number
    of parameters."""

    flow: np.ndarray
    covariance: np.ndarray
    noise: float
    smoothing: float
    freedom: float

    @property
    def deviation(self) -> np.ndarray:
        """Posterior standard deviation at the knots, (knots,)."""
        return np.sqrt(np.diag(self.covariance))


def fit(design: np.ndarray, data: np.ndarray, knots: np.ndarray, smoothing: float | None = None) -> Fit:
    """Flow at the knots [s] from data = design @ flow + noise.

    design: (n, knots), data: (n,), divided by the relative standard deviation of each datum; smoothing: used if given,
    else found.
    """
    step = np.diff(knots)
    slopes = np.diff(np.eye(len(knots)), axis=0) / np.sqrt(step)[:, None]
    if smoothing is None:
        smoothing = _likeliest(design, data, step)
    normal = design.T @ design
    factor = np.linalg.cholesky(normal + smoothing * slopes.T @ slopes)
    towards = solve_triangular(factor, design.T @ data, lower=True)
    free = solve_triangular(factor, towards, lower=True, trans="T")
    misfit = np.sum((data - design @ free) ** 2) + smoothing * np.sum((slopes @ free) ** 2)
    variance = misfit / (len(data) - 1)
    inverse = cho_solve((factor, True), np.eye(len(knots)))
    flow, _ = nnls(factor.T, towards, maxiter=30 * len(knots))
    return Fit(flow, variance * inverse, float(np.sqrt(variance)), smoothing, float(np.sum(normal * inverse)))


def _likeliest(design: np.ndarray, data: np.ndarray, step: np.ndarray) -> float:
    """Ratio of noise variance to the prior's (per second) with the greatest restricted likelihood.

    In the coordinates (level, steps / sqrt(dt)) the prior is white; without what the level explains, the singular
    values s of the design give -2 log L = (n - 1) log(sum(z^2 l / (s^2 + l)) + rest) + sum log(1 + s^2 / l).
    """
    level = design.sum(axis=1)
    level /= np.linalg.norm(level)
    walk = np.cumsum(design[:, ::-1], axis=1)[:, -2::-1] * np.sqrt(step)  # flow after each step
    walk = walk - np.outer(level, level @ walk)
    seen = data - level * (level @ data)
    left, values, _ = np.linalg.svd(walk, full_matrices=False)
    projected = left.T @ seen
    rest = np.sum((seen - left @ projected) ** 2)
    ratio = values[0] ** 2 * _STRENGTHS[:, None]
    explained = np.sum(projected**2 * ratio / (values**2 + ratio), axis=1)
    # Data without noise would give log(0).
    power = np.maximum(explained + rest, 1e-28 * np.sum(data**2))
    criterion = (len(data) - 1) * np.log(power) + np.sum(np.log1p(values**2 / ratio), axis=1)
    return float(ratio[np.argmin(criterion), 0])
