"""A rigid body with six degrees of freedom, or locked (docs/theory.md, Rigid bodies)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.shapes.pose import Pose, rotation_matrix


@dataclass(frozen=True)
class RigidBody:
    """Mass properties: mass [kg], inertia about principal axes [kg m^2] (3,). locked bodies never move."""

    mass: float
    inertia: np.ndarray
    locked: bool


@dataclass
class RigidState:
    """centre [m] (3,), velocity [m/s] (3,), quaternion (w, x, y, z) body to space, angular_momentum [kg m^2/s] (3,) in
    space; force [N] (3,) and torque [N m] (3,) about the centre, of the last evaluation."""

    centre: np.ndarray
    quaternion: np.ndarray = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_momentum: np.ndarray = field(default_factory=lambda: np.zeros(3))
    force: np.ndarray = field(default_factory=lambda: np.zeros(3))
    torque: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @property
    def rotation(self) -> np.ndarray:
        """Rotation matrix body to space, (3, 3)."""
        return rotation_matrix(self.quaternion)


def moving(body: RigidBody, pose: Pose, velocity: np.ndarray, spin: np.ndarray) -> RigidState:
    """State of a body in a pose with a velocity [m/s] and a spin [rad/s], both in space; a locked one rests."""
    if body.locked:
        return RigidState(pose.centre, pose.quaternion)
    rotation = pose.rotation
    return RigidState(pose.centre, pose.quaternion, velocity, rotation @ (body.inertia * (rotation.T @ spin)))


def spin(body: RigidBody, state: RigidState) -> np.ndarray:
    """Angular velocity in space [rad/s], (3,)."""
    found = np.zeros(3)
    if not body.locked:
        _spin(state.rotation, state.angular_momentum, body.inertia, found)
    return found


def carry(
    body: RigidBody, state: RigidState, centre: np.ndarray, axes: np.ndarray, motion_out: np.ndarray,
    centre_out: np.ndarray, pose_out: np.ndarray,
) -> None:  # fmt: skip
    """Where a shape is that a body carries at a centre [m] (3,), with axes (3, 3) of its own: into motion_out (9,)
    centre [m], velocity [m/s] and spin [rad/s] of the body, into centre_out (3,) that of the shape from it [m], into
    pose_out (9,) its rotation to space, row by row."""
    _carry(
        state.centre, state.velocity, state.quaternion, state.angular_momentum, body.inertia, body.locked, centre,
        axes, motion_out, centre_out, pose_out,
    )  # fmt: skip


def kinetic_energy(body: RigidBody, state: RigidState) -> float:
    """Translational plus rotational energy [J]."""
    if body.locked:
        return 0.0
    return _kinetic_energy(state.velocity, state.quaternion, state.angular_momentum, body.mass, body.inertia)


def advance(body: RigidBody, state: RigidState, gravity: np.ndarray, dt: float) -> float:
    """A step of dt [s] under the state's force and torque, averages over the step; gravity: [m/s^2], (3,). Returns the
    work of gravity [J].

    Drift, kick, drift (position Verlet): forces are those at the middle, where penalty contact gives them.
    """
    if body.locked:
        return 0.0
    return _advance(
        state.centre, state.velocity, state.quaternion, state.angular_momentum, state.force, state.torque, body.mass,
        body.inertia, gravity, dt,
    )  # fmt: skip


@scalar
def _advance(centre, velocity, quaternion, angular_momentum, force, torque, mass, inertia, gravity, dt):
    work = 0.0
    for k in range(3):
        acceleration = force[k] / mass + gravity[k]
        way = dt * (velocity[k] + 0.5 * dt * acceleration)
        centre[k] += way
        velocity[k] += dt * acceleration
        work += mass * gravity[k] * way
    rotate_freely(quaternion, angular_momentum, inertia, 0.5 * dt)
    for k in range(3):
        angular_momentum[k] += dt * torque[k]
    rotate_freely(quaternion, angular_momentum, inertia, 0.5 * dt)
    return work


@scalar
def _kinetic_energy(velocity, quaternion, angular_momentum, mass, inertia):
    twice, rotation = 0.0, rotation_matrix(quaternion)
    for k in range(3):
        own = 0.0
        for i in range(3):
            own += rotation[i, k] * angular_momentum[i]
        twice += mass * velocity[k] * velocity[k] + own * own / inertia[k]
    return 0.5 * twice


@scalar
def _carry(
    centre, velocity, quaternion, angular_momentum, inertia, locked, own_centre, axes, motion_out, centre_out, pose_out
):  # fmt: skip
    rotation = rotation_matrix(quaternion)
    for k in range(3):
        motion_out[k], motion_out[3 + k], motion_out[6 + k] = centre[k], velocity[k], 0.0
    if not locked:
        _spin(rotation, angular_momentum, inertia, motion_out[6:])
    for i in range(3):
        centre_out[i] = 0.0
        for k in range(3):
            centre_out[i] += rotation[i, k] * own_centre[k]
        for j in range(3):
            turned = 0.0
            for k in range(3):
                turned += rotation[i, k] * axes[k, j]
            pose_out[3 * i + j] = turned


@scalar
def _spin(rotation, angular_momentum, inertia, spin_out):
    for k in range(3):
        own = 0.0
        for i in range(3):
            own += rotation[i, k] * angular_momentum[i]
        for i in range(3):
            spin_out[i] += rotation[i, k] * own / inertia[k]


@scalar
def rotate_freely(quaternion, angular_momentum, inertia, dt):
    """Torque-free rotation over dt [s]; changes quaternion in place, the angular momentum in space stays as it is."""
    rotation = rotation_matrix(quaternion)
    momentum = np.empty(3)
    for i in range(3):
        momentum[i] = (
            rotation[0, i] * angular_momentum[0]
            + rotation[1, i] * angular_momentum[1]
            + rotation[2, i] * angular_momentum[2]
        )
    turn = np.empty(4)
    for k, share in ((0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)):
        angle = share * dt * momentum[k] / inertia[k]
        i, j = (k + 1) % 3, (k + 2) % 3
        c, s = math.cos(angle), math.sin(angle)
        momentum[i], momentum[j] = c * momentum[i] + s * momentum[j], c * momentum[j] - s * momentum[i]
        turn[0], turn[1], turn[2], turn[3] = math.cos(0.5 * angle), 0.0, 0.0, 0.0
        turn[1 + k] = math.sin(0.5 * angle)
        w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
        quaternion[0] = w * turn[0] - x * turn[1] - y * turn[2] - z * turn[3]
        quaternion[1] = w * turn[1] + x * turn[0] + y * turn[3] - z * turn[2]
        quaternion[2] = w * turn[2] - x * turn[3] + y * turn[0] + z * turn[1]
        quaternion[3] = w * turn[3] + x * turn[2] - y * turn[1] + z * turn[0]
    norm = math.sqrt(quaternion[0] ** 2 + quaternion[1] ** 2 + quaternion[2] ** 2 + quaternion[3] ** 2)
    for k in range(4):
        quaternion[k] /= norm
