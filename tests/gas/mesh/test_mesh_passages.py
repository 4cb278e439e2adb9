"""What flows into the mesh gas, out of it and between its chambers, against closed forms and uniform pressure."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from billow.apps.verification.gas import (
    GAMMA,
    GAS_CONSTANT,
    PYRO_FRACTIONS,
    PYRO_SPECIES,
    ROOM_HEIGHT,
    TWO_GASES,
    WHOLE,
    boxes_in_a_row,
    inflow,
    supply,
)
from billow.apps.verification.mesh_gas import SCHEMES, mesh_in, still
from billow.apps.verification.scenes import DEPTH, box
from billow.geometry.surface import Surface
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh.mesh_gas import MeshGas
from billow.parts.gas.supply.ambient import Ambient, InitialGas
from billow.parts.gas.supply.inflator import JetRing
from billow.parts.gas.supply.jets import Jets
from billow.parts.gas.supply.mixture import mixture_gas_constant
from billow.parts.gas.supply.outflow import GRAEFE, ORIFICE, orifice_flux
from billow.parts.gas.supply.passages import FABRIC, OPENING, VENT, Passage
from billow.parts.gas.supply.supply import Source
from billow.parts.gas.uniform.uniform_pressure import UniformPressure
from billow.parts.part import Loads

SECTION = DEPTH * ROOM_HEIGHT


def one_room(size=0.1):
    """A cube [m] whose lid is of its own part."""
    shape = box(size, size, size)
    return Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))


def two_rooms(lengths=(0.2, 0.3)):
    """Boxes in a row with an opening for a wall, and a mouth of four nodes in each end wall: (bag, mouths)."""
    bag = boxes_in_a_row(lengths)
    names = ("fabric", "opening_wall_1")
    surface = Surface.build(
        bag.surface.triangles, bag.surface.part, names, len(bag.positions), ("fabric", "opening"), bag.surface.chambers
    )
    ends = (bag.positions[:, 0].min(), bag.positions[:, 0].max())
    axes = (np.array([1.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]))
    mouths = [
        Jets(JetRing(1, 0.02, 0.01, 0.0), np.flatnonzero(bag.positions[:, 0] == end), axis, np.array([0.0, 1.0, 0.0]))
        for end, axis in zip(ends, axes, strict=True)
    ]
    return Bag(surface, bag.positions, np.zeros_like(bag.positions)), mouths


def end_wall(bag, chamber):
    """Triangles of the outer end wall of the first or the last room."""
    x = bag.positions[bag.surface.triangles][:, :, 0]
    return np.flatnonzero((x == (x.max() if chamber else x.min())).all(axis=1))


def uniform(gas, bag, end, dt=1e-5):
    """Totals at `end` of the same supply as uniform pressure."""
    fed = gas.supply
    if not fed.sources:  # it wants one
        none = inflow(0.0, 1.0, 300.0, fed.ambient.mass_fractions)
        fed = dataclasses.replace(fed, sources=(Source(none),))
    model = UniformPressure(fed)
    state, loads = model.start(bag), Loads(0, bag.surface)
    for k in range(round(end / dt)):
        model.advance(state, bag, k * dt, dt, loads)
    return model.totals(state)


def run(gas, bag, end):
    state = gas.start(bag)
    for _ in still(gas, state, end):
        pass
    assert state.mass_error < 1e-12
    assert state.energy_error < 1e-11
    return state, gas.totals(state)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_throttle(scheme):
    """Gas of 500 K is blown into a room, goes through an opening and leaves the next room through a vent. When it is
    steady, mass flow and total enthalpy are those of the inflator everywhere: no throttle changes h."""
    bag, mouths = two_rooms((0.1, 0.12))
    door = Passage("door", OPENING, ORIFICE, 0, 1, triangles=bag.surface.triangles_of("opening_wall_1"), area=0.06)
    vent = Passage("vent", VENT, ORIFICE, 1, triangles=end_wall(bag, 1), area=4e-3)
    source = Source(inflow(1.5, 1.0, 500.0, WHOLE), mouths[0], diffuse=True)
    choked = 2e5 * 1.5 / (4e-3 * orifice_flux(2e5, 1e5, GAMMA, GAS_CONSTANT * 500.0))  # by the law
    gas = mesh_in(bag, 0.06, scheme, choked, 500.0, sources=(source,), passages=(door, vent), outside=1e5)
    state = gas.start(bag)
    for _ in still(gas, state, 0.03):
        pass
    first, passed = gas.totals(state), state.passed.copy()
    begin = state.time
    for _ in still(gas, state, 0.04):
        pass
    now, span = gas.totals(state), state.time - begin
    flows = (state.passed - passed) @ [1.0, -1.0] / span
    assert flows == pytest.approx([1.5, 1.5], rel=5e-3)
    drained = (now.enthalpy_out - first.enthalpy_out) / (now.vented - first.vented)
    assert drained == pytest.approx(GAMMA / (GAMMA - 1.0) * GAS_CONSTANT * 500.0, rel=2e-3)
    assert now.chambers[1].pressure == pytest.approx(choked, rel=0.02)
    assert now.chambers[1].temperature == pytest.approx(500.0, rel=0.01)
    assert now.chambers[0].temperature == pytest.approx(500.0, rel=0.01)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_vent_draws_air_into_a_bag_below_ambient(scheme):
    """From 20 to 50 kPa the flow into it is choked: dp/dt = (gamma - 1) cp T0 m'/V, a constant."""
    bag = one_room()
    hole = Passage("hole", VENT, ORIFICE, 0, triangles=bag.surface.triangles_of("lid"), area=2e-4)
    gas = mesh_in(bag, 0.04, scheme, 2e4, 300.0, passages=(hole,), outside=1e5)
    flow = 2e-4 * orifice_flux(1e5, 2e4, GAMMA, GAS_CONSTANT * 300.0)
    span = 0.005
    _, now = run(gas, bag, span)
    rise = GAMMA * GAS_CONSTANT * 300.0 * flow * span / 1e-3
    assert 2e4 + rise < 5.28e4  # choked all the time
    assert now.drawn_in == pytest.approx(flow * span, rel=1e-3)
    assert now.vented == 0.0
    assert now.pressure == pytest.approx(2e4 + rise, rel=3e-3)
    other = uniform(gas, bag, span)
    assert now.pressure == pytest.approx(other.pressure, rel=3e-3)


