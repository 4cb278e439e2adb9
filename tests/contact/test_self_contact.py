"""Fabric against fabric: what a spring between a node and a triangle must keep, and that layers do not cross."""

import copy
import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_loads import on_nodes

from billow.base import compiled
from billow.geometry.near_pairs import near_pairs
from billow.geometry.surface import Surface, nodal_share
from billow.parts.bodies.bodies import Bodies
from billow.parts.fabric.fabric import Fabric
from billow.parts.fabric.linear_law import LinearFabric
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.no_gas import NoGas
from billow.parts.part import Loads
from billow.parts.self_contact import SelfContact, find_rest
from billow.parts.straps import NO_STRAPS
from billow.solver.checkpoint import flatten
from billow.solver.model import Model, start_state
from billow.solver.step import advance, first_forces

EDGE, NODES = 0.004, 14  # of a square sheet, along its side
SHEET = NODES * NODES
FABRIC = LinearFabric(800.0, 3e-4, 0.4e9, 0.35e9, 0.2, 1e7, False, 0.05)


def sheet(height, shift, upwards):
    x, y = np.meshgrid(EDGE * np.arange(NODES), EDGE * np.arange(NODES), indexing="ij")
    positions = np.column_stack([x.ravel() + shift, y.ravel() + 0.7 * shift, np.full(SHEET, height)])
    i, j = (k.ravel() for k in np.meshgrid(np.arange(NODES - 1), np.arange(NODES - 1), indexing="ij"))
    a, b, c, d = i * NODES + j, (i + 1) * NODES + j, (i + 1) * NODES + j + 1, i * NODES + j + 1
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return positions, triangles if upwards else triangles[:, ::-1]


def two_sheets(apart, faced=True, kinds=("fabric", "fabric")):
    """A model of two sheets: the lower at rest, the upper `apart` [m] above it. faced: outer sides outwards."""
    lower, below = sheet(0.0, 0.0, upwards=not faced)
    upper, above = sheet(apart, 0.0013, upwards=True)
    positions, triangles = np.vstack([lower, upper]), np.vstack([below, above + SHEET])
    part = np.repeat([0, 1], len(below))
    surface = Surface.build(triangles, part, ("lower", "upper"), len(positions), kinds)
    membrane = Membrane.build(FABRIC, np.arange(len(triangles)), positions[triangles][:, :, :2].copy())
    mass = nodal_share(triangles, membrane.mass, len(positions))
    gravity = np.zeros(3)
    return Model(
        surface=surface, start=positions, mass=mass, fixed=np.zeros(len(mass), bool), gravity=gravity,
        gas=GasPart(NoGas(), surface, positions), fabric=Fabric(surface, (membrane,)), straps=NO_STRAPS,
        bodies=Bodies((), np.zeros(len(mass)), gravity),
        self_contact=SelfContact.build(surface, positions, mass, membrane.crossing_time),
    )  # fmt: skip


def thrown(model, speed, roughness=0.1):
    """The state in which the upper sheet comes down at `speed` [m/s], unevenly."""
    state = start_state(model)
    state.velocities[SHEET:, 2] = -speed
    state.velocities[:, 2] += np.random.default_rng(0).normal(0.0, roughness * speed, 2 * SHEET)
    first_forces(model, state)
    return state


def run(model, state, steps):
    for _ in range(steps):
        advance(model, state, 0.75 * model.fabric.membranes[0].crossing_time)


def forces(model, pairs, positions):
    loads = Loads(0, model.surface)
    bookings = model.self_contact.add_forces(pairs, positions, np.zeros_like(positions), 0.0, loads)
    stored = sum(energy for account, energy in bookings if account.name == "self_contact")
    return stored, on_nodes(loads, model.surface, positions)


@pytest.fixture(scope="module")
def pressed():
    """Two rough sheets within each other's gap, the pairs between them, and a model of both."""
    model = two_sheets(0.004)
    pairs, positions = model.self_contact.start(None), model.start.copy()
    gap = model.self_contact.gap
    positions[SHEET:, 2] = 1.2 * gap
    forces(model, pairs, positions)
    positions[SHEET:, 2] = 0.6 * gap
    positions += np.random.default_rng(1).normal(0.0, 0.02 * gap, positions.shape)
    return model, pairs, positions


def test_force_is_the_gradient_of_the_energy(pressed):
    model, pairs, positions = pressed
    stored, nodal = forces(model, copy.deepcopy(pairs), positions)
    direction = np.random.default_rng(2).normal(size=positions.shape)
    step = 1e-9  # second order: error about (step/gap)^2 of the force, and rounding of the energy over step
    up, down = (forces(model, copy.deepcopy(pairs), positions + s * direction)[0] for s in (step, -step))
    assert stored > 0.0
    assert (up - down) / (2.0 * step) == pytest.approx(-float(np.sum(nodal * direction)), rel=1e-5)


