"""U1 to U5: several chambers, stiff exchange and heat loss of the uniform-pressure gas, against closed forms.

Chambers are boxes in a row that share walls; nothing moves.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from billow.apps.verification.check import Measurement
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.surface import Surface
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.ambient import Ambient, InitialGas
from billow.parts.gas.supply.inflator import Inflator
from billow.parts.gas.supply.outflow import ORIFICE, orifice_flux
from billow.parts.gas.supply.passages import OPENING, PRESENT_AREA, VENT, Passage, Passages
from billow.parts.gas.supply.species import Species, thermo_table
from billow.parts.gas.supply.supply import Source, Supply
from billow.parts.gas.uniform.uniform_pressure import UniformPressure, UniformState

GAMMA = 1.4
TWO_GASES = [Species.ideal("light", 400.0, GAMMA), Species.ideal("heavy", 200.0, GAMMA)]
"""Of equal gamma, so that p V = (gamma - 1) U whatever the mixture."""
DEPTH, HEIGHT = 0.2, 0.3
AIR = Ambient(101325.0, 295.0, np.array([0.5, 0.5]))


def boxes_in_a_row(widths: tuple[float, ...]) -> Bag:
    """Boxes of these widths [m] side by side along x; the wall between two belongs to both, normal towards the second.

    Chambers are called room_1, room_2, ...; parts are "outer" and "wall_1", "wall_2", ...
    """
    places = np.concatenate([[0.0], np.cumsum(widths)])
    ring = np.array([[0.0, 0.0], [DEPTH, 0.0], [DEPTH, HEIGHT], [0.0, HEIGHT]])
    positions = np.array([[x, y, z] for x in places for y, z in ring])
    last = len(places) - 1
    quads = [[0, 3, 2, 1]] + [[4 * k + j for j in range(4)] for k in range(1, last + 1)]
    sides = [(0, OUTSIDE), *((k - 1, k) for k in range(1, last)), (last - 1, OUTSIDE)]
    part = [0, *range(1, last), 0]
    for k in range(last):
        for j in range(4):
            i = (j + 1) % 4
            quads.append([4 * k + j, 4 * k + i, 4 * k + 4 + i, 4 * k + 4 + j])
            sides.append((k, OUTSIDE))
            part.append(0)
    triangles = np.array([[q[0], q[m], q[m + 1]] for q in quads for m in (1, 2)])
    behind, ahead = np.repeat(np.array(sides, dtype=np.int32), 2, axis=0).T
    chambers = Chambers(tuple(f"room_{k + 1}" for k in range(last)), behind.copy(), ahead.copy())
    names = ("outer", *(f"wall_{k}" for k in range(1, last)))
    surface = Surface.build(triangles, np.repeat(part, 2), names, len(positions), ("fabric",) * last, chambers)
    return Bag(surface, positions, np.zeros_like(positions))


def joined_rooms(
    bag: Bag, passages: tuple[Passage, ...], pressure: list[float], temperature: list[float], light: list[float],
    inflators: tuple[Inflator, ...] | None = None, heat_conductance: np.ndarray | None = None,
) -> UniformPressure:  # fmt: skip
    """Rooms with these pressures [Pa], temperatures [K] and mass fractions of the light gas at the start."""
    nothing = Inflator(np.array([0.0, 1.0]), np.zeros(2), np.array([0.0, 1.0]), np.full(2, 300.0), AIR.mass_fractions)
    share = np.array(light)
    supply = Supply(
        table=thermo_table(TWO_GASES),
        species_names=("light", "heavy"),
        sources=tuple(map(Source, inflators or (nothing,))),
        ambient=AIR,
        chambers=bag.surface.chambers,
        passages=Passages(passages),
        initial=InitialGas(np.array(pressure), np.array(temperature), np.column_stack([share, 1.0 - share])),
        heat_conductance=heat_conductance,
    )
    return UniformPressure(supply)


def run(gas: UniformPressure, bag: Bag, steps: int, dt: float) -> tuple[UniformState, np.ndarray]:
    """The state after some steps, and the pressures [Pa] on the way, (steps + 1, chambers)."""
    state = gas.start(bag)
    force = np.zeros((bag.surface.triangle_count, 3, 3))
    pressures = [state.pressure.copy()]
    for k in range(steps):
        gas.advance(state, bag, k * dt, dt, force)
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
    """U1: two rooms at 3 and 1 bar, 600 and 300 K, of different gas, joined by a hole through the wall between them.

    Sealed and rigid, they keep U, and p V = (gamma - 1) U holds for each and for both: the pressure they settle to does
    not depend on the way there. The hole is half the wall: a real patch of the mesh.
    """
    bag = boxes_in_a_row((0.4, 0.1))
    wall = bag.surface.triangles_of("wall_1")[:1]
    hole = Passage("hole", OPENING, ORIFICE, 0, 1, wall, 0.5 * DEPTH * HEIGHT, 0.01, area_terms=PRESENT_AREA)
    gas = joined_rooms(bag, (hole,), [3e5, 1e5], [600.0, 300.0], [1.0, 0.0])
    state, _ = run(gas, bag, 3000, 2e-5)
    yield from _settled(gas, bag, state)


def chain() -> Iterator[Measurement]:
    """U2: three rooms in a chain, the middle one the smallest; settles as U1."""
    bag = boxes_in_a_row((0.4, 0.02, 0.2))
    holes = (orifice("first", 0, 1, 2e-4), orifice("second", 1, 2, 1e-3))
    gas = joined_rooms(bag, holes, [1e5, 5e5, 2e5], [300.0, 900.0, 500.0], [0.2, 0.9, 0.5])
    state, _ = run(gas, bag, 6000, 5e-5)
    yield from _settled(gas, bag, state)


def stiff_chain() -> Iterator[Measurement]:
    """U3: the chain with holes 1000 times larger: a step is a hundred times the settling time of the rooms.

    Flows of the old pressures alone would overshoot a hundredfold in every step. No pressure may leave the range of the
    first ones, and the difference between the rooms may never grow. Pressures are rounded to 1e-16; a step amplifies
    this error in proportion to its flow per pressure, hence 1e-10.
    """
    bag = boxes_in_a_row((0.4, 0.02, 0.2))
    holes = (orifice("first", 0, 1, 0.2), orifice("second", 1, 2, 1.0))
    gas = joined_rooms(bag, holes, [1e5, 5e5, 2e5], [300.0, 900.0, 500.0], [0.2, 0.9, 0.5])
    state, pressures = run(gas, bag, 200, 5e-4)
    yield from _settled(gas, bag, state, 1e-10)
    span = np.ptp(pressures, axis=1)
    growth = max(0.0, *(after - before for before, after in pairwise(span / span[0])))
    outside = max(0.0, pressures.max() / 5e5 - 1.0, 1.0 - pressures.min() / 1e5)
    yield Measurement("growth of the pressure difference, of the first [absolute]", growth, 0.0, 1e-10)
    yield Measurement("pressure beyond the first range, relative [absolute]", outside, 0.0, 1e-10)


def blown_through() -> Iterator[Measurement]:
    """U4: an inflator of 1 kg/s at 600 K blows into a room with a vent; in the end inflow equals outflow.

    Then T = T_in (all enthalpy that enters leaves), and at the pressure the orifice passes 1 kg/s. The vents of 2e-3
    m^2 (choked), 1e-2 m^2 and 1 m^2 (7 Pa above ambient, which an explicit step would miss by far) run with steps of
    0.1 ms for 1 s, twenty times the residence time behind the first: its start is forgotten to 2e-9.
    """
    bag = boxes_in_a_row((0.5,))
    fractions = AIR.mass_fractions
    source = Inflator(np.array([0.0, 10.0]), np.ones(2), np.array([0.0, 1.0]), np.full(2, 600.0), fractions)
    rt = float(fractions @ thermo_table(TWO_GASES)[:, 0]) * 600.0
    for area in (2e-3, 1e-2, 1.0):
        expected = brentq(
            lambda p, a=area: a * orifice_flux(p, AIR.pressure, GAMMA, rt) - 1.0, AIR.pressure, 1e7, xtol=1e-9
        )
        gas = joined_rooms(
            bag, (orifice("vent", 0, OUTSIDE, area),), [AIR.pressure], [AIR.temperature], [0.5], (source,)
        )
        state, _ = run(gas, bag, 10_000, 1e-4)
        gauge, expected = state.pressure[0] - AIR.pressure, expected - AIR.pressure
        yield Measurement(f"gauge pressure, vent of {area:g} m^2 [Pa]", gauge, expected, 1e-6)
        yield Measurement(f"temperature, vent of {area:g} m^2 [K]", state.temperature[0], 600.0, 1e-7)


def cooling() -> Iterator[Measurement]:
    """U5: a sealed room cools through its walls: T - T_amb falls as exp(-h A t/(m cv)), for any step.

    The step's own exponential is exact where cp is constant, so that only rounding is left; run with a step a tenth of
    and ten times the time constant.
    """
    bag = boxes_in_a_row((0.5,))
    for steps in (20, 2):
        gas = joined_rooms(bag, (), [2e5], [900.0], [0.5], heat_conductance=np.array([40.0]))
        start = gas.start(bag)
        capacity = start.energy[0] / 900.0  # m cv
        end = 2.0 * capacity / 40.0 if steps == 20 else 20.0 * capacity / 40.0
        state, _ = run(gas, bag, steps, end / steps)
        expected = AIR.temperature + 605.0 * np.exp(-40.0 * end / capacity)
        yield Measurement(f"temperature after {steps} steps [K]", state.temperature[0], expected, 1e-12)
        lost = gas.totals(state).heat_lost
        yield Measurement(f"heat lost in {steps} steps [J]", lost, start.energy[0] - state.energy[0], 1e-12)
