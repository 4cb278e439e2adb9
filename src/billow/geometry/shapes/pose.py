"""Where a body is and how it is turned: the one place where poses are computed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from billow.base.compiled import scalar, spliced


@dataclass(frozen=True)
class Pose:
    """centre [m], (3,); quaternion (w, x, y, z) body to space."""

    centre: np.ndarray
    quaternion: np.ndarray

    @property
    def rotation(self) -> np.ndarray:
        """Rotation matrix body to space, (3, 3)."""
        return rotation_matrix(self.quaternion)


NOT_TURNED = np.array([1.0, 0.0, 0.0, 0.0])


def above_bag(third_radius: float, clearance: float, offset: np.ndarray, angle_about_x: float) -> Pose:
    """Pose of an impactor: its centre lies clearance + third_radius [m] above the plane z = 0, offset [m] (2,) across
    the bag's axis; it is turned about the x axis by an angle [rad]."""
    centre = np.array([*offset, clearance + third_radius])
    return Pose(centre, quaternion_about(np.array([1.0, 0.0, 0.0]), angle_about_x))


def of_plane(height: float, normal: np.ndarray, offset: Sequence[float] = (0.0, 0.0), turn: float = 0.0) -> Pose:
    """Pose of a half space whose surface passes through (x, y, height) [m], offset (x, y) [m] from the z axis, and
    whose third axis is the unit normal; turned about it by an angle [rad]."""
    axis = np.cross([0.0, 0.0, 1.0], normal)
    sine = float(np.linalg.norm(axis))
    centre = np.array([*offset, height])
    if sine == 0.0:  # upright, or upside down
        about_x = np.array([1.0, 0.0, 0.0])
        tilt = NOT_TURNED if normal[2] > 0.0 else quaternion_about(about_x, math.pi)
    else:
        tilt = quaternion_about(axis / sine, math.atan2(sine, float(normal[2])))
    return Pose(centre, times(tilt, quaternion_about(np.array([0.0, 0.0, 1.0]), turn)) if turn else tilt)


def quaternion_about(axis: np.ndarray, angle: float) -> np.ndarray:
    """Quaternion (w, x, y, z) of a rotation by angle [rad] about a unit axis."""
    return np.concatenate([[np.cos(0.5 * angle)], np.sin(0.5 * angle) * np.asarray(axis, dtype=float)])


def quaternion_of(rotation: np.ndarray) -> np.ndarray:
    """Quaternion (w, x, y, z) of a rotation matrix (3, 3), by its largest entry (Shepperd, J. Guidance and Control 1
    (1978) 223)."""
    m = np.asarray(rotation, float)
    squares = np.array([np.trace(m), m[0, 0], m[1, 1], m[2, 2]])
    k = int(squares.argmax())
    if k == 0:
        q = np.array([1.0 + squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    else:
        i, j, h = k - 1, k % 3, (k + 1) % 3
        q = np.empty(4)
        q[0], q[1 + i] = m[h, j] - m[j, h], 1.0 + 2.0 * m[i, i] - squares[0]
        q[1 + j], q[1 + h] = m[j, i] + m[i, j], m[h, i] + m[i, h]
    return q / np.linalg.norm(q)


def times(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Quaternion (w, x, y, z) of the second rotation and then the first."""
    (w, *v), (t, *u) = first, second
    v, u = np.array(v), np.array(u)
    return np.array([w * t - v @ u, *(w * u + t * v + np.cross(v, u))])


@scalar
def rotation_matrix(q):
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    out = np.empty((3, 3))
    out[0, 0], out[0, 1], out[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    out[1, 0], out[1, 1], out[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    out[2, 0], out[2, 1], out[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return out


# Poses for kernels, nine numbers: a rotation from the shape's axes to space, row by row.


@spliced
def pose_of(poses, o):
    """Row o of poses (n, 9)."""
    return (
        poses[o, 0], poses[o, 1], poses[o, 2], poses[o, 3], poses[o, 4], poses[o, 5], poses[o, 6], poses[o, 7],
        poses[o, 8],
    )  # fmt: skip


@scalar
def into_axes(pose, x, y, z):
    """A vector of space in the axes of a pose."""
    return (
        pose[0] * x + pose[3] * y + pose[6] * z,
        pose[1] * x + pose[4] * y + pose[7] * z,
        pose[2] * x + pose[5] * y + pose[8] * z,
    )


@scalar
def into_space(pose, x, y, z):
    """A vector in the axes of a pose in space."""
    return (
        pose[0] * x + pose[1] * y + pose[2] * z,
        pose[3] * x + pose[4] * y + pose[5] * z,
        pose[6] * x + pose[7] * y + pose[8] * z,
    )
