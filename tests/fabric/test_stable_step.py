"""The largest step that `stable_dt` allows is stable, without damping too: nothing that vibrates gains energy by it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from billow.apps.coupon.specimen import sheet
from billow.apps.verification.scenes import disc, fabric_model, isotropic
from billow.geometry.bag_shapes import BagShape
from billow.geometry.surface import Surface
from billow.parts.part import GRAVITY_WORK, Booking
from billow.parts.straps import Straps
from billow.solver.model import Model, State, start_state
from billow.solver.run import Schedule, begin, run
from billow.solver.step import advance
from billow.solver.step_size import stable_dt

YOUNG, POISSON, DENSITY, THICKNESS = 4e8, 0.3, 800.0, 3e-4


def triangle(stretch: float) -> tuple[Model, np.ndarray]:
    """A free equilateral triangle that is stretched, compression included, and its highest mode [m], (3, 3).

    Of all lumped-mass triangles the equilateral one has the smallest bound, 0.827 h/c at this Poisson's ratio.
    """
    flat = 0.01 * np.array([[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(0.75)]])
    surface = Surface.build(np.array([[0, 1, 2]]), np.zeros(1), ("fabric",), 3)
    positions = np.column_stack([stretch * flat, np.zeros(3)])
    shape = BagShape(surface, positions, flat[None], np.zeros(3, bool))
    model = fabric_model(shape, isotropic(YOUNG, POISSON, DENSITY, THICKNESS, compression=True))
    tangent, step = np.zeros((9, 9)), 1e-8
    for k in range(9):
        for sign in (1.0, -1.0):
            state = begin_at(model, positions + sign * step * np.eye(9)[k].reshape(3, 3))
            tangent[:, k] -= sign * state.nodal_force.ravel() / (2.0 * step)
    return model, np.linalg.eigh(tangent)[1][:, -1].reshape(3, 3)


def begin_at(model: Model, positions: np.ndarray) -> State:
    return begin(dataclasses.replace(model, start=positions), Schedule(1.0, 1, 1))


def energies(model: Model, state: State, steps: int) -> np.ndarray:
    """Kinetic and stored energy [J] after each of some steps of the largest size allowed at the start, (steps, 2)."""
    rows, dt = [], stable_dt(model, state)
    for _ in range(steps):
        advance(model, state, dt)
        rows.append((state.ledger["kinetic"], state.ledger.side("stored")))
    return np.array(rows)


def test_the_highest_mode_of_a_triangle_stays_bounded():
    """Central differences are stable up to 2/omega; starting at rest, the energy never exceeds that of the start."""
    model, mode = triangle(1.0)
    state = begin_at(model, model.start + 1e-6 * mode)
    start = state.ledger.side("stored")
    assert energies(model, state, 2000).sum(axis=1).max() <= 1.01 * start


@pytest.mark.parametrize("stretch", [1.1, 1.3])
def test_the_highest_mode_of_a_stretched_triangle_stays_bounded(stretch):
    """About the stretched state, which is no equilibrium: it is held by the forces of the start."""
    model, mode = triangle(stretch)
    hold = begin_at(model, model.start).nodal_force.copy()
    state = begin_at(model, model.start + 1e-6 * mode)
    away, dt = [], stable_dt(model, state)
    kick = -0.5 * dt * model.inverse_mass[:, None] * hold
    for _ in range(2000):
        state.velocities += kick
        advance(model, state, dt)
        state.velocities += kick
        away.append(np.linalg.norm(state.positions - model.start))
    assert max(away) <= 1.05e-6


def test_a_strap_stiffer_than_the_fabric_sets_the_step():
    """A strap of two bars, tied to the fixed rim of a disc and to its centre: the centre vibrates between them with
    omega^2 = 2 EA/(L m), taut all the time. Starting from the middle, it is never faster than at the start."""
    shape = disc(0.2, 0.05)
    model = fabric_model(shape, isotropic(YOUNG, POISSON, DENSITY, THICKNESS, compression=True))
    centre = int(np.argmin(np.linalg.norm(shape.positions, axis=1)))
    rim = np.flatnonzero(shape.fixed)
    ends = [rim[0], rim[np.argmin(shape.positions[rim] @ shape.positions[rim[0]])]]
    along = shape.positions[ends] - shape.positions[centre]
    length = np.linalg.norm(along, axis=1)
    straps = Straps(
        bars=np.array([[centre, end] for end in ends]),
        length=0.99 * length,
        stiffness=np.full(2, 1e7),
        viscosity=np.zeros(2),
        mass=np.zeros(2),
        strap=np.zeros(2, np.int64),
        failure=np.full(2, np.inf),
    )
    slack, model = model, dataclasses.replace(model, straps=straps)
    state = begin(model, Schedule(1.0, 1, 1))
    frequency = np.sqrt(np.sum(straps.stiffness / straps.length) * model.inverse_mass[centre])
    assert stable_dt(model, state) < 2.0 / frequency < 0.5 * stable_dt(slack, start_state(slack))
    state.velocities[centre] = 0.1 * along[0] / length[0]
    start = 0.5 * model.mass[centre] * 0.1**2
    assert energies(model, state, 2000)[:, 0].max() <= 1.05 * start


@pytest.mark.parametrize("seed", [0, 2])
def test_undamped_fabric_that_goes_slack_gains_no_energy(seed):
    """A strip held at one end whose nodes fly apart at random. Where it goes slack, stress has a kink, and each kink
    that a step passes changes the energy by a little. With the step of damped fabric there are 1.7 times the energy
    after 9,000 steps; docs/theory.md, Membrane step, says what was measured."""
    flat = sheet(0.05, 0.01, 0.005)
    positions = np.column_stack([flat.flat, np.zeros(len(flat.flat))])
    fixed = flat.flat[:, 0] < -0.025 * (1.0 - 1e-9)
    shape = BagShape(flat.surface, positions, flat.flat[flat.surface.triangles], fixed)
    model = fabric_model(shape, isotropic(YOUNG, POISSON, DENSITY, THICKNESS))
    schedule = Schedule(0.03, 1, 60)
    state = begin(model, schedule)
    state.velocities[~fixed] = 10.0 * np.random.default_rng(seed).normal(size=(np.count_nonzero(~fixed), 3))
    start = 0.5 * float(model.mass @ np.sum(state.velocities**2, axis=1))
    state.ledger.book([Booking(GRAVITY_WORK, start)])  # the energy of the start, as if gravity had given it
    ledger = run(model, schedule, state=state).ledger
    assert ledger["kinetic"] + ledger["strain"] == pytest.approx(start, rel=0.05)
