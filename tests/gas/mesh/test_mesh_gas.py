"""The mesh gas in bags that crumple, break into chambers, open, stop and go on."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import h5py
import numpy as np
import pytest
from run_fingerprint import fingerprint

from billow.apps.verification.gas import boxes_in_a_row
from billow.apps.verification.mesh_gas import SCHEMES, books, carry, mesh_in, moved, still
from billow.apps.verification.scenes import sphere
from billow.case.build import build_model
from billow.case.schema import Case
from billow.geometry.chambers import Chambers
from billow.geometry.surface import Surface
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh import moved as moved_module
from billow.parts.gas.mesh.clusters import LEAST
from billow.parts.gas.supply.ambient import InitialGas
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import OPENING, Passage
from billow.run.simulate import simulate


@pytest.mark.parametrize(
    ("seed", "crumpled"), [*((seed, 1.0) for seed in range(8)), *((seed, 3.0) for seed in range(8, 12))]
)
def test_crumpled_surfaces_that_lie_in_themselves(seed, crumpled, monkeypatch):
    """No cluster below the floor, energy and pressure positive everywhere, books exact; also where up to a quarter of
    the volume is inside out."""
    smallest = []
    real = moved_module.find_clusters

    def watched(*arguments):
        found = real(*arguments)
        smallest.append(min(found.before.min(), found.after.min()))
        return found

    monkeypatch.setattr(moved_module, "find_clusters", watched)
    random, shape = np.random.default_rng(seed), sphere(0.2, 2)

    def field():
        wave, phase = random.normal(size=(6, 3)) * random.uniform(5.0, 40.0), random.uniform(0.0, 2.0 * np.pi, 6)
        return np.sin(shape.positions @ wave.T + phase) @ random.normal(size=(6, 3))

    still_part, first, second = field(), field(), field()
    size, rate = crumpled * random.uniform(0.004, 0.015), random.uniform(100.0, 400.0)
    flat = np.array([1.0, 1.0, random.uniform(0.1, 0.6)])

    def at(time):
        swing = still_part + first * np.sin(rate * time) + second * np.cos(1.7 * rate * time)
        return (shape.positions + size * swing) * flat

    bag = Bag(shape.surface, at(0.0), np.zeros_like(shape.positions))
    gas = mesh_in(bag, random.uniform(0.015, 0.04), SCHEMES[seed % 2])
    state = gas.start(bag)
    for _ in moved(gas, state, at, 0.002, 0.9):
        pass
    assert min(smallest) > LEAST
    for check in books(state):
        assert abs(check.measured - check.expected) <= check.tolerance, check.title
    cells = gas.cells(state)
    assert cells["pressure"].min() > 0.0
    assert cells["temperature"].min() > 100.0


def rooms_with_an_opening():
    bag = boxes_in_a_row((0.2, 0.3))
    names = ("fabric", "opening_wall_1")
    surface = Surface.build(
        bag.surface.triangles, bag.surface.part, names, len(bag.positions), ("fabric", "opening"), bag.surface.chambers
    )
    door = Passage("door", OPENING, ORIFICE, 0, 1, triangles=surface.triangles_of("opening_wall_1"), area=0.06)
    return Bag(surface, bag.positions, np.zeros_like(bag.positions)), door


def test_an_opening_that_moves_through_gas_at_rest_leaves_it_at_rest():
    bag, door = rooms_with_an_opening()
    gas = mesh_in(bag, 0.03, passages=(door,))
    state = gas.start(bag)
    wall = np.flatnonzero(np.isclose(bag.positions[:, 0], 0.2))

    def at(time):
        places = bag.positions.copy()
        places[wall, 0] += 20.0 * time
        return places

    for _ in moved(gas, state, at, 2e-3):
        pass
    cells = gas.cells(state)
    np.testing.assert_allclose(cells["pressure"], 1e5, rtol=1e-11)
    assert np.abs(cells["velocity"]).max() < 1e-9
    assert state.passed[0].sum() > 0.0


def test_chambers_joined_by_an_opening_come_to_one_pressure():
    bag, door = rooms_with_an_opening()
    inside = InitialGas(np.array([2e5, 1e5]), np.array([400.0, 300.0]), np.ones((2, 1)))
    gas = mesh_in(bag, 0.04, SCHEMES[0], passages=(door,), initial=inside)
    state = gas.start(bag)
    before = gas.totals(state)
    for _ in still(gas, state, 0.05):
        pass
    now = gas.totals(state)
    assert now.mass == pytest.approx(before.mass, rel=1e-13)
    assert now.energy == pytest.approx(before.energy, rel=1e-13)
    assert now.pressure == pytest.approx(1.4e5, rel=2e-3)  # of 0.4 U/V, whatever flows
    first, second = (room.pressure for room in now.chambers)
    assert first == pytest.approx(second, rel=0.02)
    assert now.passed["door"] > 0.0


def test_a_closed_opening_is_a_wall():
    bag, door = rooms_with_an_opening()
    closed = Passage("door", OPENING, ORIFICE, 0, 1, triangles=door.triangles, area=0.06, opens_at=3e5)
    inside = InitialGas(np.array([2e5, 1e5]), np.array([400.0, 300.0]), np.ones((2, 1)))
    gas = mesh_in(bag, 0.04, passages=(closed,), initial=inside)
    state = gas.start(bag)
    for _ in still(gas, state, 2e-4):
        pass
    first, second = (room.pressure for room in gas.totals(state).chambers)
    assert (first, second) == (pytest.approx(2e5, rel=1e-12), pytest.approx(1e5, rel=1e-12))


def test_a_thin_layer_follows_panels_that_part():
    """From 4 to 8 mm at 20 m/s each, in cells of 20 mm: work and pressure of the adiabatic law, no damper (rho c v is 8
    kPa)."""
    bag = boxes_in_a_row((0.004,))
    middle = bag.positions[:, 0].mean()

    def at(time):
        places = bag.positions.copy()
        places[:, 0] += np.where(places[:, 0] > middle, 20.0, -20.0) * time
        return places

    single = Surface.build(bag.surface.triangles, bag.surface.part, ("outer",), len(bag.positions), ("fabric",))
    bag = Bag(single, bag.positions, np.zeros_like(bag.positions))
    gas = mesh_in(bag, 0.02)
    state = gas.start(bag)
    mass = state.sheets[0].held[:, 0].sum()
    for _ in moved(gas, state, at, 1e-4):
        pass
    exact = state.start_energy * (1.0 - 0.5**0.4)
    assert state.work == pytest.approx(exact, rel=0.02)
    assert state.sheets[0].held[:, 0].sum() == pytest.approx(mass, rel=1e-13)
    assert gas.totals(state).pressure == pytest.approx(1e5 * 0.5**1.4, rel=0.02)


def test_gas_and_bag_that_move_together_are_at_rest():
    shape = sphere(0.1, 2)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    velocity = np.array([30.0, -12.0, 7.0])
    gas = mesh_in(bag, 0.03)
    state = gas.start(bag)
    carry(state, velocity)
    for _ in moved(gas, state, lambda time: shape.positions + velocity * time, 2e-3):
        pass
    cells = gas.cells(state)
    np.testing.assert_allclose(cells["pressure"], 1e5, rtol=1e-3)


def test_gas_flows_no_farther_in_a_part_than_the_limit():
    shape = sphere(0.1, 1)
    gas = mesh_in(Bag(shape.surface, shape.positions, np.zeros_like(shape.positions)), 0.03)
    for speed, binds in ((100.0, False), (600.0, True)):
        state = gas.start(Bag(shape.surface, shape.positions, np.zeros_like(shape.positions)))
        carry(state, np.array([speed, 0.0, 0.0]))
        free, quarter = gas.longest_part(state), 0.25 * gas.cell / speed
        state.longest = None
        limited = dataclasses.replace(gas, flow_limit=0.25).longest_part(state)
        assert limited == pytest.approx(min(free, quarter), rel=1e-12)
        assert (limited < free) == binds


@pytest.fixture(scope="module")
def brief(small_case):
    return small_case.vary({"gas.model": "mesh", "gas.cell": 0.06, "bag.initial_gap": 0.04, "run.end_time": 0.001})


def test_stopped_half_way_and_resumed(in_two, brief, tmp_path):
    straight = simulate(brief, tmp_path / "straight", threads=1)
    resumed = in_two(brief, tmp_path / "run")
    assert fingerprint(resumed.folder) == fingerprint(straight.folder)
    assert resumed.record["ledger"] == straight.record["ledger"]
    assert straight.record["ledger"]["gas_mass_error"] < 1e-12
    assert straight.record["ledger"]["gas_energy_error"] < 1e-11


def test_the_example_differs_from_uniform_pressure_in_its_gas_alone():
    case = Case.load(Path(__file__).parents[3] / "examples" / "gas" / "driver_mesh.toml")
    model = build_model(case).gas.model
    assert (model.cell, model.advection) == (0.02, "van_leer")
    other = case.vary({"gas.model": "uniform-pressure"})
    assert other.bag == case.bag
    assert not list(build_model(other).gas.model.concerns(None))


def test_frames_and_sensors_show_the_gas(brief, tmp_path):
    place = {"name": "middle", "position": [0.0, 0.0, 0.01]}
    result = simulate(brief.vary({"run.sensors": [place]}), tmp_path / "run", threads=1)
    with h5py.File(result.folder / "gas.vtkhdf") as file:
        image = file["VTKHDF/bag"]
        np.testing.assert_allclose(image["Steps/Values"], result.times)
        there = image["CellData/vtkGhostType"][()] == 0
        fields = {name: image[f"CellData/{name}"][()][there] for name in image["CellData"]}
        cell, volume = image.attrs["Spacing"].prod(), result.histories["volume [m^3]"]
        for k, time in enumerate(result.times):
            inside = image["CellData/volume_fraction"][k].sum() * cell
            assert inside == pytest.approx(np.interp(time, result.histories.time, volume), rel=1e-4)
    assert {"pressure", "temperature", "density", "velocity", "volume_fraction"} <= set(fields)
    assert sum(fields[name] for name in fields if name.startswith("mass_fraction_")) == pytest.approx(1.0, abs=1e-5)
    assert fields["volume_fraction"].min() > 0.0
    assert fields["pressure"].min() > 5e4
    pressure = result.histories["middle_gas_pressure [Pa]"]
    assert pressure[0] == pytest.approx(101325.0, rel=1e-9)
    assert np.abs(pressure - 101325.0).max() > 100.0
    gauge = result.fabric.cell_data("gauge_pressure")[0]
    assert np.abs(gauge).max() < 1e-6  # at the start
    assert result.fabric.cell_data("gas_temperature")[-1].max() > 300.0


def test_frames_end_at_the_switch_to_uniform_pressure(brief, tmp_path):
    """Uniform pressure has no cells; what a lattice shows has the same fields in every frame."""
    result = simulate(brief.vary({"gas.switch_time": 0.0005, "run.frames": 4}), tmp_path / "run", threads=1)
    with h5py.File(result.folder / "gas.vtkhdf") as file:
        image = file["VTKHDF/bag"]
        times = image["Steps/Values"][()]
        assert {len(image[f"CellData/{name}"]) for name in image["CellData"]} == {len(times)}
    assert 0.0 < times[-1] < 0.00051 < result.times[-1]


@pytest.mark.slow
def test_one_thread_and_two(monkeypatch, threads):
    """Every kernel in its parallel compilation, with one thread and with two, and in the serial one."""
    from billow.base import compiled

    shape = sphere(0.2, 2)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    found = []
    for count, least in ((1, 10**9), (2, 1)):
        monkeypatch.setattr(compiled, "PARALLEL_FROM", least)
        threads(count)
        gas = mesh_in(bag, 0.04, pressure=2e5)
        state = gas.start(bag)
        for _ in moved(gas, state, lambda time: shape.positions * (1.0 + 20.0 * time), 5e-4):
            pass
        found.append(state.sheets[0])
    np.testing.assert_array_equal(found[0].held, found[1].held)
    np.testing.assert_array_equal(found[0].force, found[1].force)


def test_two_chambers_share_no_wall_by_mistake():
    """Each chamber's walls point out of it."""
    bag = boxes_in_a_row((0.1, 0.2))
    gas = mesh_in(bag, 0.05)
    assert isinstance(bag.surface.chambers, Chambers)
    state = gas.start(bag)
    for walls, cut, volume in zip(gas.rooms(state).walls, gas.cut(state), state.volume, strict=True):
        assert cut.total * gas.cell**3 == pytest.approx(volume, rel=1e-12), walls.name
