"""The mesh gas in a folded bag: strips keep the order in which gas comes to them, and join without a trace."""

from __future__ import annotations

import copy
import dataclasses

import numpy as np
import pytest

from billow.apps.verification.gas import WHOLE, inflow
from billow.apps.verification.mesh_gas import mesh_in, moved, still
from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.schema import Case
from billow.geometry.folding.strips import find_strips
from billow.geometry.surface import Surface
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh import mesh_gas, rooms
from billow.parts.gas.supply.inflator import JetRing
from billow.parts.gas.supply.jets import Jets
from billow.parts.gas.supply.outflow import GRAEFE, ORIFICE
from billow.parts.gas.supply.passages import FABRIC, VENT, Passage
from billow.parts.gas.supply.supply import Source
from billow.solver.checkpoint import flatten, restore

TUBE = {
    "shape": "rectangular", "length": 1.0, "width": 0.16, "mouth_radius": 0.02, "mouth_offset": [-0.42, 0.0],
    "element_size": 0.035, "folds": [{"kind": "half"}, {"kind": "half"}],
}  # fmt: skip
CELL = 0.03
APART = 12.0
"""Panels lie so many times as far apart as when folded: 5 mm. Layers then lie 10 mm apart, three in a cell."""


def tube(folded=True):
    """The bag, and its strips."""
    case = Case.from_dict({"bag": TUBE})
    shape, plan = build_shape(case.bag), fold_plan(case.bag)
    strips = find_strips(plan, shape, 3.0 * CELL)
    positions = shape.positions if folded else plan.unfolded(shape.positions)
    positions = np.ascontiguousarray(positions * [1.0, 1.0, APART])
    return Bag(shape.surface, positions, np.zeros_like(positions)), strips


def gas_of(bag, strips, **more):
    """Air, and a source of 0.03 kg/s of it through the mouth."""
    surface: Surface = bag.surface
    nodes = np.unique(surface.triangles[surface.triangles_of_kind("mouth")])
    jets = Jets(JetRing(1, 0.01, 0.01, 0.0), nodes, np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))
    source = Source(inflow(0.03, 1.0, 300.0, WHOLE), jets, diffuse=True)
    return dataclasses.replace(mesh_in(bag, CELL, sources=(source,), **more), strips=strips)


def quarters(gas, state, strips):
    """Pressure [Pa] behind the fabric of each quarter of the tube, from the mouth on, mean over its triangles."""
    of = strips.chambers.behind[: gas.surface.triangle_count]
    pressure = gas.fields(state)["gauge_pressure"] + gas.supply.ambient.pressure
    whole = pressure * strips.area
    mean = np.bincount(of, whole, 4) / np.bincount(of, strips.area, 4)
    return mean if mean[0] >= mean[-1] else mean[::-1]


def after(gas, bag, end):
    state = gas.start(bag)
    for _ in still(gas, state, end):
        pass
    assert state.mass_error < 1e-12
    assert state.energy_error < 1e-11
    return state


def test_gas_comes_to_the_strips_one_after_the_other():
    """In the order of a straight tube; one sheet of cells for the folded bag lets gas go from layer to layer at once.

    Folds reflect much of the wave, so that behind them there is less than in the straight tube."""
    bag, strips = tube()
    flat, _ = tube(folded=False)
    end = 1.2e-3  # sound goes 0.42 m, to the second line
    found = {}
    for name, body, parts in (("straight", flat, None), ("strips", bag, strips), ("one", bag, None)):
        gas = gas_of(body, parts)
        found[name] = quarters(gas, after(gas, body, end), strips) / 1e5 - 1.0
    straight, parted, one = found["straight"], found["strips"], found["one"]
    assert parted[0] > parted[1] > parted[2] > -1e-9
    assert parted[3] < 1e-3 * parted[0]  # the far end has felt nothing
    assert straight[3] < 1e-3 * straight[0]
    assert one[3] > 0.05 * one[0]


def test_gas_goes_along_a_roll_and_not_across_its_laps():
    """A tube of which the far half is rolled up, laps 10 mm apart in cells of 30 mm: its end feels nothing before sound
    has come there along the roll. In one sheet of cells it does at once."""
    rolled = {**TUBE, "element_size": 0.025, "folds": [{"kind": "roll", "to": 0.1, "core": 0.012, "layer_gap": 0.01}]}
    case = Case.from_dict({"bag": rolled})
    shape, plan = build_shape(case.bag), fold_plan(case.bag)
    strips = find_strips(plan, shape, 3.0 * CELL)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    along = plan.unfolded(shape.positions)[shape.surface.triangles][:, :, 0].mean(axis=1)
    end, mouth = along > 0.4, along < -0.35
    found = []
    for parts in (strips, None):
        gas = gas_of(bag, parts)
        pressure = gas.fields(after(gas, bag, 1.2e-3))["gauge_pressure"] + gas.supply.ambient.pressure
        found.append([np.average(pressure[some], weights=strips.area[some]) / 1e5 - 1.0 for some in (end, mouth)])
    (far, near), (far_in_one, near_in_one) = found
    assert far < 1e-3 * near
    assert far_in_one > 0.2 * near_in_one


