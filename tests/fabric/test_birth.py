"""Birth ramp: a stretched start is released slowly; the work of the moving reference closes the energy balance."""

from __future__ import annotations

import copy
import dataclasses

import numpy as np
import pytest

from billow.apps.verification.scenes import Observer, disc, fabric_model, isotropic
from billow.parts.fabric.birth import Birth, strain_energy
from billow.solver.run import Schedule, run

STRETCH = np.array([[1.3, 0.1, 0.0], [0.1, 1.1, 0.0], [0.0, 0.0, 1.0]])


def stretched(time=1e-3, damping=0.0, stretch=STRETCH):
    """A disc that starts stretched against its flat cut, its rim free."""
    shape = disc(0.2, 0.03)
    shape = dataclasses.replace(shape, fixed=np.zeros_like(shape.fixed), positions=shape.positions @ stretch)
    model = fabric_model(shape, isotropic(4e8, 0.2, 800.0, 3e-4, damping=damping))
    birth = Birth.of(time, model.fabric.membranes, shape.surface.triangles, model.start)
    return dataclasses.replace(model, fabric=dataclasses.replace(model.fabric, birth=birth))


def energy(model, fraction, positions):
    history = [m.fresh_history() for m in model.fabric.membranes]
    membranes = model.fabric.birth.membranes(model.fabric.membranes, fraction)
    return strain_energy(membranes, model.surface.triangles, positions, history)


def test_nothing_is_strained_at_first_and_everything_at_last():
    model = stretched()
    whole = energy(model, 1.0, model.start)
    assert whole > 10.0
    assert energy(model, 0.0, model.start) < 1e-20 * whole
    # Uniform stretch: V/2 E : C : E of the Green strain, plane stress.
    strain = 0.5 * (STRETCH @ STRETCH - np.eye(3))[:2, :2]
    density = 4e8 / (1.0 - 0.2**2) / 2.0 * (0.8 * np.sum(strain**2) + 0.2 * np.trace(strain) ** 2)
    assert whole == pytest.approx(model.fabric.membranes[0].volume.sum() * density, rel=1e-12)
    assert model.fabric.birth.membranes(model.fabric.membranes, 1.0) == model.fabric.membranes


def test_a_compressed_start_keeps_its_flat_cut():
    model = stretched(stretch=np.diag([0.9, 0.7, 1.0]))
    np.testing.assert_allclose(model.fabric.birth.stretch[0], 0.0, atol=1e-15)


def test_turned_and_folded_starts_are_not_strained():
    """A rotation is no stretch."""
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    model = stretched(stretch=turn)
    np.testing.assert_allclose(model.fabric.birth.stretch[0], 0.0, atol=1e-12)


def test_the_slope_is_that_of_the_energy():
    model = stretched()
    for s in (0.2, 0.4, 0.9):
        slope = model.fabric.birth.energy_slope(
            model.fabric.birth.membranes(model.fabric.membranes, s),
            s,
            model.surface.triangles,
            model.start,
            [m.fresh_history() for m in model.fabric.membranes],
        )
        step = 1e-3
        exact = (energy(model, s + step, model.start) - energy(model, s - step, model.start)) / (2.0 * step)
        assert slope == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("damping", [0.0, 0.05])
def test_the_energy_balance_closes_while_the_reference_moves(damping):
    """The residual is that of the time stepping, of second order: a quarter of the step, a sixteenth of the error."""
    errors = []
    for scale in (1.0, 0.25):
        model = stretched(damping=damping)
        state = run(model, Schedule(2e-3, 1, 20, scale))
        assert state.ledger["birth_work"] > 0.0
        errors.append(max(state.ledger.largest_gain, -state.ledger.largest_loss) / state.ledger.largest_energy)
    assert errors[0] < 3e-3
    assert errors[1] < 0.25 * errors[0]


def test_a_ramp_releases_more_gently_than_a_jump():
    """Over many periods of the disc's own vibration the fabric follows its reference: little energy is left."""
    fast, slow = (run(stretched(time, damping=0.05), Schedule(8e-3, 1, 10)).ledger for time in (1e-5, 6e-3))
    assert slow["birth_work"] < 0.2 * fast["birth_work"]


def test_a_run_resumed_within_the_ramp_gives_the_same_bits():
    model, schedule, kept = stretched(), Schedule(1.5e-3, 1, 6), []

    def keep(state):
        kept.append(copy.deepcopy(state))

    whole = run(model, schedule, Observer(keep))
    assert 0.0 < model.fabric.birth.fraction(kept[2].time) < 1.0
    resumed = run(model, schedule, state=kept[2])
    assert resumed.positions.tobytes() == whole.positions.tobytes()
    assert resumed.ledger == whole.ledger