def test_momentum_and_angular_momentum_are_kept(pressed):
    model, pairs, positions = pressed
    _, nodal = forces(model, copy.deepcopy(pairs), positions)
    pushed = np.abs(nodal).sum()
    assert pushed > 0.0
    assert np.abs(nodal.sum(axis=0)).max() < 1e-14 * pushed
    assert np.abs(np.cross(positions, nodal).sum(axis=0)).max() < 1e-14 * pushed * np.abs(positions).max()


def test_layers_at_rest_within_the_gap_are_not_pushed():
    """A folded bag starts with its layers closer than the gap; no energy may come from that."""
    model = two_sheets(1e-4)
    stored, nodal = forces(model, model.self_contact.start(None), model.start)
    assert stored == 0.0
    assert not nodal.any()


@pytest.mark.parametrize("apart", [1e-4, 0.004])
@pytest.mark.parametrize("faced", [True, False])
def test_layers_do_not_cross(faced, apart):
    """At a quarter of the speed a pair can stop, 0.6 gaps a step; outer sides and inner sides alike.

    Only layers that face each other are paired, so both sheets face, with inner or with outer sides.
    """
    model = two_sheets(apart)
    if not faced:  # turn both over: what faces is the outer side
        turned = Surface.build(
            model.surface.triangles[:, ::-1], model.surface.part, model.surface.part_names, 2 * SHEET,
            model.surface.part_kinds,
        )  # fmt: skip
        contact = SelfContact.build(turned, model.start, model.mass, model.fabric.membranes[0].crossing_time)
        fabric = dataclasses.replace(model.fabric, surface=turned)
        model = dataclasses.replace(model, surface=turned, fabric=fabric, self_contact=contact)
    dt = 0.75 * model.fabric.membranes[0].crossing_time
    state = thrown(model, 0.15 * model.self_contact.gap / dt, roughness=0.05)
    inner = np.abs(model.start[:SHEET, :2] - model.start[:SHEET, :2].mean(axis=0)).max(axis=1) < 0.3 * EDGE * NODES
    run(model, state, 80)
    assert clearance(state)[inner].min() > 0.0
    assert state.velocities[SHEET:, 2].mean() > state.velocities[:SHEET, 2].mean()  # they part


def clearance(state):
    """How far each node of the upper sheet is above the three nodes of the lower one that are nearest in the plane."""
    lower, upper = state.positions[:SHEET], state.positions[SHEET:]
    apart = np.linalg.norm(upper[:, None, :2] - lower[None, :, :2], axis=2)
    return upper[:, 2] - lower[np.argsort(apart, axis=1)[:, :3], 2].mean(axis=1)


def test_without_contact_they_cross():
    model = two_sheets(0.004)
    model = dataclasses.replace(model, self_contact=None)
    dt = 0.75 * model.fabric.membranes[0].crossing_time
    state = thrown(model, 0.15 * 0.25 * EDGE / dt)
    run(model, state, 80)
    assert state.positions[SHEET:, 2].mean() < state.positions[:SHEET, 2].mean()
    assert clearance(state).max() < 0.0


def test_energy_is_booked():
    """Slow enough that a spring is sampled often, the books close to 1 % of what came in, the order of (w dt)^2/24."""
    model = two_sheets(0.0015)
    state = thrown(model, 10.0)
    before = state.ledger["kinetic"]
    run(model, state, 300)
    assert state.ledger["friction"] > 1e-3 * before
    assert abs(state.ledger.residual) < 0.01 * before


def test_damping_takes_what_is_booked():
    """Nodes move by the mean of the forces at both ends of a step. Power at the end of each step times the step would
    book a fifth too much. No node changes its triangle here."""
    model = two_sheets(0.0015)
    state = thrown(model, 10.0, roughness=0.02)
    dt = 0.5 * model.fabric.membranes[0].crossing_time
    booked, taken, before, places = [], [], np.zeros_like(model.start), state.positions.copy()
    while len(booked) < 200:
        last = state.ledger["friction"]
        half = state.velocities + 0.5 * dt * state.nodal_force * model.inverse_mass[:, None]
        advance(model, state, dt)
        damping = np.zeros_like(model.start)
        for velocities, sign in ((half, 1.0), (np.zeros_like(half), -1.0)):
            pairs, loads = copy.deepcopy(state.self_contact), Loads(0, model.surface)
            model.self_contact.add_forces(pairs, state.positions, velocities, dt, loads)
            damping += sign * on_nodes(loads, model.surface, state.positions)
        booked.append(state.ledger["friction"] - last)
        taken.append(-0.5 * float(np.sum((before + damping) * (state.positions - places))))
        before, places = damping, state.positions.copy()
    assert sum(booked) > 1e-3 * state.ledger["kinetic"]
    np.testing.assert_allclose(booked, taken, rtol=0, atol=1e-12 * sum(taken))


