"""From particles to uniform pressure: nothing is lost on the way, and a restart on either side changes no bit."""

from __future__ import annotations

import copy
import dataclasses

import numpy as np
import pytest
from plain_loads import on_nodes

from billow.case.bag.build_bag import build_shape
from billow.case.gas.build_gas import build_gas
from billow.case.schema import Case
from billow.parts.gas.corpuscular.corpuscular import Corpuscular
from billow.parts.gas.gas_model import Bag, LocalGas
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gas_constant
from billow.parts.part import Loads
from billow.run.check import describe
from billow.solver.checkpoint import flatten, restore

SWITCH, DT = 3e-3, 2e-5
LAST = round(SWITCH / DT) - 1
"""The step that ends at the switch."""

DRIVER = {"diameter": 0.4, "element_size": 0.05, "initial_gap": 0.05, "straps": {"count": 0}}
VENTS = {"distance": 0.13, "diameter": 0.03}
TWO_CHAMBERS = {
    "shape": "rectangular", "length": 0.6, "width": 0.3, "chambers": 2, "mouth_radius": 0.04, "element_size": 0.05,
    "initial_gap": 0.05, "vents": {"diameter": 0.03, "panel": "front"},
}  # fmt: skip
FLOW = {"time": [0.0, 0.002, 0.008], "value": [0.0, 1.5, 0.0]}


def scene(bag=None, permeability=0.03, **gas):
    case = Case.from_dict(
        {
            "bag": DRIVER | {"vents": VENTS} if bag is None else bag,
            "fabric": {"permeability": permeability},
            "gas": {"model": "corpuscular", "particles": 2000, "switch_time": SWITCH} | gas,
            "inflator": {"mass_flow": FLOW, "temperature": 600.0, "jets": {"count": 4}},
        }
    )
    shape = build_shape(case.bag)
    return build_gas(case, shape).model, shape


def swaying(start, time):
    moved = start * [1.0, 1.0, 1.0 + 2.0 * np.sin(300.0 * time) ** 2]
    moved[:, 0] += 0.4 * moved[:, 2] * np.sin(500.0 * time)
    return moved


class Drive:
    """A bag moved by hand, step by step."""

    def __init__(self, gas, shape, motion=swaying):
        self.gas, self.shape, self.motion, self.step = gas, shape, motion, 0
        positions = motion(shape.positions, 0.0)
        loads = Loads(0, shape.surface)
        self.state = gas.start(Bag(shape.surface, positions, np.zeros_like(positions)))
        gas.advance(self.state, Bag(shape.surface, positions, np.zeros_like(positions)), 0.0, 0.0, loads)
        self.force = on_nodes(loads, shape.surface, positions)

    def to(self, step):
        while self.step < step:
            before, after = (self.motion(self.shape.positions, (self.step + k) * DT) for k in (0, 1))
            bag = Bag(self.shape.surface, after, (after - before) / DT)
            loads = Loads(0, self.shape.surface)
            self.gas.advance(self.state, bag, self.step * DT, DT, loads)
            self.force = on_nodes(loads, self.shape.surface, after)
            self.step += 1
        return self.gas.totals(self.state)


def still(start, time):
    return start


def test_it_switches_in_the_step_that_ends_at_the_time():
    drive = Drive(*scene())
    drive.to(LAST)
    assert not drive.state.switched
    assert drive.state.local.particles.count > 100
    drive.to(LAST + 1)
    assert drive.state.switched
    assert drive.state.local.particles.count == 0
    assert isinstance(scene(switch_time=0.0)[0], Corpuscular)