def test_a_bag_below_ambient_fills_up_and_stays():
    """Through hole and porous fabric, until nothing flows; the energy more that is there is what came in."""
    bag = one_room()
    hole = Passage("hole", VENT, ORIFICE, 0, triangles=bag.surface.triangles_of("lid"), area=1e-3)
    walls = bag.surface.triangles_of(bag.surface.part_names[0])
    cloth = Passage("cloth", FABRIC, GRAEFE, 0, triangles=walls, area=0.05, coefficient=0.01)
    gas = mesh_in(bag, 0.04, pressure=3e4, passages=(hole, cloth), outside=1e5)
    _, now = run(gas, bag, 0.03)
    other = uniform(gas, bag, 0.03)
    assert now.pressure == pytest.approx(1e5, rel=2e-3)
    assert now.drawn_in - now.vented - now.leaked == pytest.approx(
        other.drawn_in - other.vented - other.leaked, rel=3e-3
    )
    exact = 1e-3 * 7e4 / (GAMMA * GAS_CONSTANT * 300.0)  # enthalpy that came in is energy that is there
    assert now.drawn_in - now.vented - now.leaked == pytest.approx(exact, rel=3e-3)


def test_each_chamber_has_vents_and_fabric_of_its_own():
    """Two rooms at 2 and 1.4 bar, of 400 and 300 K, a wall between them, each with a vent and porous fabric."""
    bag = boxes_in_a_row((0.2, 0.3))
    inside = InitialGas(np.array([2e5, 1.4e5]), np.array([400.0, 300.0]), np.ones((2, 1)))
    rows = (
        Passage("first", VENT, ORIFICE, 0, triangles=end_wall(bag, 0), area=4e-4, coefficient=0.7),
        Passage("second", VENT, ORIFICE, 1, triangles=end_wall(bag, 1), area=9e-4, coefficient=0.6),
        Passage("between", FABRIC, GRAEFE, 0, 1, triangles=bag.surface.triangles_of("wall_1"), area=SECTION,
                coefficient=0.005),
    )  # fmt: skip
    gas = mesh_in(bag, 0.05, passages=rows, initial=inside, outside=1e5)
    _, now = run(gas, bag, 0.02)
    other = uniform(gas, bag, 0.02)
    for name in ("first", "second"):
        assert now.vented_by[name] == pytest.approx(other.vented_by[name], rel=0.01), name
    assert now.passed["between"] == pytest.approx(other.passed["between"], rel=0.02)
    for one, two in zip(now.chambers, other.chambers, strict=True):
        assert one.pressure == pytest.approx(two.pressure, rel=5e-3)
        assert one.mass == pytest.approx(two.mass, rel=2e-3)


def test_several_inflators_of_several_gases():
    """Two rooms with a wall, three inflators: each gas where its inflator is, each room as uniform pressure has it."""
    bag, mouths = two_rooms()
    rows = (
        Source(inflow(0.5, 0.01, 600.0, np.array([1.0, 0.0])), mouths[0], diffuse=True),
        Source(inflow(0.3, 0.008, 900.0, np.array([0.0, 1.0])), mouths[0]),
        Source(_in_chamber(inflow(0.8, 0.012, 450.0, np.array([0.25, 0.75])), 1), mouths[1], diffuse=True),
    )
    air = Ambient(1e5, 300.0, np.array([0.5, 0.5]))
    gas = _mesh_of(TWO_GASES, air, bag, 0.05, rows)
    state, now = run(gas, bag, 0.02)
    other = uniform(gas, bag, 0.02)
    room = np.array([0.2, 0.3]) * SECTION
    air_mass = (1e5 * room / (mixture_gas_constant(gas.table, air.mass_fractions) * 300.0))[:, None] * [0.5, 0.5]
    came = np.array([[0.5 * 0.01, 0.3 * 0.008], [0.25 * 0.8 * 0.012, 0.75 * 0.8 * 0.012]])
    masses = np.array([sheet.masses for sheet in state.sheets])
    np.testing.assert_allclose(masses, air_mass + came, rtol=1e-12)
    assert now.injected == pytest.approx(came.sum(), rel=1e-12)
    for one, two in zip(now.chambers, other.chambers, strict=True):
        assert one.energy == pytest.approx(two.energy, rel=1e-10)
        assert one.pressure == pytest.approx(two.pressure, rel=3e-3)  # what still flows is not pressure