def test_strips_of_a_straight_tube_join_and_change_nothing():
    bag, strips = tube(folded=False)
    plain = gas_of(bag, None)
    parted = gas_of(bag, strips)
    state = parted.start(bag)
    assert len(parted.rooms(state).lived_in) == 4
    rooms = []
    for _ in still(parted, state, 1.5e-3):
        rooms.append(len(parted.rooms(state).lived_in))
    assert rooms[0] == 4
    assert rooms[-1] == 1
    assert (np.diff(rooms) <= 0).all()
    assert state.mass_error < 1e-12
    assert state.energy_error < 1e-11
    assert sum(len(sheet.key) > 0 for sheet in state.sheets) == 1
    other = after(plain, bag, 1.5e-3)
    assert parted.totals(state).energy == pytest.approx(plain.totals(other).energy, rel=1e-12)
    one, two = quarters(parted, state, strips), quarters(plain, other, strips)
    assert one == pytest.approx(two, rel=0.01)


def test_doors_between_strips_are_no_walls(monkeypatch):
    """A wave in a straight tube of strips that never join: with slopes that took openings for walls, 0.25 % off."""
    monkeypatch.setattr(mesh_gas, "LOOK_EVERY", 10**9)
    bag, strips = tube(folded=False)
    found = []
    for parts in (strips, None):
        gas = gas_of(bag, parts)
        state = after(gas, bag, 1e-3)
        found.append(gas.fields(state)["gauge_pressure"])
    gap, wave = (np.sqrt(np.average(values**2, weights=strips.area)) for values in (found[0] - found[1], found[1]))
    assert gap < 1e-3 * wave


def test_a_join_in_a_moving_bag_loses_nothing(monkeypatch):
    """Mass, momentum, energy, what is owed and the forces on the fabric are the same before and after; the bag flies,
    grows and shears through the lattice, gas blows into it, and no step before or after breaks the books."""
    bag, strips = tube(folded=False)
    gas, joins = gas_of(bag, strips), []
    join = mesh_gas.MeshGas._join

    def sums(state):
        rooms, force = gas.rooms(state), np.zeros((gas.surface.triangle_count, 3, 3))
        for walls, sheet in zip(rooms.walls, state.sheets, strict=True):
            force[walls.index[: walls.own]] += sheet.force[: walls.own]
        return sum(sheet.sums() for sheet in state.sheets), sum(sheet.owed.sum() for sheet in state.sheets), force

    def watched(self, state, first, second):
        before = sums(state)
        join(self, state, first, second)
        joins.append((before, sums(state)))

    monkeypatch.setattr(mesh_gas.MeshGas, "_join", watched)
    state, middle = gas.start(bag), bag.positions.mean(axis=0)
    shear = np.array([[1.0, 0.0, 0.0], [0.3, 1.0, 0.0], [0.0, 0.5, 30.0]])

    def at(time):
        share = time / 1e-3
        turned = (bag.positions - middle) @ (np.eye(3) + 0.05 * share * shear) + middle
        return turned + np.array([40.0, -15.0, 25.0]) * time

    for _ in moved(gas, state, at, 1e-3, 0.9):
        pass
    assert len(joins) == 3
    for (held, owed, force), (held_after, owed_after, force_after) in joins:
        np.testing.assert_allclose(held_after, held, rtol=1e-14, atol=1e-14 * np.abs(held).max())
        assert abs(owed) > 0.0
        assert owed_after == pytest.approx(owed, rel=1e-12)
        np.testing.assert_array_equal(force_after, force)
    assert state.mass_error < 1e-12
    assert state.energy_error < 1e-11


def leaning(bag, strips, by):
    """The bag, with the front end of the wall between its last two strips moved along it by some metres."""
    own = bag.surface.triangle_count
    last = (strips.chambers.behind[own:] == 2) & (strips.chambers.ahead[own:] == 3)
    nodes = np.unique(strips.triangles[own:][last])
    heights = bag.positions[nodes, 2]
    positions = bag.positions.copy()
    positions[nodes[heights > np.median(heights)], 0] += by
    return dataclasses.replace(bag, positions=positions)


