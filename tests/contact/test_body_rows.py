"""Bodies and layers that push on the same nodes: solved together, nothing is pressed through and the books close."""

import dataclasses

import numpy as np
import pytest
from thrown_sheets import model_of, sheet

from billow.case.build import keep_apart
from billow.geometry.crossings import CrossingCount
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid
from billow.parts.bodies.bodies import Bodies
from billow.parts.bodies.body import Body
from billow.parts.bodies.contact import Nodes, SurfaceLaw
from billow.parts.bodies.rigid_body import RigidBody, RigidState
from billow.solver.checkpoint import flatten
from billow.solver.model import start_state
from billow.solver.step import advance, first_forces
from billow.solver.step_size import stable_dt

X, Y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])


def plate(slope=1e5, friction=0.0):
    law, rest = SurfaceLaw(slope, friction, 0.0), RigidState(np.zeros(3))
    return Body.of("plate", HalfSpace(), law, RigidBody(1.0, np.ones(3), locked=True), rest)


def ball(height, speed, mass=2.0, radius=0.06):
    rigid = RigidBody(mass, np.full(3, 0.4 * mass * radius**2), locked=False)
    state = RigidState(np.array([0.04, 0.04, height + radius]), velocity=np.array([0.0, 0.0, -speed]))
    return Body.of("ball", SuperEllipsoid(np.full(3, radius), 2.0), SurfaceLaw(1e5, 0.2, 0.0), rigid, state)


def stack(*bodies, layers=10, gravity=0.0, damping=0.0, friction=0.0):
    """Sheets 0.5 mm apart above the plane z = 0, each shifted a little: model, sheet of each node, state."""
    shifts = np.random.default_rng(1).uniform(-3e-3, 3e-3, (layers, 2))
    sheets = [sheet((*shift, 5e-4 * (k + 1)), X, Y, edge=0.01) for k, shift in enumerate(shifts)]
    model, of_sheet = model_of(sheets, bodies=bodies, gravity=(0.0, 0.0, -gravity))
    model = dataclasses.replace(model, mass_damping=damping)
    model = dataclasses.replace(model, layers=keep_apart(model, friction))
    state = start_state(model)
    first_forces(model, state)
    return model, of_sheet, state


