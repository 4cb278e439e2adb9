"""R1: a free rigid body without contact."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.apps.verification.check import Measurement
from billow.apps.verification.meshes import disc
from billow.apps.verification.scenes import fabric_model, isotropic
from billow.geometry.shapes.pose import quaternion_about
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid
from billow.parts.bodies.body import Body
from billow.parts.bodies.contact import SurfaceLaw
from billow.parts.bodies.rigid_body import RigidBody, RigidState, kinetic_energy
from billow.solver.model import start_state
from billow.solver.step import advance


def torque_free_top() -> Iterator[Measurement]:
    """R1: a body of three different inertias spins near its intermediate axis, tumbles over, and keeps its angular
    momentum and energy (Euler's equations).

    The solver carries the angular momentum in space, where nothing changes it; that says little. It is therefore
    measured again from how the body turns: R I R^T w, with the spin w from the attitudes two steps before and after
    (fourth-order difference). Spin times step is 2e-3, and the splitting's error of order (w dt)^2/12, 3e-7. In 10,000
    steps, three turns, the intermediate axis tips over. How far follows from the two constants alone: where the
    momentum about the axis of largest (or smallest) inertia passes zero, sum L_i^2 = L^2 and sum L_i^2/I_i = 2 E give
    L_2.
    """
    radii, mass, rate = np.array([0.10, 0.15, 0.22]), 4.5, 20.0
    shape = SuperEllipsoid(radii, 3.0)
    inertia = shape.inertia(mass)
    momentum = inertia * rate * np.array([0.05, 1.0, 0.08])
    body = RigidBody(mass, inertia, locked=False)
    attitude = RigidState(np.array([0.0, 0.0, 10.0]), quaternion_about(np.array([0.6, 0.0, 0.8]), 0.7))
    attitude.angular_momentum = attitude.rotation @ momentum
    top = Body.of("top", shape, SurfaceLaw(1e6, 0.0, 0.0), body, attitude)
    model = fabric_model(disc(0.1, 0.05), isotropic(1e8, 0.3, 1000.0, 1e-3), bodies=(top,))
    state = start_state(model)
    dt, steps = 2e-3 / rate, 10_000
    quaternions, energies = np.empty((steps + 1, 4)), np.empty(steps + 1)
    for k in range(steps + 1):
        motion = state.bodies.motion[0]
        quaternions[k], energies[k] = motion.quaternion, kinetic_energy(body, motion)
        advance(model, state, dt)

    size = np.linalg.norm(momentum)
    error = np.linalg.norm(_angular_momentum(quaternions, inertia, dt) - attitude.angular_momentum, axis=1) / size
    yield Measurement("angular momentum, largest change / L [absolute]", error.max(), 0.0, 1e-6)
    change = np.abs(energies / energies[0] - 1.0).max()
    yield Measurement("energy, largest change / E [absolute]", change, 0.0, 1e-6)

    twice_energy = np.sum(momentum**2 / inertia)
    outer = inertia.min() if twice_energy * inertia[1] > size**2 else inertia.max()
    turned = np.sqrt((size**2 / outer - twice_energy) / (1.0 / outer - 1.0 / inertia[1])) / size
    axis = _turn(np.array([0.0, 1.0, 0.0]), quaternions[:, :1], quaternions[:, 1:])
    lowest = (axis @ attitude.angular_momentum).min() / size
    yield Measurement("cosine of the intermediate axis to L, tipped over [-]", lowest, -turned, 1e-6)


def _angular_momentum(q: np.ndarray, inertia: np.ndarray, dt: float) -> np.ndarray:
    """R I R^T w [kg m^2/s], (n - 4, 3), from unit quaternions (n, 4) every dt [s]; w = 2 dq/dt q^-1."""
    rate = (q[:-4] - 8.0 * q[1:-3] + 8.0 * q[3:-1] - q[4:]) / (12.0 * dt)
    w, v = q[2:-2, :1], q[2:-2, 1:]
    spin = 2.0 * (w * rate[:, 1:] - rate[:, :1] * v - np.cross(rate[:, 1:], v))
    # Into the body's axes and back.
    in_body = _turn(spin, w, -v) * inertia
    return _turn(in_body, w, v)


def _turn(x: np.ndarray, w: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Vectors x turned by quaternions (w, v)."""
    return x + 2.0 * np.cross(v, np.cross(v, x) + w * x)
