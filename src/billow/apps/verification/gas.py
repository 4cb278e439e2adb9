"""T1 to T6: the uniform-pressure gas of one chamber against closed forms of thermodynamics.

Chambers are boxes whose walls stand still or are moved by hand, so that the volume is exact; the gas is advanced by
`UniformPressure.advance`, as in a run.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from billow.apps.verification.check import Measurement
from billow.apps.verification.meshes import box
from billow.geometry.chambers import Chambers
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.ambient import Ambient, InitialGas
from billow.parts.gas.supply.inflator import Inflator
from billow.parts.gas.supply.mixture import mixture_cp, mixture_gas_constant
from billow.parts.gas.supply.outflow import ORIFICE, orifice_flux
from billow.parts.gas.supply.passages import VENT, Passage, Passages
from billow.parts.gas.supply.species import MOLAR_GAS_CONSTANT, SPECIES, Species, mass_fractions, thermo_table
from billow.parts.gas.supply.supply import Source, Supply
from billow.parts.gas.uniform.uniform_pressure import UniformPressure, UniformState

GAS_CONSTANT, GAMMA = 287.0, 1.4
IDEAL = [Species.ideal("ideal", GAS_CONSTANT, GAMMA)]
PYRO = {"N2": 0.45, "H2O": 0.30, "CO2": 0.25}
WIDTH, DEPTH, HEIGHT = 0.3, 0.2, 1.0
VOLUME = WIDTH * DEPTH * HEIGHT  # 60 l
BOX = Chambers.single(12)


def still_gas(species: list[Species], fractions: np.ndarray, pressure: float, temperature: float) -> UniformPressure:
    """Sealed chamber without inflow, outside and at the start inside: this gas at pressure [Pa] and temperature [K]."""
    nothing = Inflator(np.array([0.0, 1.0]), np.zeros(2), np.array([0.0, 1.0]), np.full(2, 300.0), fractions)
    supply = Supply(
        table=thermo_table(species),
        species_names=tuple(s.name for s in species),
        sources=(Source(nothing),),
        ambient=Ambient(pressure, temperature, fractions),
        chambers=BOX,
    )
    return UniformPressure(supply)


def supplied(gas: UniformPressure, **changes) -> UniformPressure:
    """The gas with parts of its supply replaced."""
    return UniformPressure(replace(gas.supply, **changes))


def inflow(flow: float, duration: float, temperature: float, fractions: np.ndarray) -> Inflator:
    """Constant mass flow [kg/s] at a total temperature [K] for a duration [s]."""
    return Inflator(
        np.array([0.0, duration]), np.full(2, flow), np.array([0.0, duration]), np.full(2, temperature), fractions
    )


def bag_of_height(height: float) -> Bag:
    """The box with its lid at a height [m]."""
    shape = box(WIDTH, DEPTH, height)
    return Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))


def advance(gas: UniformPressure, state: UniformState, bag: Bag, time: float, dt: float) -> None:
    gas.advance(state, bag, time, dt, np.zeros((bag.surface.triangle_count, 3, 3)))


def rigid_tank() -> Iterator[Measurement]:
    """T1: 30 g at T_in = 600 K into an evacuated rigid tank of 60 l give T = gamma T_in and p = m R T / V.

    All enthalpy becomes internal energy: cv T = cp T_in (first law; e.g. Moran and Shapiro, filling of a tank).
    "Evacuated" is 1e-9 Pa, 2e-14 of the mass, four orders below the tolerance. The balance has no discretisation
    error, so the number of steps (300) only adds rounding.
    """
    gas = still_gas(IDEAL, np.ones(1), pressure=1e-9, temperature=300.0)
    gas = supplied(gas, sources=(Source(inflow(1.0, 0.030, 600.0, np.ones(1))),))
    bag = bag_of_height(HEIGHT)
    state = gas.start(bag)
    dt = 1e-4
    for k in range(300):
        advance(gas, state, bag, k * dt, dt)
    final = GAMMA * 600.0
    yield Measurement("temperature of the tank [K]", state.temperature[0], final, 1e-10)
    yield Measurement("pressure of the tank [Pa]", state.pressure[0], 0.030 * GAS_CONSTANT * final / VOLUME, 1e-10)


def filling_at_constant_pressure() -> Iterator[Measurement]:
    """T2: gas that fills a cylinder whose piston yields at constant pressure keeps its temperature, T = T_in.

    At constant pressure the enthalpy U + p V is conserved for any cp(T): the pyrotechnic mixture is used. The piston
    follows the exact solution, V = V0 + m R T_in / p, and the gas must agree. It starts with 1e-7 of the final volume,
    at 300 K, which shifts the end by less than 1e-7; every step adds 1 % to the volume, so that the first steps are as
    well resolved as the last (iteration error per step below 1e-9).
    """
    species = [SPECIES[name] for name in PYRO]
    fractions = np.array(list(mass_fractions(PYRO).values()))
    pressure, hot, flow = 101325.0, 600.0, 1.0
    gas = still_gas(species, fractions, pressure, temperature=300.0)
    gas = supplied(gas, sources=(Source(inflow(flow, 1.0, hot, fractions)),))
    per_second = flow * mixture_gas_constant(gas.supply.table, fractions) * hot / pressure  # m^3/s
    heights = 1e-7 * HEIGHT * 1.01 ** np.arange(1621)  # the last is the first beyond HEIGHT
    times = (heights - heights[0]) * WIDTH * DEPTH / per_second
    state = gas.start(bag_of_height(heights[0]))
    for height, time, before in zip(heights[1:], times[1:], times[:-1], strict=True):
        advance(gas, state, bag_of_height(height), before, time - before)
    yield Measurement("temperature behind the piston [K]", state.temperature[0], hot, 1e-6)
    yield Measurement("pressure behind the piston [Pa]", state.pressure[0], pressure, 1e-6)


def choked_blow_down() -> Iterator[Measurement]:
    """T3: a rigid tank of 60 l at 5 bar and 600 K empties through Cd A = 1e-3 m^2 to 2 bar, choked all the way.

    The remaining gas expands isentropically and the choked flow is proportional to p/sqrt(T), so p = p0 (1 + (g-1) t /
    (2 tau))^(-2g/(g-1)), tau = V / (Cd A sqrt(g R T0) (2/(g+1))^((g+1)/(2(g-1)))) (Shapiro, "Compressible Fluid Flow",
    1953: 147.7 ms, 461.8 K, 0.5197 of the mass). Rates are taken from the old state (first order): the relative error
    is about dt/tau, 1e-4 at 20 us.
    """
    hole = Passage("hole", VENT, ORIFICE, 0, area=1e-3)
    inside = InitialGas.like(Ambient(5e5, 600.0, np.ones(1)), 1)
    tank = supplied(still_gas(IDEAL, np.ones(1), 101325.0, 295.0), initial=inside, passages=Passages((hole,)))
    bag = bag_of_height(HEIGHT)
    state = tank.start(bag)
    dt, full = 2e-5, state.masses.sum()
    rows = [(0.0, state.pressure[0], state.temperature[0], 1.0)]
    for k in range(10_000):  # 0.2 s
        advance(tank, state, bag, k * dt, dt)
        rows.append(((k + 1) * dt, state.pressure[0], state.temperature[0], state.masses.sum() / full))
        if state.pressure[0] < 2e5:
            break
    times, pressures, temperatures, masses = np.array(rows).T
    time, temperature, mass = (np.interp(-2e5, -pressures, column) for column in (times, temperatures, masses))
    yield from against_closed_form(time, temperature, mass, 1e-3)


def against_closed_form(time: float, temperature: float, mass: float, tolerance: float) -> Iterator[Measurement]:
    """Time [s], temperature [K] and share of the mass [-] at 2 bar, of the blow-down of `choked_blow_down`."""
    g = GAMMA
    tau = VOLUME / (1e-3 * np.sqrt(g * GAS_CONSTANT * 600.0) * (2.0 / (g + 1.0)) ** (0.5 * (g + 1.0) / (g - 1.0)))
    expected_time = 2.0 * tau / (g - 1.0) * (2.5 ** (0.5 * (g - 1.0) / g) - 1.0)
    yield Measurement("time from 5 to 2 bar [s]", time, expected_time, tolerance)
    yield Measurement("temperature at 2 bar [K]", temperature, 600.0 * 0.4 ** ((g - 1.0) / g), tolerance)
    yield Measurement("share of the mass at 2 bar [-]", mass, 0.4 ** (1.0 / g), tolerance)


def critical_flow() -> Iterator[Measurement]:
    """T4: the pressure ratio at which an orifice chokes, (2/(g+1))^(g/(g-1)), and its flux p/sqrt(R T) times
    sqrt(g) (2/(g+1))^((g+1)/(2(g-1))): de Saint-Venant and Wantzel (0.5283, 0.6847 for g = 1.4; 0.5457, 0.6673 for
    1.3).

    The ratio is found by bisection for where the flux begins to fall below its choked value by 1e-15; as it falls with
    the square of the distance, that is within 4e-8.
    """
    pressure, rt = 1e6, 1e5
    for g in (1.4, 1.3):
        choked = orifice_flux(pressure, 0.0, g, rt)
        low, high = 0.0, 1.0
        while high - low > 1e-9:
            middle = 0.5 * (low + high)
            falls = orifice_flux(pressure, middle * pressure, g, rt) < choked * (1.0 - 1e-15)
            low, high = (low, middle) if falls else (middle, high)
        yield Measurement(f"critical pressure ratio, gamma {g} [-]", high, (2.0 / (g + 1.0)) ** (g / (g - 1.0)), 1e-6)
        factor = np.sqrt(g) * (2.0 / (g + 1.0)) ** (0.5 * (g + 1.0) / (g - 1.0))
        yield Measurement(f"choked flux factor, gamma {g} [-]", choked * np.sqrt(rt) / pressure, factor, 1e-6)


def isentropic_compression() -> Iterator[Measurement]:
    """T5: a piston halves the volume of a sealed gas: p V^g and T V^(g-1) are constant (2.6390, 1.3195 for g = 1.4).

    The work of a step is a trapezium in p(V), so the error is about (dV/V)^2/10, 1e-7 with 1000 steps.
    """
    gas = still_gas(IDEAL, np.ones(1), 1e5, 300.0)
    state = gas.start(bag_of_height(HEIGHT))
    for k in range(1, 1001):
        advance(gas, state, bag_of_height(HEIGHT * (1.0 - 0.5 * k / 1000)), (k - 1) * 1e-5, 1e-5)
    yield Measurement("pressure ratio at half the volume [-]", state.pressure[0] / 1e5, 2.0**GAMMA, 1e-5)
    yield Measurement(
        "temperature ratio at half the volume [-]", state.temperature[0] / 300.0, 2.0 ** (GAMMA - 1.0), 1e-5
    )


def mixture_properties() -> Iterator[Measurement]:
    """T6: molar mass, cp and cp/cv of N2/H2O/CO2 45/30/25 mol % (GRI-Mech 3.0; values in docs/theory.md, Verification
    cases)."""
    table = thermo_table([SPECIES[name] for name in PYRO])
    fractions = np.array(list(mass_fractions(PYRO).values()))
    gas_constant = mixture_gas_constant(table, fractions)
    yield Measurement("molar mass [g/mol]", 1e3 * MOLAR_GAS_CONSTANT / gas_constant, 29.01, 1e-3)
    published = ((300.0, 1119.0, 1.344), (650.0, 1271.0, 1.291), (800.0, 1331.0, 1.275), (1000.0, 1403.0, 1.257))
    for temperature, heat_capacity, gamma in published:
        cp = mixture_cp(table, fractions, temperature)
        yield Measurement(f"cp at {temperature:.0f} K [J/(kg K)]", cp, heat_capacity, 1e-3)
        yield Measurement(f"cp/cv at {temperature:.0f} K [-]", cp / (cp - gas_constant), gamma, 1e-3)
