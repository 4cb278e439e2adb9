"""A closed rigid tank with an inflow: temperature and pressure, and their derivatives by the inflow (docs/tank.md,
Thermodynamics).

The loss to the wall is integrated by the trapezoidal rule, relative error about (dt hA / (m cv))^2 / 12, or by the
implicit Euler rule where very little gas makes it stiff. The flow is the curve that `[inflator] mass_flow` takes:
straight between knots, zero outside; mass and enthalpy are linear in its values at the knots.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.supply.mixture import mixture_cp, mixture_enthalpy, mixture_gas_constant
from billow.parts.gas.supply.species import find_species, mass_fractions, thermo_table

FINEST = 2e-5
"""s. Longest step of the loss to the wall: a hundredth of the shortest features of an inflator."""
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
"""Exact to degree 7: cp is of degree 4, so that h(T) is of degree 5 and, times a hat, of degree 6 in time."""
EMPTIEST = 1e-6
"""Pa. An evacuated tank is given this much gas, 1e-11 of what an inflator leaves, so that it has a temperature."""


@dataclass(frozen=True)
class Tank:
    """volume [m^3]; table (species, 16): see species.thermo_table; start_masses (species,) [kg], start_temperature [K]:
    of the gas in it at the start; fractions (species,): mass fractions of the inflow; conductance [W/K]: heat-transfer
    coefficient times area of the wall; wall_temperature [K]."""

    volume: float
    table: np.ndarray
    start_masses: np.ndarray
    start_temperature: float
    fractions: np.ndarray
    conductance: float
    wall_temperature: float

    @property
    def start_energy(self) -> float:
        """Internal energy of the gas in it at the start [J]."""
        return self.internal_energy(0.0, self.start_temperature)

    @property
    def inflow_constant(self) -> float:
        """Gas constant of the inflow [J/(kg K)]."""
        return mixture_gas_constant(self.table, self.fractions)

    @property
    def start_constant(self) -> float:
        """Mass times gas constant of the gas at the start [J/K]."""
        return mixture_gas_constant(self.table, self.start_masses)

    def inflow_enthalpy(self, temperature: float) -> float:
        """Specific enthalpy of the inflow [J/kg] at temperature [K]."""
        return mixture_enthalpy(self.table, self.fractions, temperature)

    def inflow_cp(self, temperature: float) -> float:
        """Heat capacity of the inflow [J/(kg K)] at temperature [K]."""
        return mixture_cp(self.table, self.fractions, temperature)

    def internal_energy(self, mass: float, temperature: float) -> float:
        """Internal energy [J] at temperature [K] once this mass [kg] has entered."""
        masses = self.start_masses + mass * self.fractions
        gas_constant = mixture_gas_constant(self.table, masses)
        return mixture_enthalpy(self.table, masses, temperature) - gas_constant * temperature


@dataclass(frozen=True)
class InflowTemperature:
    """Total temperature [K] at times [s], (n,): linear between, constant outside."""

    times: np.ndarray
    values: np.ndarray

    @classmethod
    def constant(cls, value: float) -> InflowTemperature:
        """The same temperature [K] at all times."""
        return cls(np.zeros(1), np.full(1, value))

    def at(self, times: np.ndarray) -> np.ndarray:
        """Temperature [K] at times [s]."""
        return np.interp(times, self.times, self.values)

    def integrals(self, tank: Tank, times: np.ndarray, knots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mass [kg] and enthalpy [J] that have entered by each time per 1 kg/s at each knot; both (times, knots).

        times [s]: increasing, the first is where counting begins; knots [s]: increasing.
        """
        inside = np.concatenate([knots, self.times])  # kinks of the integrands
        grid = np.unique(np.concatenate([times, inside[(inside > times[0]) & (inside < times[-1])]]))
        width = np.diff(grid)
        at = grid[:-1, None] + 0.5 * width[:, None] * (_POINTS + 1.0)  # (intervals, 4)
        weight = 0.5 * width[:, None] * _WEIGHTS
        distinct, back = np.unique(self.at(at), return_inverse=True)
        enthalpy = np.array([tank.inflow_enthalpy(t) for t in distinct])[back].reshape(at.shape)
        flowing = (at[:, 0] > knots[0]) & (at[:, 0] < knots[-1])
        left = np.clip(np.searchsorted(knots, at[:, 0], side="right") - 1, 0, len(knots) - 2)
        share = (at - knots[left, None]) / (knots[left + 1] - knots[left])[:, None]  # of the right knot
        rows, row, made = np.searchsorted(grid, times), np.arange(len(left)), []
        for density in (weight, weight * enthalpy):
            parts = np.zeros((len(grid), len(knots)))
            parts[row + 1, left] = flowing * np.sum(density * (1.0 - share), axis=1)
            parts[row + 1, left + 1] = flowing * np.sum(density * share, axis=1)
            made.append(np.cumsum(parts, axis=0)[rows])
        return made[0], made[1]