def test_momentum_of_a_collision():
    model = two_sheets(0.0015)
    state = thrown(model, 30.0)
    before = model.mass @ state.velocities
    run(model, state, 100)
    assert np.abs(model.mass @ state.velocities - before).max() < 1e-13 * np.abs(before).max()
    assert state.ledger["friction"] > 0.0


def test_holes_are_not_touched():
    model = two_sheets(0.0015, kinds=("vent", "fabric"))
    state = thrown(model, 30.0)
    run(model, state, 100)
    assert state.ledger["friction"] == 0.0
    assert len(state.self_contact.triangle) == 0


def test_same_bits_for_any_threads_and_from_a_copy(threads, monkeypatch):
    monkeypatch.setattr(compiled, "PARALLEL_FROM", 0)
    model = two_sheets(0.0015)
    states = []
    for count in (1, 2):
        threads(count)
        states.append(thrown(model, 30.0))
        run(model, states[-1], 60)
    half = thrown(model, 30.0)
    run(model, half, 30)
    states.append(copy.deepcopy(half))
    run(model, states[-1], 30)
    first, *others = (flatten(state)[0] for state in states)
    for other in others:
        assert all(np.array_equal(first[name], other[name]) for name in first)


@pytest.mark.parametrize("place", [np.nan, np.inf, 1e200])
def test_a_bag_that_has_left_is_left_to_the_guards(place):
    """No search over half the universe: the energy is not a number, and the guards say what is wrong."""
    model = two_sheets(0.004)
    positions = model.start.copy()
    positions[5] = place
    stored, nodal = forces(model, model.self_contact.start(None), positions)
    assert np.isnan(stored)
    assert not nodal.any()


def test_what_is_left_alone_would_not_have_mattered(monkeypatch):
    """The same bits when every pair is looked at in every step, in a collision that leaves most of them alone."""
    search, left_alone = SelfContact.search, []

    def search_and_look(self, pairs, positions):
        search(self, pairs, positions)
        left_alone.extend(pairs.rest > 0.0)
        pairs.rest[...] = pairs.first_rest[...] = -np.inf

    ends = []
    for look_at_all in (False, True):
        if look_at_all:
            monkeypatch.setattr(SelfContact, "search", search_and_look)
        model = two_sheets(0.004)
        state = thrown(model, 40.0)
        run(model, state, 150)
        assert state.ledger["friction"] > 0.0
        ends.append(state)
    assert np.mean(left_alone) > 0.5
    assert np.array_equal(ends[0].positions, ends[1].positions)
    assert ends[0].ledger["friction"] == ends[1].ledger["friction"]


@given(
    seed=st.integers(0, 10**6), thin=st.floats(0.05, 1.0), share=st.floats(0.0, 1.0), awake=st.sampled_from([0.05, 0.3])
)
def test_a_pair_at_rest_cannot_touch(seed, thin, share, awake):
    """Whatever a node and the corners of its triangle do within the motion that a pair is left alone for, the node does
    not get over the triangle, no higher than it is looked at."""
    random = np.random.default_rng(seed)
    corners = random.normal(size=(3, 3)) * [1.0, thin, thin]
    scene = np.vstack([corners, corners.mean(axis=0) + random.normal(size=3)])
    triangles, both = np.array([[0, 1, 2]]), np.array([0])
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    found = near_pairs(scene, np.array([3]), triangles, both, 50.0, np.tile(-normal, (4, 1)), both[:0], both[:0])
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    rest, first = np.empty(1), np.empty(4)
    find_rest(
        awake, found.start, found.triangle, found.apart, np.array([np.linalg.norm(normal) / sides.max()]), rest, first
    )
    assert first[3] == rest[0]
    for _ in range(50):
        by = random.normal(size=(4, 3))
        by *= max(0.0, rest[0]) * np.array([1.0 - share] * 3 + [share])[:, None] / np.linalg.norm(by, axis=1)[:, None]
        a, b, c, p = scene + by
        weights, *_ = np.linalg.lstsq(np.column_stack([b - a, c - a]), p - a, rcond=None)
        if min(*weights, 1.0 - weights.sum()) >= 0.0 and rest[0] > 0.0:
            unit = np.cross(b - a, c - a)
            assert abs((p - a) @ unit) >= awake * np.linalg.norm(unit) * (1.0 - 1e-9)