@pytest.mark.parametrize("bag", [None, TWO_CHAMBERS], ids=["one", "two"])
def test_mass_by_species_and_energy_go_over_exactly(bag):
    """Sealed, so that each species is what was there and what came; to rounding of a sum of 2,000."""
    sealed = {"vents": VENTS | {"count": 0}} if bag is None else {"vents": bag["vents"] | {"chambers": []}}
    drive = Drive(*scene((bag or DRIVER) | sealed, permeability=0.0))
    start = drive.to(0)
    for step in (LAST, LAST + 1, LAST + 2, LAST + 60):
        now = drive.to(step)
        came = start.mass_by_species + now.injected * drive.gas.supply.inflators[0].mass_fractions
        assert now.mass_by_species == pytest.approx(came, rel=1e-12)
        booked = start.energy + now.enthalpy_in - now.enthalpy_out - now.work - now.jet_work
        assert now.energy == pytest.approx(booked, rel=1e-12)
        assert max(now.mass_error, now.energy_error) < 1e-12
    assert sum(room.mass for room in now.chambers or (now,)) == pytest.approx(now.mass, rel=1e-13)


def test_the_flow_comes_to_rest_as_heat():
    """All energy, that of the flow included, is thermal after the switch."""
    drive = Drive(*scene(DRIVER | {"vents": VENTS | {"count": 0}}, permeability=0.0), motion=still)
    before, after = drive.to(LAST), drive.to(LAST + 1)
    masses, gas = after.mass_by_species, drive.gas
    thermal = mixture_enthalpy(gas.supply.table, masses, after.temperature)
    thermal -= mixture_gas_constant(gas.supply.table, masses) * after.temperature
    assert after.energy == pytest.approx(thermal, rel=1e-12)
    assert after.energy - before.energy == pytest.approx(after.enthalpy_in - before.enthalpy_in, rel=1e-9)
    ideal = mixture_gas_constant(gas.supply.table, masses) * after.temperature
    assert after.pressure * after.volume == pytest.approx(ideal, rel=1e-12)


def test_the_work_of_the_step_between_is_the_work_done():
    """Half a step of the particles' force and half a step of the new one, in the books as on the nodes: trapezia."""
    drive = Drive(*scene())
    before = drive.to(LAST)
    old = drive.force
    after = drive.to(LAST + 1)
    moved = swaying(drive.shape.positions, SWITCH) - swaying(drive.shape.positions, SWITCH - DT)
    done = 0.5 * float(np.sum((old + drive.force) * moved))
    assert abs(done) > 0.05
    assert after.work_on_fabric - before.work_on_fabric == pytest.approx(done, rel=1e-9)


def test_sums_go_on_where_they_were():
    drive = Drive(*scene())
    before = drive.to(LAST)
    after = drive.to(LAST + 1)
    later = drive.to(LAST + 40)
    for name in ("injected", "vented", "leaked", "drawn_in", "enthalpy_in", "enthalpy_out"):
        assert getattr(after, name) >= getattr(before, name), name
        assert getattr(later, name) >= getattr(after, name), name
        # No more comes or goes in one step than twice the largest flow.
        assert getattr(after, name) - getattr(before, name) <= 2.0 * DT * 1.5 * (1e6 if "enthalpy" in name else 1.0)
    assert after.vented_by.keys() == before.vented_by.keys()
    assert sum(later.vented_by.values()) == pytest.approx(later.vented, rel=1e-12)
    assert sum(later.leaked_by.values()) == pytest.approx(later.leaked, rel=1e-12)
    assert later.vented > before.vented > 0.0


def test_a_vent_that_is_open_stays_open():
    """It opened at 20 kPa of gauge pressure; at the switch there is less."""
    vents = VENTS | {"opening_pressure": 2e4}

    def growing(start, time):
        return start * [1.0, 1.0, 1.0 + 3.0 * min(1.0, max(0.0, time - 0.5 * SWITCH) / (0.5 * SWITCH))]

    drive = Drive(*scene(DRIVER | {"vents": vents}, permeability=0.0), motion=growing)
    rows = drive.gas.uniform.supply.passages.rows
    before = drive.to(LAST)
    assert before.pressure - drive.gas.supply.ambient.pressure < 2e4
    opened = drive.state.local.is_open.copy()
    assert opened[[row.opens_at > 0.0 for row in rows]].all()
    drive.to(LAST + 1)
    assert (drive.state.uniform.is_open == opened).all()