@pytest.mark.parametrize("slope", [1e5, 1e6])
def test_a_stack_pressed_onto_a_plate(slope):
    """20 kPa by weight: the plate carries it, the layers keep their order, and the books close."""
    model, of_sheet, state = stack(plate(slope), gravity=8333.0, damping=1500.0)
    count, carried = CrossingCount(model.surface), []
    while state.time < 8e-3:
        advance(model, state, 0.75 * stable_dt(model, state))
        carried.append(state.bodies.contact.force[0, :, 2].sum())
    weight = 8333.0 * model.mass.sum()
    assert np.mean(carried[-len(carried) // 4 :]) == pytest.approx(weight, rel=0.01)
    assert count.total(state.positions) == 0
    heights = [state.positions[of_sheet == k, 2].mean() for k in range(10)]
    assert min(np.diff(heights)) > 1e-4
    assert state.ledger.relative_error < 0.01
    assert abs(state.ledger["friction"]) < 1e-12  # its springs are solved for the motion that comes


def test_a_ball_on_a_stack_on_a_plate():
    """Ten layers between a free body and a locked one, at 10 m/s: no crossing, momentum and energy accounted for."""
    model, _, state = stack(plate(), ball(5.5e-3, 10.0))
    count, before = CrossingCount(model.surface), state.ledger.side("motion")
    ball_moves, received, given = state.bodies.motion[1], np.zeros(3), 0.0
    while state.time < 3e-3:
        dt = 0.75 * stable_dt(model, state)
        advance(model, state, dt)
        pushes = dt * state.bodies.contact.force.sum(axis=1)
        received, given = received + pushes.sum(axis=0), given + np.abs(pushes).sum()
        if state.step % 20 == 0:
            assert count.total(state.positions) == 0
    assert ball_moves.velocity[2] > 5.0  # thrown back
    assert given > 10.0
    assert np.abs(model.mass @ state.velocities - received).max() < 1e-11 * given
    assert abs(state.ledger.residual) < 1e-3 * before


def test_without_layers_rows_are_the_contact_of_nodes():
    """Solved in rows and in one pass, a node gets the same push, and the springs the same energy."""
    random = np.random.default_rng(3)
    n = 300
    bodies = Bodies((plate(friction=0.3), ball(-0.02, 3.0)), random.uniform(1e-5, 1e-4, n), np.zeros(3))
    arrays = {
        "inverse_mass": random.uniform(2e4, 8e4, n), "force": random.normal(size=(n, 3)),
        "positions": random.uniform(-0.03, 0.1, (n, 3)) * [1.0, 1.0, 0.2],
        "velocities": random.normal(0.0, 10.0, (n, 3)),
        "before": np.empty((n, 3)),
    }  # fmt: skip
    together, apart = (Nodes(**{name: array.copy() for name, array in arrays.items()}) for _ in range(2))
    one, other = bodies.start(), bodies.start()
    for dt in (4e-6, 5e-6, 3e-6):
        booked = bodies.kick_touch_drift(one, together, dt)
        rows = bodies.rows(other, apart, dt)
        assert rows.settle() == 0.0
        again = bodies.drift(other, rows)
        assert np.abs(together.positions - apart.positions).max() < 1e-15
        assert np.allclose(together.velocities, apart.velocities, rtol=1e-12, atol=1e-12)
        for (account, energy), (same, found) in zip(booked, again, strict=True):
            assert account == same
            assert found == pytest.approx(energy, rel=1e-9, abs=1e-13)
    assert one.contact.touching.sum() > 50
    expected, found = (flatten(state)[0] for state in (one, other))
    assert all(np.allclose(expected[name], found[name], rtol=1e-9, atol=1e-12) for name in expected)


@pytest.mark.parametrize(("pull", "slides"), [(0.5, False), (0.9, False), (1.5, True)])
def test_friction_between_layers(pull, slides):
    """A sheet at 20 kPa, come to rest, then pulled sideways with a share of mu N: it sticks below 1, and slides by
    Coulomb's law above."""
    friction, gravity = 0.25, 8333.0
    lower = sheet((-0.02, -0.02, 0.0), X, Y, cells=(12, 12), edge=0.01)
    upper = sheet((0.0033, 0.0041, 3e-4), X, Y, edge=0.01)
    model, of_sheet = model_of([lower, upper], fixed=(0,), gravity=(0.0, 0.0, -gravity))
    model = dataclasses.replace(model, layers=keep_apart(model, friction))
    still = dataclasses.replace(model, mass_damping=3000.0)
    pulled = dataclasses.replace(model, gravity=np.array([pull * friction * gravity, 0.0, -gravity]))
    state, way = start_state(model), []
    first_forces(still, state)
    while state.time < 1.5e-3:
        advance(still, state, 0.75 * stable_dt(still, state))
    while state.time < 4.5e-3:
        advance(pulled, state, 0.75 * stable_dt(pulled, state))
        way.append((state.time, state.positions[of_sheet == 1, 0].mean(), state.velocities[of_sheet == 1, 0].mean()))
    time, place, speed = np.array(way).T
    late = np.searchsorted(time, 3e-3)
    acceleration = (speed[-1] - speed[late]) / (time[-1] - time[late])
    if slides:
        assert acceleration == pytest.approx((pull - 1.0) * friction * gravity, rel=0.03)
    else:
        assert place[-1] - place[late] < 2e-5
        assert abs(acceleration) < 0.01 * friction * gravity
    assert state.ledger["friction"] > 0.0
    assert state.ledger.relative_error < 5e-3
    assert CrossingCount(model.surface).total(state.positions) == 0