@pytest.mark.parametrize(("by", "joins"), [(0.0, False), (0.45, True)])
def test_strips_join_where_fabric_went_through_their_wall(by, joins):
    """The wall leans beyond the end of the tube: much of the last strip is inside out, and nothing of the bag."""
    straight, strips = tube(folded=False)
    bag = leaning(straight, strips, by)
    gas = gas_of(bag, strips)
    state = gas.start(bag)
    cuts = gas.cut(state)
    assert (sum(cut.inverted for cut in cuts) < -0.1 * cuts[3].total) is joins
    assert abs(rooms.inside_out(cuts)) < 1e-9
    assert rooms._turned(cuts[3], cuts[2]) is joins
    assert gas.rooms(state).joining(cuts)[0] == ((2, 3) if joins else (0, 1))


def test_what_would_hold_no_gas_is_adopted_and_nothing_is_lost():
    """As cells that are inside out leave it when they join cells of thinner gas: room, and less than no gas."""
    bag, _ = tube(folded=False)
    gas = mesh_in(bag, CELL)
    state = gas.start(bag)
    held = state.sheets[0].held
    held[len(held) // 2] *= -30.0
    mass, energy = held[:, :-4].sum(), held[:, -1].sum()
    assert sum(1 for _ in still(gas, state, 1e-4)) > 1
    assert state.adopted > 0
    assert state.sheets[0].held[:, :-4].sum() == pytest.approx(mass, rel=1e-12)
    assert state.sheets[0].held[:, -1].sum() == pytest.approx(energy, rel=1e-12)


def test_a_bag_that_lies_in_itself_is_told_from_strips_that_do():
    folded, strips = tube()
    bag = leaning(folded, strips, -0.3)
    gas = gas_of(bag, strips)
    cuts = gas.cut(gas.start(bag))
    assert sum(cut.inverted for cut in cuts) < 2.0 * rooms.inside_out(cuts) < -1.0


def test_a_restart_among_joins_changes_no_bit():
    """Strips join at the 16th part of a step and at the 32nd; the run stops between."""
    bag, strips = tube(folded=False)
    gas = gas_of(bag, strips)
    state, saved = gas.start(bag), None
    for _ in still(gas, state, 1.2e-3):
        if saved is None and len(gas.rooms(state).lived_in) == 2:
            saved = [dict(part) for part in flatten(copy.deepcopy(state))]
    assert saved is not None
    assert len(gas.rooms(state).lived_in) == 1
    again = restore(gas.start(bag), *saved)
    assert again.time < state.time
    for _ in still(gas, again, 1.2e-3):
        pass
    for one, two in zip(flatten(state), flatten(again), strict=True):
        assert one.keys() == two.keys()
        for name in one:
            np.testing.assert_array_equal(one[name], two[name], err_msg=name)


def test_passages_and_heat_are_shared_out_among_strips():
    """A vent, porous fabric and cooling of the whole bag, without flow: each strip has its part, and all together pass
    what the bag without strips does."""
    bag, strips = tube()
    area = strips.area
    cloth = bag.surface.triangles_of_kind("fabric")
    vent = bag.surface.triangles_of_kind("mouth")
    rows = (
        Passage("vent", VENT, ORIFICE, 0, triangles=vent, area=area[vent].sum(), coefficient=1e-3),
        Passage("cloth", FABRIC, GRAEFE, 0, triangles=cloth, area=area[cloth].sum(), coefficient=1e-4),
    )
    totals = []
    for parts in (strips, None):
        gas = mesh_in(bag, CELL, pressure=2e5, temperature=500.0, outside=1e5, passages=rows,
                      heat_conductance=np.array([2.0]))  # fmt: skip
        gas = dataclasses.replace(gas, strips=parts)
        state = after(gas, bag, 1e-4)
        if parts is not None:
            fed = gas.rooms(state).ways.supply
            assert sum(row.area for row in fed.passages.rows if row.name == "cloth") == pytest.approx(rows[1].area)
            assert fed.heat_conductance.sum() == pytest.approx(2.0)
        totals.append(gas.totals(state))
    one, two = totals
    assert one.leaked_by["cloth"] == pytest.approx(two.leaked_by["cloth"], rel=2e-3)
    assert one.vented_by["vent"] == pytest.approx(two.vented_by["vent"], rel=2e-2)
    assert one.heat_lost == pytest.approx(two.heat_lost, rel=2e-3)


def test_frames_show_the_mean_of_strips_that_share_a_cell():
    bag, strips = tube()
    gas = gas_of(bag, strips)
    state = after(gas, bag, 5e-4)
    cells, now = gas.cells(state), gas.totals(state)
    assert len(np.unique(cells["centre"], axis=0)) == len(cells["centre"])
    room = cells["volume_fraction"] * CELL**3
    assert room.sum() == pytest.approx(now.volume, rel=1e-4)
    assert (room * cells["density"]).sum() == pytest.approx(now.mass, rel=1e-4)
    assert (room * cells["pressure"]).sum() == pytest.approx(now.pressure * now.volume, rel=1e-4)