@dataclass(frozen=True)
class Trajectory:
    """States of the tank at times [s], all (n,).

    mass [kg], enthalpy [J]: entered so far; temperature [K]; pressure [Pa]; heat [J]: lost to the wall so far;
    capacity [J/K]: at constant volume; inflow_energy [J/kg]: specific internal energy of the inflow at the tank's
    temperature; implicit [-]: weight of the new temperature in the loss of the step that ends here.
    """

    times: np.ndarray
    mass: np.ndarray
    enthalpy: np.ndarray
    temperature: np.ndarray
    pressure: np.ndarray
    heat: np.ndarray
    capacity: np.ndarray
    inflow_energy: np.ndarray
    implicit: np.ndarray

    def at(self, rows: slice | np.ndarray) -> Trajectory:
        """Some rows of it."""
        return Trajectory(**{name: values[rows] for name, values in vars(self).items()})


def make_tank(
    volume: float,
    pressure: float,
    temperature: float,
    gas: dict[str, float],
    inflow: dict[str, float],
    conductance: float = 0.0,
    wall_temperature: float | None = None,
) -> Tank:
    """Tank of a volume [m^3] at a pressure [Pa, absolute] and temperature [K].

    gas, inflow: mole fractions of the gas in it and of what flows in; conductance [W/K] to a wall at wall_temperature
    [K], by default that of the gas. Raises InputError E-GAS-001 for an unknown gas.
    """
    names = list(dict.fromkeys([*inflow, *gas]))
    table = thermo_table([find_species(name, "the gases of the tank") for name in names])
    shares = (mass_fractions(gas), mass_fractions(inflow))
    inside, entering = (np.array([of.get(name, 0.0) for name in names]) for of in shares)
    mass = max(pressure, EMPTIEST) * volume / (mixture_gas_constant(table, inside) * temperature)
    wall = temperature if wall_temperature is None else wall_temperature
    return Tank(volume, table, mass * inside, temperature, entering, conductance, wall)


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


def fill(tank: Tank, times: np.ndarray, mass: np.ndarray, enthalpy: np.ndarray) -> Trajectory:
    """States of the tank.

    times [s], (n,): increasing, the first is the start; mass [kg], enthalpy [J], (n,): entered until then, first zero.
    """
    rows = np.empty((6, len(times)))
    _fill(
        *(times, mass, enthalpy, tank.table, tank.start_masses, tank.fractions),
        *(tank.volume, tank.start_temperature, tank.conductance, tank.wall_temperature, rows),
    )
    return Trajectory(times, mass, enthalpy, *rows)


@scalar
def _fill(
    times, mass, enthalpy, table, start_masses, fractions, volume, start_temperature, conductance, wall, rows_out
):
    # A recurrence in time: each state follows from the one before, nothing to do in parallel.
    gas_constant = mixture_gas_constant(table, start_masses)
    energy = mixture_enthalpy(table, start_masses, start_temperature) - gas_constant * start_temperature
    t, heat, implicit = start_temperature, 0.0, 1.0
    inflow_constant = mixture_gas_constant(table, fractions)
    for k in range(len(times)):
        masses = start_masses + mass[k] * fractions
        gas_constant = mixture_gas_constant(table, masses)
        if k > 0:
            loss = conductance * (times[k] - times[k - 1])  # J/K
            capacity = mixture_cp(table, masses, t) - gas_constant
            implicit = 0.5 if loss < capacity else 1.0
            heat += loss * ((1.0 - implicit) * (t - wall) - implicit * wall)  # what is known of it
            t = _balance(table, masses, gas_constant, implicit * loss, energy + enthalpy[k] - heat, t)
            heat += implicit * loss * t
        rows_out[0, k] = t
        rows_out[1, k] = gas_constant * t / volume
        rows_out[2, k] = heat
        rows_out[3, k] = mixture_cp(table, masses, t) - gas_constant
        rows_out[4, k] = mixture_enthalpy(table, fractions, t) - inflow_constant * t
        rows_out[5, k] = implicit


@scalar
def _balance(table, masses, gas_constant, wall, energy, guess):
    """T [K] with sum(m_i e_i(T)) + wall T = energy: Newton on a monotone function. wall [J/K], energy [J]."""
    t = guess
    for _ in range(60):
        residual = mixture_enthalpy(table, masses, t) + (wall - gas_constant) * t - energy
        change = residual / (mixture_cp(table, masses, t) - gas_constant + wall)
        change = min(max(change, -t), 0.5 * t)  # never below zero, at most doubled
        t -= change
        if abs(change) <= 1e-14 * t:
            break
    return t


def pressure_response(tank: Tank, state: Trajectory, mass: np.ndarray, enthalpy: np.ndarray) -> np.ndarray:
    """Derivative of the pressure [Pa], (n, k), for inflows that change by mass [kg] and enthalpy [J], (n, k).

    The linearised balance: C dT = dH - dQ - e_in dM, V dp = sum(m R) dT + T R_in dM.
    """
    supply = enthalpy - state.inflow_energy[:, None] * mass
    warming, heat = np.zeros(mass.shape), np.zeros(mass.shape[1])
    for k in range(1, len(mass)):
        loss = tank.conductance * (state.times[k] - state.times[k - 1])
        weight = state.implicit[k]
        heat += loss * (1.0 - weight) * warming[k - 1]
        warming[k] = (supply[k] - heat) / (state.capacity[k] + weight * loss)
        heat += loss * weight * warming[k]
    constant = (state.pressure * tank.volume / state.temperature)[:, None]
    return (constant * warming + state.temperature[:, None] * tank.inflow_constant * mass) / tank.volume