def test_species_keep_apart_and_mix_to_the_right_state():
    """A real mixture behind an opening, nitrogen as hot but thinner beside it: shares stay between nothing and all. The
    mean state in the end is that of uniform pressure, which knows the mixture from its totals alone; expansion cools
    the one gas and heats the other, which with cp(T) is not quite the same."""
    bag, _ = two_rooms((0.1, 0.1))
    door = Passage("door", OPENING, ORIFICE, 0, 1, triangles=bag.surface.triangles_of("opening_wall_1"), area=SECTION)
    hot, cold = PYRO_FRACTIONS, np.array([1.0, 0.0, 0.0])
    inside = InitialGas(np.array([3e5, 1e5]), np.full(2, 600.0), np.array([hot, cold]))
    gas = _mesh_of(PYRO_SPECIES, Ambient(1e-6, 300.0, cold), bag, 0.05, (), (door,), inside)
    state = gas.start(bag)
    before = gas.totals(state).mass_by_species
    for _ in still(gas, state, 0.02):
        shares = state.sheets[1].held[:, :3] / state.sheets[1].held[:, :3].sum(axis=1)[:, None]
        assert shares.min() > -1e-14
        assert shares.max() < 1.0 + 1e-14
    now = gas.totals(state)
    np.testing.assert_allclose(now.mass_by_species, before, rtol=1e-13)
    other = uniform(gas, bag, 0.2, 1e-4)
    assert now.energy == pytest.approx(other.energy, rel=1e-10)
    assert now.pressure == pytest.approx(other.pressure, rel=5e-3)
    assert state.sheets[1].masses[1] > 0.1 * before[1]  # of the water came over


def test_heat_loss_of_a_gas_in_one_state():
    """A bag within one cell is one cluster: m cv dT/dt = -h A (T - T0) exactly, p falls with T."""
    shape = box(0.05, 0.05, 0.05)
    names = ("fabric", "lid")
    surface = Surface.build(
        shape.surface.triangles, shape.surface.part, names, len(shape.positions), ("fabric", "fabric")
    )
    bag = Bag(surface, shape.positions, np.zeros_like(shape.positions))
    gas = mesh_in(bag, 0.2, pressure=2e5, temperature=900.0, outside=1e5, heat_conductance=np.array([0.5]))
    _, now = run(gas, bag, 0.3)
    mass = 2e5 * 0.05**3 / (GAS_CONSTANT * 900.0)
    capacity = mass * GAS_CONSTANT / (GAMMA - 1.0)
    assert now.temperature == pytest.approx(300.0 + 600.0 * np.exp(-0.3 * 0.5 / capacity), rel=1e-9)
    assert now.heat_lost == pytest.approx(capacity * 600.0 * (1.0 - np.exp(-0.3 * 0.5 / capacity)), rel=1e-9)


def test_heat_loss_begins_as_that_of_one_state():
    """In a bag of many cells only gas beside fabric cools; at the start that is the same power, h A (T - T0)."""
    bag = boxes_in_a_row((0.2, 0.3))
    surface = Surface.build(
        bag.surface.triangles, bag.surface.part, ("fabric", "wall_1"), len(bag.positions), ("fabric", "fabric"),
        bag.surface.chambers,
    )  # fmt: skip
    bag = Bag(surface, bag.positions, np.zeros_like(bag.positions))
    gas = mesh_in(bag, 0.05, pressure=2e5, temperature=900.0, outside=1e5, heat_conductance=np.array([4.0, 9.0]))
    _, now = run(gas, bag, 1e-3)
    assert now.heat_lost == pytest.approx(13.0 * 600.0 * 1e-3, rel=2e-3)
    other = uniform(gas, bag, 1e-3)
    for one, two in zip(now.chambers, other.chambers, strict=True):
        assert one.energy == pytest.approx(two.energy, rel=1e-5)


def _in_chamber(inflator, chamber):
    return dataclasses.replace(inflator, chamber=chamber)


def _mesh_of(species, ambient, bag, cell, sources, passages=(), initial=None):
    fed = supply(species, ambient, sources, bag.surface.chambers, passages, initial=initial)
    return MeshGas(fed, bag.surface, 1.0, cell)