def test_frames_have_the_same_names_and_shapes_before_and_after():
    drive = Drive(*scene(TWO_CHAMBERS))
    places = np.array([swaying(drive.shape.positions, SWITCH)[:, k].mean() for k in range(3)] + [5.0] * 3).reshape(2, 3)
    places[0, 0] -= 0.15  # in the first chamber
    looks = []
    for step in (LAST, LAST + 1):
        drive.to(step)
        gas, state = drive.gas, drive.state
        looks.append((gas.fields(state), gas.cells(state), gas.points(state), gas.at(state, places)))
    assert isinstance(drive.gas, LocalGas)
    for before, after in zip(*looks, strict=True):
        assert after.keys() == before.keys()
        for name, array in after.items():
            assert array.shape[1:] == before[name].shape[1:]
            assert np.isfinite(array).all()
    fields, boxes, points, read = looks[1]
    first, second = drive.gas.totals(drive.state).chambers
    assert len(points["position"]) == 0
    assert boxes["pressure"].tolist() == [first.pressure, second.pressure]
    assert boxes["density"].tolist() == pytest.approx([c.mass / c.volume for c in (first, second)], rel=1e-14)
    positions = swaying(drive.shape.positions, SWITCH)
    assert (boxes["centre"] - 0.5 * boxes["size"]).min(axis=0) == pytest.approx(positions.min(axis=0), abs=1e-12)
    assert (boxes["centre"] + 0.5 * boxes["size"]).max(axis=0) == pytest.approx(positions.max(axis=0), abs=1e-12)
    assert set(fields["gas_temperature"]) == {first.temperature, second.temperature}
    assert read["pressure"][0] == first.pressure
    assert read["pressure"][1] == drive.gas.supply.ambient.pressure
    assert read["temperature"].tolist()[1] == drive.gas.supply.ambient.temperature
    drive.to(LAST + 30)  # the boxes follow the bag
    boxes, positions = drive.gas.cells(drive.state), swaying(drive.shape.positions, SWITCH + 30 * DT - DT)
    assert (boxes["centre"] + 0.5 * boxes["size"]).max(axis=0) == pytest.approx(positions.max(axis=0), abs=1e-12)


@pytest.mark.parametrize("stop", [LAST - 20, LAST, LAST + 1, LAST + 20])
def test_a_restart_before_or_after_the_switch_changes_no_bit(stop):
    end = LAST + 40
    straight = Drive(*scene())
    stopped = Drive(*scene())
    stopped.to(stop)
    arrays, numbers = copy.deepcopy(flatten(stopped.state))
    again = Drive(*scene())
    again.state = restore(again.state, arrays, numbers)
    again.step = stop
    whole, parts = straight.to(end), again.to(end)
    assert straight.force.tobytes() == again.force.tobytes()
    for a, b in zip(flatten(straight.state), flatten(again.state), strict=True):
        for name, value in a.items():
            assert np.array_equal(value, b[name], equal_nan=True), name
    assert whole.energy == parts.energy
    assert whole.vented == parts.vented


def test_it_waits_until_every_chamber_holds_gas():
    """A chamber as good as empty has no pressure to carry on with."""
    gas, shape = scene(TWO_CHAMBERS | {"vents": TWO_CHAMBERS["vents"] | {"chambers": []}})
    drive = Drive(gas, shape, motion=still)
    drive.to(LAST)
    drive.state.local.masses[1] = 0.0
    late = dataclasses.replace(gas, time=0.0)
    kept = drive.state.local.masses.copy()
    drive.gas = late
    drive.to(LAST + 1)
    assert not drive.state.switched
    assert kept[1].sum() == 0.0
    drive.to(LAST + 9)
    assert drive.state.switched


def test_the_check_of_a_case_says_when():
    case = {"bag": DRIVER, "gas": {"model": "corpuscular", "particles": 2000, "switch_time": "12 ms"}}
    assert "corpuscular until 12 ms, then uniform-pressure" in describe(Case.from_dict(case))
    case["gas"]["model"] = "uniform-pressure"  # where there is nothing to switch
    assert "until" not in describe(Case.from_dict(case))
