"""T1 to T6, U1 to U5: the uniform-pressure gas against closed forms (docs/theory.md, Verification cases).

One chamber is a box whose walls stand still or are moved by hand, so that the volume is exact; several are boxes in a
row that share walls. The gas is advanced by `UniformPressure.advance`, as in a run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from billow.apps.verification.check import Measurement
from billow.apps.verification.scenes import DEPTH, HEIGHT, VOLUME, WIDTH, bag_of_height
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.surface import Surface
from billow.parts.gas.gas_model import Bag, GasModel
from billow.parts.gas.supply.ambient import Ambient, InitialGas
from billow.parts.gas.supply.inflator import Inflator
from billow.parts.gas.supply.mixture import mixture_cp, mixture_gas_constant
from billow.parts.gas.supply.outflow import ORIFICE, orifice_flux
from billow.parts.gas.supply.passages import OPENING, PRESENT_AREA, VENT, Passage, Passages
from billow.parts.gas.supply.species import MOLAR_GAS_CONSTANT, SPECIES, Species, mass_fractions, thermo_table
from billow.parts.gas.supply.supply import Source, Supply
from billow.parts.gas.uniform.uniform_pressure import UniformPressure, UniformState
from billow.parts.part import Loads

GAS_CONSTANT, GAMMA = 287.0, 1.4
IDEAL, WHOLE = [Species.ideal("ideal", GAS_CONSTANT, GAMMA)], np.ones(1)
PYRO = {"N2": 0.45, "H2O": 0.30, "CO2": 0.25}
TWO_GASES = [Species.ideal("light", 400.0, GAMMA), Species.ideal("heavy", 200.0, GAMMA)]
"""Of equal gamma, so that p V = (gamma - 1) U whatever the mixture."""
ROOM_HEIGHT = 0.3
AIR = Ambient(101325.0, 295.0, np.array([0.5, 0.5]))
PYRO_SPECIES, PYRO_FRACTIONS = [SPECIES[name] for name in PYRO], np.array(list(mass_fractions(PYRO).values()))


def inflow(flow: float, duration: float, temperature: float, fractions: np.ndarray) -> Inflator:
    """Constant mass flow [kg/s] at a total temperature [K] for a duration [s]."""
    times = np.array([0.0, duration])
    return Inflator(times, np.full(2, flow), times, np.full(2, temperature), fractions)


def supply(
    species: list[Species], ambient: Ambient, sources: tuple[Source, ...], chambers: Chambers,
    passages: tuple[Passage, ...] = (), **more,
) -> Supply:  # fmt: skip
    """more: further fields of `Supply`."""
    names = tuple(s.name for s in species)
    return Supply(thermo_table(species), names, sources, ambient, chambers, Passages(passages), **more)


def uniform_gas(
    species: list[Species], ambient: Ambient, *inflators: Inflator, chambers: Chambers | None = None, **more
) -> UniformPressure:
    """Gas of the box or of other chambers, at the start as outside; without inflators one that gives nothing.

    more: further arguments of `supply`.
    """
    sources = tuple(map(Source, inflators or [inflow(0.0, 1.0, 300.0, ambient.mass_fractions)]))
    return UniformPressure(supply(species, ambient, sources, chambers or Chambers.single(12), **more))


def steps(
    gas: GasModel, state, count: int, dt: float, height: Callable[[float], float] | None = None, begin: int = 0
) -> Iterator[float]:
    """Advance by `count` steps of dt [s], with the lid at height(time) [m], and yield the time [s] after each."""
    bag = bag_of_height(HEIGHT)
    loads = Loads(0, bag.surface)
    for k in range(begin, begin + count):
        if height is not None:
            low, high = height(k * dt), height((k + 1) * dt)
            bag = bag_of_height(high)
            bag.velocities[bag.positions[:, 2] > 0.0, 2] = (high - low) / dt
        gas.advance(state, bag, k * dt, dt, loads)
        yield (k + 1) * dt


def last(of: Iterator) -> None:
    """Run all steps."""
    for _ in of:
        pass


def rigid_tank() -> Iterator[Measurement]:
    """T1. "Evacuated" is 1e-9 Pa, 2e-14 of the mass, four orders below the tolerance. The balance has no discretisation
    error, so the number of steps (300) only adds rounding."""
    gas = uniform_gas(IDEAL, Ambient(1e-9, 300.0, WHOLE), inflow(1.0, 0.030, 600.0, WHOLE))
    state = gas.start(bag_of_height(HEIGHT))
    last(steps(gas, state, 300, 1e-4))
    final = GAMMA * 600.0
    yield Measurement("temperature of the tank [K]", state.temperature[0], final, 1e-10)
    yield Measurement("pressure of the tank [Pa]", state.pressure[0], 0.030 * GAS_CONSTANT * final / VOLUME, 1e-10)


def filling_at_constant_pressure() -> Iterator[Measurement]:
    """T2: the pyrotechnic mixture fills a cylinder whose piston follows the exact solution, V = V0 + m R T_in / p. It
    starts with 1e-7 of the final volume, at 300 K, which shifts the end by less than 1e-7; every step adds 1 % to the
    volume, so that the first steps are as well resolved as the last (iteration error per step below 1e-9)."""
    pressure, hot, flow = 101325.0, 600.0, 1.0
    gas = uniform_gas(PYRO_SPECIES, Ambient(pressure, 300.0, PYRO_FRACTIONS), inflow(flow, 1.0, hot, PYRO_FRACTIONS))
    per_second = flow * mixture_gas_constant(gas.supply.table, PYRO_FRACTIONS) * hot / pressure  # m^3/s
    heights = 1e-7 * HEIGHT * 1.01 ** np.arange(1621)  # the last is the first beyond HEIGHT
    times = (heights - heights[0]) * WIDTH * DEPTH / per_second
    bag = bag_of_height(heights[0])
    state, loads = gas.start(bag), Loads(0, bag.surface)
    for height, time, before in zip(heights[1:], times[1:], times[:-1], strict=True):
        gas.advance(state, bag_of_height(height), before, time - before, loads)
    yield Measurement("temperature behind the piston [K]", state.temperature[0], hot, 1e-6)
    yield Measurement("pressure behind the piston [Pa]", state.pressure[0], pressure, 1e-6)


def choked_blow_down() -> Iterator[Measurement]:
    """T3: the step is of second order; at 20 us the relative error is 1e-9, and that of `np.interp`, which looks for 2
    bar within the last step, 1e-8."""
    hole, inside = Passage("hole", VENT, ORIFICE, 0, area=1e-3), InitialGas.like(Ambient(5e5, 600.0, WHOLE), 1)
    tank = uniform_gas(IDEAL, Ambient(101325.0, 295.0, WHOLE), initial=inside, passages=(hole,))
    state = tank.start(bag_of_height(HEIGHT))
    full = state.masses.sum()
    rows = [(0.0, state.pressure[0], state.temperature[0], 1.0)]
    for time in steps(tank, state, 10_000, 2e-5):
        rows.append((time, state.pressure[0], state.temperature[0], state.masses.sum() / full))
        if state.pressure[0] < 2e5:
            break
    yield from blown_down(rows, 1e-7)


def blown_down(rows: list[tuple[float, ...]], tolerance: float) -> Iterator[Measurement]:
    """The blow-down of `choked_blow_down` at 2 bar; rows: time [s], pressure [Pa], temperature [K] and share of the
    mass [-], the last below 2 bar. The remaining gas expands isentropically and the choked flow is proportional to
    p/sqrt(T): tau = V / (Cd A sqrt(g R T0) (2/(g+1))^((g+1)/(2(g-1)))) (Shapiro 1953)."""
    times, pressures, temperatures, masses = np.array(rows).T
    time, temperature, mass = (np.interp(-2e5, -pressures, column) for column in (times, temperatures, masses))
    g = GAMMA
    tau = VOLUME / (1e-3 * np.sqrt(g * GAS_CONSTANT * 600.0) * (2.0 / (g + 1.0)) ** (0.5 * (g + 1.0) / (g - 1.0)))
    expected_time = 2.0 * tau / (g - 1.0) * (2.5 ** (0.5 * (g - 1.0) / g) - 1.0)
    yield Measurement("time from 5 to 2 bar [s]", time, expected_time, tolerance)
    yield Measurement("temperature at 2 bar [K]", temperature, 600.0 * 0.4 ** ((g - 1.0) / g), tolerance)
    yield Measurement("share of the mass at 2 bar [-]", mass, 0.4 ** (1.0 / g), tolerance)


def critical_flow() -> Iterator[Measurement]:
    """T4: at the ratio (2/(g+1))^(g/(g-1)) an orifice chokes; the flux is p/sqrt(R T) times sqrt(g)
    (2/(g+1))^((g+1)/(2(g-1))). The ratio is found by bisection for where the flux begins to fall below its choked value
    by 1e-15; as it falls with the square of the distance, that is within 4e-8."""
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
    """T5: the work of a step is a trapezium in p(V), so the error is about (dV/V)^2/10, 1e-7 with 1000 steps."""
    gas = uniform_gas(IDEAL, Ambient(1e5, 300.0, WHOLE))
    bag = bag_of_height(HEIGHT)
    state, loads = gas.start(bag), Loads(0, bag.surface)
    for k in range(1, 1001):
        gas.advance(state, bag_of_height(HEIGHT * (1.0 - 0.5 * k / 1000)), (k - 1) * 1e-5, 1e-5, loads)
    ratio = state.temperature[0] / 300.0
    yield Measurement("pressure ratio at half the volume [-]", state.pressure[0] / 1e5, 2.0**GAMMA, 1e-5)
    yield Measurement("temperature ratio at half the volume [-]", ratio, 2.0 ** (GAMMA - 1.0), 1e-5)


def mixture_properties() -> Iterator[Measurement]:
    """T6: the published values (GRI-Mech 3.0) have four digits."""
    table = thermo_table(PYRO_SPECIES)
    gas_constant = mixture_gas_constant(table, PYRO_FRACTIONS)
    yield Measurement("molar mass [g/mol]", 1e3 * MOLAR_GAS_CONSTANT / gas_constant, 29.01, 1e-3)
    published = ((300.0, 1119.0, 1.344), (650.0, 1271.0, 1.291), (800.0, 1331.0, 1.275), (1000.0, 1403.0, 1.257))
    for temperature, heat_capacity, gamma in published:
        cp = mixture_cp(table, PYRO_FRACTIONS, temperature)
        yield Measurement(f"cp at {temperature:.0f} K [J/(kg K)]", cp, heat_capacity, 1e-3)
        yield Measurement(f"cp/cv at {temperature:.0f} K [-]", cp / (cp - gas_constant), gamma, 1e-3)


def boxes_in_a_row(widths: tuple[float, ...]) -> Bag:
    """Boxes of these widths [m] side by side along x; the wall between two belongs to both, normal towards the second.

    Chambers are called room_1, room_2, ...; parts are "outer" and "wall_1", "wall_2", ...
    """
    places = np.concatenate([[0.0], np.cumsum(widths)])
    ring = np.array([[0.0, 0.0], [DEPTH, 0.0], [DEPTH, ROOM_HEIGHT], [0.0, ROOM_HEIGHT]])
    positions = np.array([[x, y, z] for x in places for y, z in ring])
    last = len(places) - 1
    around = [(k, 4 * k + j, 4 * k + (j + 1) % 4) for k in range(last) for j in range(4)]
    quads = [[0, 3, 2, 1], *([4 * k + j for j in range(4)] for k in range(1, last + 1))]
    quads += [[a, b, b + 4, a + 4] for _, a, b in around]
    sides = [(0, OUTSIDE), *((k - 1, k) for k in range(1, last)), (last - 1, OUTSIDE)]
    sides += [(k, OUTSIDE) for k, _, _ in around]
    part = [0, *range(1, last), 0] + [0] * len(around)
    triangles = np.array([[q[0], q[m], q[m + 1]] for q in quads for m in (1, 2)])
    behind, ahead = np.repeat(np.array(sides, dtype=np.int32), 2, axis=0).T
    chambers = Chambers(tuple(f"room_{k + 1}" for k in range(last)), behind.copy(), ahead.copy())
    names = ("outer", *(f"wall_{k}" for k in range(1, last)))
    surface = Surface.build(triangles, np.repeat(part, 2), names, len(positions), ("fabric",) * last, chambers)
    return Bag(surface, positions, np.zeros_like(positions))


def joined_rooms(
    bag: Bag, passages: tuple[Passage, ...], pressure: list[float], temperature: list[float], light: list[float],
    *inflators: Inflator, **more,
) -> UniformPressure:  # fmt: skip
    """Rooms with these pressures [Pa], temperatures [K] and mass fractions of the light gas at the start; more: further
    fields of `Supply`."""
    shares = np.column_stack([light, 1.0 - np.array(light)])
    initial = InitialGas(np.array(pressure), np.array(temperature), shares)
    parts = {"chambers": bag.surface.chambers, "passages": passages, "initial": initial}
    return uniform_gas(TWO_GASES, AIR, *inflators, **parts, **more)


def run(gas: UniformPressure, bag: Bag, steps: int, dt: float) -> tuple[UniformState, np.ndarray]:
    """The state after some steps, and the pressures [Pa] on the way, (steps + 1, chambers)."""
    state, loads = gas.start(bag), Loads(0, bag.surface)
    pressures = [state.pressure.copy()]
    for k in range(steps):
        gas.advance(state, bag, k * dt, dt, loads)
        pressures.append(state.pressure.copy())
    return state, np.array(pressures)


def orifice(name: str, behind: int, ahead: int, area: float) -> Passage:
    """A hole of this effective area [m^2]."""
    return Passage(name, VENT if ahead == OUTSIDE else OPENING, ORIFICE, behind, ahead, area=area)


def _settled(gas: UniformPressure, bag: Bag, state: UniformState, tolerance: float = 1e-12) -> Iterator[Measurement]:
    """All pressures equal (gamma - 1) U / V of the whole, and nothing is lost."""
    start = gas.start(bag)
    common = (GAMMA - 1.0) * start.energy.sum() / start.volume.sum()
    for name, pressure in zip(gas.supply.chambers.names, state.pressure, strict=True):
        yield Measurement(f"pressure in {name} [Pa]", pressure, common, tolerance)
    for k, name in enumerate(gas.supply.species_names):
        yield Measurement(f"mass of the {name} gas [kg]", state.masses[:, k].sum(), start.masses[:, k].sum(), 1e-12)
    yield Measurement("energy [J]", state.energy.sum(), start.energy.sum(), 1e-12)
    totals = gas.totals(state)
    yield Measurement("mass ledger, each chamber and species [absolute]", totals.mass_error, 0.0, 1e-12)
    yield Measurement("energy ledger, each chamber [absolute]", totals.energy_error, 0.0, 1e-12)


def two_rooms() -> Iterator[Measurement]:
    """U1: two rooms at 3 and 1 bar, 600 and 300 K, of different gas, joined by a hole that is half the wall between
    them: a real patch of the mesh. p V = (gamma - 1) U holds for each and for both, whatever the way there."""
    bag = boxes_in_a_row((0.4, 0.1))
    wall = bag.surface.triangles_of("wall_1")[:1]
    hole = Passage("hole", OPENING, ORIFICE, 0, 1, wall, 0.5 * DEPTH * ROOM_HEIGHT, 0.01, area_terms=PRESENT_AREA)
    gas = joined_rooms(bag, (hole,), [3e5, 1e5], [600.0, 300.0], [1.0, 0.0])
    state, _ = run(gas, bag, 3000, 2e-5)
    yield from _settled(gas, bag, state)


def _three_rooms(first: float, second: float) -> tuple[Bag, UniformPressure]:
    """A chain of rooms; areas of the holes between them [m^2]."""
    bag, holes = boxes_in_a_row((0.4, 0.02, 0.2)), (orifice("first", 0, 1, first), orifice("second", 1, 2, second))
    return bag, joined_rooms(bag, holes, [1e5, 5e5, 2e5], [300.0, 900.0, 500.0], [0.2, 0.9, 0.5])


def chain() -> Iterator[Measurement]:
    """U2: three rooms in a chain, the middle one the smallest; settles as U1."""
    bag, gas = _three_rooms(2e-4, 1e-3)
    state, _ = run(gas, bag, 6000, 5e-5)
    yield from _settled(gas, bag, state)


def stiff_chain() -> Iterator[Measurement]:
    """U3: the chain with holes 1000 times larger: a step is a hundred times the settling time of the rooms. No pressure
    may leave the range of the first ones, and the difference between the rooms may never grow. Pressures are rounded to
    1e-16; a step amplifies this error in proportion to its flow per pressure, hence 1e-10."""
    bag, gas = _three_rooms(0.2, 1.0)
    state, pressures = run(gas, bag, 200, 5e-4)
    yield from _settled(gas, bag, state, 1e-10)
    span = np.ptp(pressures, axis=1)
    growth = max(0.0, *(after - before for before, after in pairwise(span / span[0])))
    outside = max(0.0, pressures.max() / 5e5 - 1.0, 1.0 - pressures.min() / 1e5)
    yield Measurement("growth of the pressure difference, of the first [absolute]", growth, 0.0, 1e-10)
    yield Measurement("pressure beyond the first range, relative [absolute]", outside, 0.0, 1e-10)


def blown_through() -> Iterator[Measurement]:
    """U4: an inflator of 1 kg/s at 600 K blows into a room with a vent; in the end inflow equals outflow. The vents of
    2e-3 m^2 (choked), 1e-2 m^2 and 1 m^2 (7 Pa above ambient, which an explicit step would miss by far) run with steps
    of 0.1 ms for 1 s, twenty times the residence time behind the first: its start is forgotten to 2e-9."""
    bag = boxes_in_a_row((0.5,))
    source = inflow(1.0, 10.0, 600.0, AIR.mass_fractions)
    rt = float(AIR.mass_fractions @ thermo_table(TWO_GASES)[:, 0]) * 600.0
    for area in (2e-3, 1e-2, 1.0):

        def excess(pressure, area=area):
            return area * orifice_flux(pressure, AIR.pressure, GAMMA, rt) - 1.0

        expected, vent = brentq(excess, AIR.pressure, 1e7, xtol=1e-9), orifice("vent", 0, OUTSIDE, area)
        gas = joined_rooms(bag, (vent,), [AIR.pressure], [AIR.temperature], [0.5], source)
        state, _ = run(gas, bag, 10_000, 1e-4)
        gauge, expected = state.pressure[0] - AIR.pressure, expected - AIR.pressure
        yield Measurement(f"gauge pressure, vent of {area:g} m^2 [Pa]", gauge, expected, 1e-6)
        yield Measurement(f"temperature, vent of {area:g} m^2 [K]", state.temperature[0], 600.0, 1e-7)


def cooling() -> Iterator[Measurement]:
    """U5: the step's own exponential is exact where cp is constant, so that only rounding is left; run with a step a
    tenth of and ten times the time constant."""
    bag = boxes_in_a_row((0.5,))
    for count in (20, 2):
        gas = joined_rooms(bag, (), [2e5], [900.0], [0.5], heat_conductance=np.array([40.0]))
        start = gas.start(bag)
        capacity = start.energy[0] / 900.0  # m cv
        end = 2.0 * capacity / 40.0 if count == 20 else 20.0 * capacity / 40.0
        state, _ = run(gas, bag, count, end / count)
        expected = AIR.temperature + 605.0 * np.exp(-40.0 * end / capacity)
        yield Measurement(f"temperature after {count} steps [K]", state.temperature[0], expected, 1e-12)
        lost = gas.totals(state).heat_lost
        yield Measurement(f"heat lost in {count} steps [J]", lost, start.energy[0] - state.energy[0], 1e-12)
