"""A free bag hit by a free body: momentum stays what it was, energy is where the ledger says."""

from __future__ import annotations

import numpy as np
import pytest
from free_scene import free_model

from billow.solver.run import Schedule, run

END = 0.004


def momentum(model, state):
    """Linear [N s] and angular about the origin [N m s], fabric and body together."""
    fabric, body = model.mass[:, None] * state.velocities, state.bodies.motion[0]
    mass = model.bodies.bodies[0].rigid.mass
    linear = fabric.sum(axis=0) + mass * body.velocity
    angular = np.cross(state.positions, fabric).sum(axis=0)
    angular = angular + mass * np.cross(body.centre, body.velocity) + body.angular_momentum
    return linear, angular


def start_momentum(model):
    start, mass = model.bodies.bodies[0].start, model.bodies.bodies[0].rigid.mass
    return mass * start.velocity, mass * np.cross(start.centre, start.velocity) + start.angular_momentum


def collide(model, dt_scale=1.0, end=END):
    return run(model, Schedule(end, frames=2, histories_per_frame=1, dt_scale=dt_scale))


def test_linear_momentum_is_exact():
    model = free_model()
    state = collide(model)
    linear, _ = momentum(model, state)
    before, _ = start_momentum(model)
    change = state.bodies.motion[0].velocity - model.bodies.bodies[0].start.velocity
    assert np.linalg.norm(change) > 3.0  # they did collide
    assert np.abs(linear - before).max() <= 1e-12 * np.abs(before).max()


def test_angular_momentum_is_kept_to_the_schemes_order():
    model = free_model()
    _, before = start_momentum(model)
    gaps = [np.linalg.norm(momentum(model, collide(model, scale))[1] - before) for scale in (1.0, 0.5, 0.25)]
    assert gaps[0] < 1e-3 * np.linalg.norm(before)
    assert gaps[2] < 0.4 * gaps[0]


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_the_energy_residual_shrinks_with_the_step(damping):
    """Undamped and frictionless as well as with both; what is dissipated is booked."""
    model = free_model(damping=damping, friction=3.0 * damping)
    errors = []
    for scale in (0.8, 0.4, 0.2):
        ledger = collide(model, scale).ledger
        errors.append(ledger.relative_error)
        assert (ledger["damping"] > 0.0) == (damping > 0.0)
        assert ledger["friction"] >= -1e-9 * ledger.largest_energy
        if damping == 0.0:
            assert abs(ledger["friction"]) <= 1e-9 * ledger.largest_energy
    assert errors[0] < 0.02
    assert errors[2] < errors[0] / 6.0  # second order would be 16


def test_free_fall_is_exact():
    """Apart from each other, both fall: position, velocity and work of gravity are the closed forms."""
    model = free_model(gravity=(1.0, -2.0, -9.81), apart=10.0)
    gravity, end = model.gravity, 0.02
    state = collide(model, end=end)
    start, body = model.bodies.bodies[0].start, state.bodies.motion[0]
    total = model.mass.sum()
    # The bag's middle: strain of the start shape lets its nodes move, but not its middle.
    middle = model.mass @ (state.positions - model.start) / total
    assert middle == pytest.approx(0.5 * gravity * end**2, rel=1e-9)
    assert body.velocity == pytest.approx(start.velocity + gravity * end, rel=1e-12)
    assert body.centre == pytest.approx(start.centre + start.velocity * end + 0.5 * gravity * end**2, rel=1e-12)
    fallen = total * middle + model.bodies.bodies[0].rigid.mass * (body.centre - start.centre)
    assert state.ledger["gravity_work"] == pytest.approx(gravity @ fallen, rel=1e-9)


def test_a_whole_deployment_balances(small_run):
    """Everything at once: gas, jets, straps, plate, free impactor."""
    ledger = small_run.ledger
    assert ledger["gas_mass_error"] <= 1e-12
    assert ledger["gas_energy_error"] <= 1e-12
    assert abs(ledger["energy_residual_of_injected"]) < 1e-3
    assert abs(ledger["energy_residual_of_largest"]) < 0.01
    curves = small_run.histories
    assert curves["body_kinetic [J]"][-1] > 1.0  # the impactor was hit
    for name in ("damping [J]", "friction [J]", "injected [kg]", "vented [kg]", "leaked [kg]"):
        assert (np.diff(curves[name]) >= -1e-9).all(), name  # sums that never fall
        assert curves[name][-1] > 0.0, name
