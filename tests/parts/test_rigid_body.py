"""A rigid body: a rotation stays one, momentum and energy stay what they are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.geometry.shapes.pose import quaternion_about, rotation_matrix
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid
from billow.parts.bodies.rigid_body import (
    RigidBody,
    RigidState,
    advance,
    kinetic_energy,
    spin,
)

BODY = RigidBody(4.5, SuperEllipsoid(np.array([0.2, 0.12, 0.08]), 3.0).inertia(4.5), locked=False)
GRAVITY = np.array([0.0, 0.0, -9.81])


@given(
    axis=st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda a: np.dot(a, a) > 0.01),
    angle=st.floats(-10.0, 10.0),
    vector=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
)
def test_a_rotation_matrix_turns_about_its_axis(axis, angle, vector):
    axis = np.array(axis) / np.linalg.norm(axis)
    rotation = rotation_matrix(quaternion_about(axis, angle))
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-14)
    v = np.array(vector)
    turned = v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * (axis @ v) * (1.0 - np.cos(angle))
    assert rotation @ v == pytest.approx(turned, abs=1e-14)  # Rodrigues


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_tumbling_body_keeps_momentum_and_energy(axis):
    """Near each principal axis, the unstable middle one too, over some fifty turns."""
    momentum = BODY.inertia * np.where(np.arange(3) == axis, 60.0, 0.6)
    body = RigidState(np.zeros(3), angular_momentum=momentum.copy(), velocity=np.array([1.0, 2.0, 3.0]))
    start, energies = kinetic_energy(BODY, body), []
    for _ in range(5000):
        advance(BODY, body, np.zeros(3), 1e-3)
        energies.append(kinetic_energy(BODY, body))
    assert body.angular_momentum == pytest.approx(momentum, rel=1e-15)
    assert np.linalg.norm(body.quaternion) == pytest.approx(1.0, abs=1e-14)
    assert body.rotation @ body.rotation.T == pytest.approx(np.eye(3), abs=1e-13)
    assert body.centre == pytest.approx([5.0, 10.0, 15.0], rel=1e-12)
    gap = np.abs(np.array(energies) / start - 1.0)
    assert gap.max() < 1e-3
    assert gap[-500:].max() < 2.0 * gap[:2500].max()  # bounded: it does not drift


def test_energy_error_is_of_second_order():
    gaps = []
    for dt in (2e-3, 1e-3, 5e-4):
        body = RigidState(np.zeros(3), angular_momentum=BODY.inertia * np.array([20.0, 30.0, 10.0]))
        start, gap = kinetic_energy(BODY, body), 0.0
        for _ in range(round(0.4 / dt)):
            advance(BODY, body, np.zeros(3), dt)
            gap = max(gap, abs(kinetic_energy(BODY, body) - start))
        gaps.append(gap)
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.1)
    assert gaps[1] / gaps[2] == pytest.approx(4.0, rel=0.1)


def test_a_torque_turns_and_a_force_moves():
    """Constant torque about a principal axis and constant force: the closed forms, exactly."""
    body = RigidState(np.zeros(3), force=np.array([9.0, 0.0, 0.0]), torque=np.array([0.0, 0.0, 0.3]))
    for _ in range(1000):
        advance(BODY, body, GRAVITY, 1e-3)
    assert body.velocity == pytest.approx([2.0, 0.0, -9.81], rel=1e-12)
    assert body.centre == pytest.approx([1.0, 0.0, -4.905], rel=1e-12)
    assert spin(BODY, body) == pytest.approx([0.0, 0.0, 0.3 / BODY.inertia[2]], rel=1e-12)
    turned = 0.5 * 0.3 / BODY.inertia[2]
    assert body.rotation @ [1.0, 0.0, 0.0] == pytest.approx([np.cos(turned), np.sin(turned), 0.0], abs=1e-4)


def test_a_locked_body_does_not_move():
    locked = RigidBody(4.5, BODY.inertia, locked=True)
    body = RigidState(np.ones(3), velocity=np.ones(3), force=np.ones(3), torque=np.ones(3))
    advance(locked, body, GRAVITY, 1.0)
    assert (body.centre == 1.0).all()
    assert kinetic_energy(locked, body) == 0.0
