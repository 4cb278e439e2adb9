"""T1p to U5p, T15 to T20: the corpuscular gas against closed forms of thermodynamics and kinetic theory
(docs/theory.md, Verification cases), and a leak audit.

The gas is advanced by `Corpuscular.advance`, as in a run, in a box whose walls stand still or are moved by hand.
Each case has enough particles to keep its statistical error, named in its docstring, below its tolerance, and one seed,
so that it gives the same numbers every time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from billow.apps.verification.check import Measurement
from billow.apps.verification.gas import GAMMA, GAS_CONSTANT, IDEAL, WHOLE, blown_down, inflow, last, steps, supply
from billow.apps.verification.scenes import DEPTH, HEIGHT, VOLUME, WIDTH, bag_of_height, box
from billow.case.bag.build_bag import build_shape
from billow.case.gas.build_gas import build_gas
from billow.case.schema import Case
from billow.geometry.surface import area_vectors
from billow.parts.gas.corpuscular.corpuscular import SMOOTHING, Corpuscular
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.ambient import Ambient, InitialGas
from billow.parts.gas.supply.inflator import Inflator, JetRing
from billow.parts.gas.supply.jets import Jets
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import VENT, Passage
from billow.parts.gas.supply.species import SPECIES, Species, mass_fractions
from billow.parts.gas.supply.supply import Source
from billow.parts.part import Loads

MONATOMIC = [Species.ideal("monatomic", GAS_CONSTANT, 5.0 / 3.0)]
DRIVER = {
    "bag": {"element_size": 0.05, "initial_gap": 0.04},
    "fabric": {"permeability": 0.0275},
    "gas": {"model": "corpuscular", "particles": 8000},
}
LID = np.array([10, 11])
ATMOSPHERE = 101325.0


def in_a_box(
    species: list[Species], particles: int, pressure: float, temperature: float, height: float = HEIGHT, *,
    fractions: np.ndarray = WHOLE, inflator: Inflator | None = None, outside: float = ATMOSPHERE, **more,
) -> Corpuscular:  # fmt: skip
    """Gas at pressure [Pa] and temperature [K]; outside: pressure [Pa]. An inflator blows upwards from the bottom
    through a hole of 0.1 m, in all directions. more: further arguments of `supply`."""
    shape = box(WIDTH, DEPTH, height)
    bottom = np.flatnonzero(shape.positions[:, 2] == 0.0)
    jets = Jets(JetRing(1, 0.0, 0.1, 0.0, cone=0.5 * np.pi), bottom, *np.eye(3)[[2, 0]])
    sources = () if inflator is None else (Source(inflator, jets),)
    initial = InitialGas.like(Ambient(pressure, temperature, fractions), 1)
    ambient = Ambient(outside, 295.0, fractions)
    filled = supply(species, ambient, sources, shape.surface.chambers, initial=initial, **more)
    return Corpuscular(filled, shape.surface, shape.reference, particles)


def started(*arguments, height: float = HEIGHT, **more) -> tuple[Corpuscular, CorpuscularState]:
    """The gas of `in_a_box` and its state at the start."""
    gas = in_a_box(*arguments, height, **more)
    return gas, gas.start(bag_of_height(height))


def books(state: CorpuscularState) -> Iterator[Measurement]:
    """Mass by count, energy and momentum of gas and walls together."""
    yield Measurement("largest mass error [absolute]", state.mass_error, 0.0, 1e-12)
    yield Measurement("largest energy error [absolute]", state.energy_error, 0.0, 1e-9)
    yield Measurement("largest momentum error [absolute]", state.momentum_error, 0.0, 1e-11)


def rigid_tank() -> Iterator[Measurement]:
    """T1p: as T1. Temperature is that of all energy, exact but for the last particle, 1e-4; pressure that of flight,
    equation 8 of the LS-DYNA paper: 0.5/sqrt(8,000) = 0.6 % at a time, 0.1 % over 40 independent ones; that on the
    walls has 3e5 hits, 1.13/sqrt(hits) = 0.2 %."""
    gas, state = started(IDEAL, 8_000, 1e-9, 300.0, inflator=inflow(1.0, 0.030, 600.0, WHOLE))
    last(steps(gas, state, 640, 5e-5))
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
    """T2p: as T2, from a twentieth of the final volume, filled with the same gas at T_in. The piston follows the exact
    solution. Statistical error 0.5/sqrt(N) at a time, 0.1 % over the last quarter."""
    hot, flow, start, dt = 600.0, 0.5, 0.05 * HEIGHT, 1e-4
    rise = flow * GAS_CONSTANT * hot / ATMOSPHERE / (WIDTH * DEPTH)
    count = int((HEIGHT - start) / (rise * dt))
    inflator = inflow(flow, count * dt, hot, WHOLE)
    gas, state = started(IDEAL, 8_000, ATMOSPHERE, hot, height=start, inflator=inflator)
    moved = steps(gas, state, count, dt, lambda time: start + rise * time)
    pressure = [state.pressure[0] for time in moved if time > 0.75 * count * dt]
    yield Measurement("temperature behind the piston [K]", state.temperature[0], hot, 1e-2)
    yield Measurement("pressure behind the piston [Pa]", np.mean(pressure), ATMOSPHERE, 1e-2)
    yield from books(state)


def choked_blow_down() -> Iterator[Measurement]:
    """T3p: as T3, through a lid that lets particles pass at the rate of the law. Half of 8,000 particles leave: 1.6 %
    of those that remain. The energy they carry (2 k T in flight at a hole, internal energy, and k T/2 from the others)
    is the enthalpy of continuum outflow: 0.6/sqrt(4,000) = 0.9 %."""
    hole = Passage("hole", VENT, ORIFICE, 0, triangles=LID, area=1e-3)
    gas, state = started(IDEAL, 8_000, 5e5, 600.0, passages=(hole,), outside=1e5)
    full = state.masses.sum()
    rows = [(0.0, 5e5, 600.0, 1.0)]
    enthalpy, flight = 0.0, []
    for time in steps(gas, state, 2500, 1e-4):
        mass, temperature = state.masses.sum() / full, state.temperature[0]
        enthalpy += (rows[-1][3] - mass) * full * GAMMA / (GAMMA - 1.0) * GAS_CONSTANT * rows[-1][2]
        pressure = mass * full * GAS_CONSTANT * temperature / VOLUME
        flight.append(state.pressure[0] / pressure)
        rows.append((time, pressure, temperature, mass))
        if pressure < 2e5:
            break
    yield from blown_down(rows, 3e-2)
    yield Measurement("pressure of flight over m R T/V [-]", np.mean(flight), 1.0, 5e-3)
    yield Measurement("enthalpy taken along [J]", state.enthalpy_out, enthalpy, 1e-2)
    yield from books(state)


def isentropic_compression() -> Iterator[Measurement]:
    """T5p: as T5, the lid moving as a cosine within 30 ms, ten times slower than sound. The work of 8,000 particles on
    the lid varies by 1.13/sqrt(hits), 0.3 %; gamma by 0.002."""
    duration, dt = 0.030, 5e-5
    count = round(duration / dt)
    gas, state = started(IDEAL, 8_000, 1e5, 300.0)
    last(steps(gas, state, count, dt, lambda t: HEIGHT * (0.75 + 0.25 * np.cos(np.pi * t / duration))))
    ratio = state.temperature[0] / 300.0
    yield Measurement("gamma [absolute]", 1.0 + np.log(ratio) / np.log(2.0), GAMMA, 1e-2)
    yield Measurement("temperature ratio at half the volume [-]", ratio, 2.0 ** (GAMMA - 1.0), 1e-2)
    pressure = [state.pressure[0] for _ in steps(gas, state, 100, dt, lambda t: 0.5 * HEIGHT, begin=count)]
    yield Measurement("pressure ratio at half the volume [-]", np.mean(pressure) / 1e5, 2.0**GAMMA, 1e-2)
    yield from books(state)


def cooling() -> Iterator[Measurement]:
    """U5p: as U5, for two time constants. The loss follows its exponential, so that the only error is the fluctuating
    energy of the mean drift, which is not part of the temperature: 0.6/N of the total with 2,000 particles, 3e-4."""
    gas, state = started(IDEAL, 2_000, 2e5, 900.0, heat_conductance=np.array([40.0]))
    start, warmer = state.particle_energy, state.temperature[0] - 295.0
    capacity, count = state.masses.sum() * GAS_CONSTANT / (GAMMA - 1.0), 200
    last(steps(gas, state, count, 2.0 * capacity / 40.0 / count))
    # The loss of a gas step is taken before its flight: the temperature is that of the last gas step.
    expected = 295.0 + warmer * np.exp(-40.0 * state.gas_time / capacity)
    yield Measurement("temperature [K]", state.temperature[0], expected, 1e-3)
    yield Measurement("heat lost [J]", gas.totals(state).heat_lost, start - state.particle_energy, 1e-9)
    yield from books(state)


def maxwell() -> Iterator[Measurement]:
    """T15: particles that all start equally fast end with Maxwell's speeds: mean over rms sqrt(8/(3 pi)), and kurtosis
    3 of a component. 8,000 particles, 10 times 0.5 ms apart: 0.1 % and 0.3 %."""
    gas, state = started(MONATOMIC, 8_000, 1e5, 300.0)
    velocity = state.particles.velocity[: state.particles.count]
    velocity *= (np.sqrt(3.0 * GAS_CONSTANT * 300.0) / np.linalg.norm(velocity, axis=1))[:, None]
    state.sums = None
    ratio, kurtosis = [], []
    for k, _ in enumerate(steps(gas, state, 160, 5e-5)):
        if k >= 60 and k % 10 == 9:
            velocity = state.particles.velocity[: state.particles.count]
            square = np.sum(velocity**2, axis=1)
            ratio.append(np.sqrt(square).mean() / np.sqrt(square.mean()))
            kurtosis.append(np.mean(velocity**4) / np.mean(velocity**2) ** 2)
    yield Measurement("mean over rms speed [-]", np.mean(ratio), np.sqrt(8.0 / (3.0 * np.pi)), 2e-3)
    yield Measurement("kurtosis of a component [-]", np.mean(kurtosis), 3.0, 1e-2)


def flux() -> Iterator[Measurement]:
    """T16: a monatomic gas; 2e5 hits: 0.2 %. Then holes that let one in fifty pass, until half of 8,000 particles have
    left: 0.7/sqrt(4,000) = 1.1 %, four of them independent: 0.55 %. The additional k T/2 of the outflow is booked
    separately."""
    gas, state = started(MONATOMIC, 8_000, 1e5, 300.0)
    expected = 1e5 / np.sqrt(2.0 * np.pi * GAS_CONSTANT * 300.0)
    struck = [over_walls(state.bank.mass_flux[:, 0]) for _ in steps(gas, state, 220, 1e-4)]
    yield Measurement("flux of mass on a wall [kg/m^2/s]", np.mean(struck[20:]), expected, 1e-2)
    hole = Passage("holes", VENT, ORIFICE, 0, triangles=np.arange(12), area=0.02)
    taken = warmth = 0.0
    for seed in range(4):
        gas = replace(in_a_box(MONATOMIC, 8_000, 1e5, 300.0, passages=(hole,), outside=1.0), seed=seed)
        state = gas.start(bag_of_height(HEIGHT))
        before = state.masses.sum(), state.temperature[0]
        for _ in steps(gas, state, 100, 1e-4):
            mass, temperature = state.masses.sum(), state.temperature[0]
            warmth += (before[0] - mass) * GAS_CONSTANT * before[1]
            before = mass, temperature
        taken += state.enthalpy_out
    yield Measurement("energy of those that leave over k T [-]", taken / warmth - 0.5, 2.0, 1e-2)


def relaxation() -> Iterator[Measurement]:
    """T17: a gas of two internal degrees of freedom that starts with all its energy in flight. 8,000 particles, 200
    steps, of which 20 are independent: 0.13 %."""
    gas, state = started(IDEAL, 8_000, 1e5, 300.0)
    state.particles.internal_energy[:] = 0.0
    state.sums = None
    start = 2.0 / 3.0 * _flight(state, gas).sum() / VOLUME
    pressure = [state.pressure[0] for _ in steps(gas, state, 260, 5e-5)]
    yield Measurement("flight temperature over that at the start [-]", np.mean(pressure[60:]) / start, 0.6, 5e-3)


def mixture() -> Iterator[Measurement]:
    """T18: helium at 450 K and argon at 300 K in one box, half of the molecules each, end at 375 K. 4,000 particles
    each: sqrt(2/3)/sqrt(4,000) = 1.3 % at a time, 0.2 % over 200 steps."""
    fractions = np.array(list(mass_fractions({"He": 0.5, "Ar": 0.5}).values()))
    gas, state = started([SPECIES["He"], SPECIES["Ar"]], 8_000, 1e5, 300.0, fractions=fractions)
    number = state.particles.count
    light = state.particles.species[:number] == 0
    state.particles.velocity[:number][light] *= np.sqrt(1.5)
    state.sums = None
    kinds = ParticleKinds(gas.table, state.molecules)
    total = 2.0 / 3.0 * _flight(state, gas).sum()
    last(steps(gas, state, 100, 5e-5))
    found, pressure = [], []
    for _ in steps(gas, state, 200, 5e-5, begin=100):
        species_now, energy = state.particles.species[:number], _flight(state, gas)
        found.append([energy[species_now == s].mean() / (1.5 * kinds.heat) for s in (0, 1)])
        pressure.append(over_walls(state.bank.pressure[:, 0]))
    common = total / (number * kinds.heat)
    helium, argon = np.mean(found, axis=0)
    yield Measurement("temperature of helium [K]", helium, common, 5e-3)
    yield Measurement("temperature of argon [K]", argon, common, 5e-3)
    yield Measurement("pressure on the walls [Pa]", np.mean(pressure), number * kinds.heat * common / VOLUME, 5e-3)


def wall_noise() -> Iterator[Measurement]:
    """T19: speeds across a wall are Rayleigh's, <v^2>/<v>^2 = 4/pi, and arrivals are independent. Pressure of single
    steps, from the running mean that takes the share 1 - exp(-dt/tau) of each. A step sees 1 % of the particles at
    most, which are as good as independent. Triangles of three sizes and two numbers of particles; 480 steps, four
    triangles: 2 % for each standard deviation."""
    dt, area = 5e-5, wall_areas()
    share = -np.expm1(-dt / SMOOTHING)
    hits, noise, level = [], [], []
    for particles in (1_000, 8_000):
        gas, state = started(MONATOMIC, particles, 1e5, 300.0)
        means = [state.bank.pressure[:, 0].copy() for _ in steps(gas, state, 500, dt)]
        pressure = (np.diff(means, axis=0) / share + means[:-1])[20:] / 1e5
        a_second = state.particles.count / VOLUME * np.sqrt(GAS_CONSTANT * 300.0 / (2.0 * np.pi))
        level.append(pressure.mean(axis=0) @ area / area.sum())
        for size in np.unique(area.round(9)):
            of_size = np.isclose(area, size)
            hits.append(a_second * size * dt)
            noise.append(np.sqrt(np.mean((pressure[:, of_size] - 1.0) ** 2)))
    slope, _ = np.polyfit(np.log(hits), np.log(noise), 1)
    yield Measurement("mean pressure over n k T [-]", np.mean(level), 1.0, 5e-3)
    yield Measurement("noise times sqrt(hits) [-]", np.mean(noise * np.sqrt(hits)), np.sqrt(4.0 / np.pi), 0.1)
    yield Measurement("slope of noise over hits, double logarithmic [absolute]", slope, -0.5, 0.03)


def leak_audit() -> Iterator[Measurement]:
    """T20: a driver bag is crushed to a sixth of its height, blown up and shaken within 20 ms, while jets blow into it
    and gas leaves through vents and fabric. Each motion is affine, so that no fabric goes through other fabric, and the
    mouth does not tilt."""
    case = Case.from_dict(DRIVER)
    shape = build_shape(case.bag)
    gas, x = build_gas(case, shape).model, shape.positions
    still = np.zeros_like(x)
    state = gas.start(Bag(shape.surface, x.copy(), still))
    dt, last, loads = 2e-5, x.copy(), Loads(0, shape.surface)
    for k in range(1000):
        phase = 2.0 * np.pi * (k + 1) * dt / 0.010
        moved = x * [1.0, 1.0, 4.0 ** np.sin(phase) * 0.5 ** (0.5 - 0.5 * np.cos(phase))]
        moved[:, 0] += 2.0 * np.sin(3.0 * phase) * moved[:, 2]
        moved[:, 1] += np.sin(2.0 * phase) * moved[:, 2]
        gas.advance(state, Bag(shape.surface, moved, (moved - last) / dt), k * dt, dt, loads)
        last = moved
    yield Measurement("particles found outside their chamber [absolute]", state.escaped, 0.0, 0.5)
    yield from books(state)


def _flight(state: CorpuscularState, gas: Corpuscular) -> np.ndarray:
    """Kinetic energy of each particle [J], (particles,)."""
    particles, kinds = state.particles, ParticleKinds(gas.table, state.molecules)
    n = particles.count
    return 0.5 * kinds.mass[particles.species[:n]] * np.sum(particles.velocity[:n] ** 2, axis=1)


def wall_areas() -> np.ndarray:
    """Of the triangles of the box [m^2], (12,)."""
    bag = bag_of_height(HEIGHT)
    return np.linalg.norm(area_vectors(bag.surface.triangles, bag.positions), axis=1)


def over_walls(values: np.ndarray) -> float:
    """Over the walls of the box."""
    area = wall_areas()
    return float(values @ area / area.sum())
