"""T1p to T5p: the corpuscular gas against closed forms of thermodynamics.

The gas is advanced by `Corpuscular.advance`, as in a run, in a box whose walls stand still or are moved by hand.
Each case has enough particles to keep its statistical error, named in its docstring, below its tolerance, and one seed,
so that it gives the same numbers every time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from billow.apps.verification.check import Measurement
from billow.apps.verification.gas import (
    DEPTH,
    GAMMA,
    GAS_CONSTANT,
    HEIGHT,
    IDEAL,
    VOLUME,
    WIDTH,
    against_closed_form,
    bag_of_height,
    inflow,
)
from billow.apps.verification.meshes import box
from billow.geometry.surface import area_vectors
from billow.parts.gas.corpuscular.corpuscular import Corpuscular
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.supply.ambient import Ambient, InitialGas
from billow.parts.gas.supply.inflator import Inflator, JetRing
from billow.parts.gas.supply.jets import Jets
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import VENT, Passage, Passages
from billow.parts.gas.supply.species import Species, thermo_table
from billow.parts.gas.supply.supply import Source, Supply

LID = np.array([10, 11])
WHOLE = np.ones(1)
ATMOSPHERE = 101325.0


def in_a_box(
    species: list[Species], particles: int, pressure: float, temperature: float, height: float = HEIGHT, *,
    fractions: np.ndarray = WHOLE, inflator: Inflator | None = None, passages: tuple[Passage, ...] = (),
    outside: float = ATMOSPHERE, heat_conductance: np.ndarray | None = None,
) -> Corpuscular:  # fmt: skip
    """Gas at pressure [Pa] and temperature [K]; outside: pressure [Pa]. An inflator blows upwards from the bottom
    through a hole of 0.1 m, in all directions."""
    shape = box(WIDTH, DEPTH, height)
    bottom = np.flatnonzero(shape.positions[:, 2] == 0.0)
    ring = JetRing(1, 0.0, 0.1, 0.0, cone=0.5 * np.pi)
    jets = Jets(ring, bottom, np.array([0.0, 0.0, 1.0]))
    supply = Supply(
        table=thermo_table(species),
        species_names=tuple(s.name for s in species),
        sources=() if inflator is None else (Source(inflator, jets),),
        ambient=Ambient(outside, 295.0, fractions),
        chambers=shape.surface.chambers,
        passages=Passages(passages),
        initial=InitialGas.like(Ambient(pressure, temperature, fractions), 1),
        heat_conductance=heat_conductance,
    )
    return Corpuscular(supply, shape.surface, shape.reference, particles)


def steps(
    gas: Corpuscular, state: CorpuscularState, count: int, dt: float, height: Callable[[float], float] | None = None,
    begin: int = 0,
) -> Iterator[float]:  # fmt: skip
    """Advance by `count` steps of dt [s], with the lid at height(time) [m], and yield the time [s] after each."""
    shape = box(WIDTH, DEPTH, HEIGHT if height is None else height(begin * dt))
    bag = bag_of_height(HEIGHT) if height is None else None
    still = np.zeros_like(shape.positions)
    for k in range(begin, begin + count):
        if height is not None:
            low, high = height(k * dt), height((k + 1) * dt)
            bag = bag_of_height(high)
            bag.velocities = still.copy()
            bag.velocities[bag.positions[:, 2] > 0.0, 2] = (high - low) / dt
        gas.advance(state, bag, k * dt, dt, np.zeros((12, 3, 3)))
        yield (k + 1) * dt


def books(state: CorpuscularState) -> Iterator[Measurement]:
    """Mass by count, energy and momentum of gas and walls together."""
    yield Measurement("largest mass error [absolute]", state.mass_error, 0.0, 1e-12)
    yield Measurement("largest energy error [absolute]", state.energy_error, 0.0, 1e-9)
    yield Measurement("largest momentum error [absolute]", state.momentum_error, 0.0, 1e-11)


def rigid_tank() -> Iterator[Measurement]:
    """T1p: as T1. Temperature is that of all energy, exact but for the last particle, 1e-4; pressure that of flight,
    equation 8 of the LS-DYNA paper: 0.5/sqrt(8,000) = 0.6 % at a time, 0.1 % over 40 independent ones; that on the
    walls has 3e5 hits, 1.13/sqrt(hits) = 0.2 %.
    """
    flow = inflow(1.0, 0.030, 600.0, WHOLE)
    gas = in_a_box(IDEAL, 8_000, 1e-9, 300.0, inflator=flow)
    state = gas.start(bag_of_height(HEIGHT))
    for _ in steps(gas, state, 640, 5e-5):
        pass
    flight, walls = [], []
    for _ in steps(gas, state, 200, 5e-5, begin=640):
        flight.append(state.pressure[0])
        walls.append(over_walls(state.bank.pressure[:, 0]))
    final = GAMMA * 600.0
    pressure = 0.030 * GAS_CONSTANT * final / VOLUME
    yield Measurement("temperature of the tank [K]", state.temperature[0], final, 5e-3)
    yield Measurement("pressure of the tank [Pa]", np.mean(flight), pressure, 5e-3)
    yield Measurement("pressure on its walls [Pa]", np.mean(walls), pressure, 5e-3)
    yield from books(state)


def filling_at_constant_pressure() -> Iterator[Measurement]:
    """T2p: as T2, from a twentieth of the final volume, filled with the same gas at T_in.

    The piston follows the exact solution. Statistical error 0.5/sqrt(N) at a time, 0.1 % over the last quarter.
    """
    hot, flow, start = 600.0, 0.5, 0.05 * HEIGHT
    rise = flow * GAS_CONSTANT * hot / ATMOSPHERE / (WIDTH * DEPTH)
    dt = 1e-4
    count = int((HEIGHT - start) / (rise * dt))
    gas = in_a_box(IDEAL, 8_000, ATMOSPHERE, hot, start, inflator=inflow(flow, count * dt, hot, WHOLE))
    state = gas.start(bag_of_height(start))
    pressure = []
    for time in steps(gas, state, count, dt, lambda time: start + rise * time):
        if time > 0.75 * count * dt:
            pressure.append(state.pressure[0])
    yield Measurement("temperature behind the piston [K]", state.temperature[0], hot, 1e-2)
    yield Measurement("pressure behind the piston [Pa]", np.mean(pressure), ATMOSPHERE, 1e-2)
    yield from books(state)


def choked_blow_down() -> Iterator[Measurement]:
    """T3p: as T3, through a lid that lets particles pass at the rate of the law.

    Half of 8,000 particles leave: 1.6 % of those that remain. The energy they carry (2 k T in flight at a hole,
    internal energy, and k T/2 from the others) is the enthalpy of continuum outflow: 0.6/sqrt(4,000) = 0.9 %.
    """
    hole = Passage("hole", VENT, ORIFICE, 0, triangles=LID, area=1e-3)
    gas = in_a_box(IDEAL, 8_000, 5e5, 600.0, passages=(hole,), outside=1e5)
    state = gas.start(bag_of_height(HEIGHT))
    full = state.masses.sum()
    dt = 1e-4
    rows = [(0.0, 5e5, 600.0, 1.0)]
    enthalpy, flight = 0.0, []
    for time in steps(gas, state, 2500, dt):
        mass, temperature = state.masses.sum() / full, state.temperature[0]
        enthalpy += (rows[-1][3] - mass) * full * GAMMA / (GAMMA - 1.0) * GAS_CONSTANT * rows[-1][2]
        pressure = mass * full * GAS_CONSTANT * temperature / VOLUME
        flight.append(state.pressure[0] / pressure)
        rows.append((time, pressure, temperature, mass))
        if pressure < 2e5:
            break
    times, pressures, temperatures, masses = np.array(rows).T
    time, temperature, mass = (np.interp(-2e5, -pressures, column) for column in (times, temperatures, masses))
    yield from against_closed_form(time, temperature, mass, 3e-2)
    yield Measurement("pressure of flight over m R T/V [-]", np.mean(flight), 1.0, 5e-3)
    yield Measurement("enthalpy taken along [J]", state.enthalpy_out, enthalpy, 1e-2)
    yield from books(state)


def isentropic_compression() -> Iterator[Measurement]:
    """T5p: as T5, the lid moving as a cosine within 30 ms, ten times slower than sound.

    The work of 8,000 particles on the lid varies by 1.13/sqrt(hits), 0.3 %; gamma by 0.002.
    """
    duration, dt = 0.030, 5e-5
    count = round(duration / dt)
    gas = in_a_box(IDEAL, 8_000, 1e5, 300.0)
    state = gas.start(bag_of_height(HEIGHT))
    for _ in steps(gas, state, count, dt, lambda t: HEIGHT * (0.75 + 0.25 * np.cos(np.pi * t / duration))):
        pass
    ratio = state.temperature[0] / 300.0
    yield Measurement("gamma [absolute]", 1.0 + np.log(ratio) / np.log(2.0), GAMMA, 1e-2)
    yield Measurement("temperature ratio at half the volume [-]", ratio, 2.0 ** (GAMMA - 1.0), 1e-2)
    pressure = []
    for _ in steps(gas, state, 100, dt, lambda t: 0.5 * HEIGHT, begin=count):
        pressure.append(state.pressure[0])
    yield Measurement("pressure ratio at half the volume [-]", np.mean(pressure) / 1e5, 2.0**GAMMA, 1e-2)
    yield from books(state)


def cooling() -> Iterator[Measurement]:
    """U5p: as U5, for two time constants. The loss follows its exponential, so that the only error is the fluctuating
    energy of the mean drift, which is not part of the temperature: 0.6/N of the total with 2,000 particles, 3e-4.
    """
    gas = in_a_box(IDEAL, 2_000, 2e5, 900.0, heat_conductance=np.array([40.0]))
    state = gas.start(bag_of_height(HEIGHT))
    start = state.particle_energy
    capacity, count = state.masses.sum() * GAS_CONSTANT / (GAMMA - 1.0), 200
    warmer = state.temperature[0] - 295.0
    end = 2.0 * capacity / 40.0
    for _ in steps(gas, state, count, end / count):
        pass
    # The loss of a gas step is taken before its flight: the temperature is that of the last gas step.
    expected = 295.0 + warmer * np.exp(-40.0 * state.gas_time / capacity)
    yield Measurement("temperature [K]", state.temperature[0], expected, 1e-3)
    yield Measurement("heat lost [J]", gas.totals(state).heat_lost, start - state.particle_energy, 1e-9)
    yield from books(state)


def wall_areas() -> np.ndarray:
    """Of the triangles of the box [m^2], (12,)."""
    bag = bag_of_height(HEIGHT)
    return np.linalg.norm(area_vectors(bag.surface.triangles, bag.positions), axis=1)


def over_walls(values: np.ndarray) -> float:
    """Over the walls of the box."""
    area = wall_areas()
    return float(values @ area / area.sum())
