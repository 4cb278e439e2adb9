"""Bodies that are moved along a straight line and never turn: their travel or their speed is given against time, or
they are guided and a force given against time pushes them (docs/theory.md, Obstacles that are moved).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from billow.parts.bodies.rigid_body import RigidState


class Course(NamedTuple):
    """A piecewise linear curve: times [s] that increase, and a value at each; before and after them it stays."""

    time: np.ndarray
    value: np.ndarray

    def at(self, time: float) -> float:
        return float(np.interp(time, self.time, self.value))

    def integral(self, begin: float, end: float) -> float:
        """Over the time from `begin` to `end` [s], exactly."""
        inside = self.time[(self.time > begin) & (self.time < end)]
        times = np.concatenate([[begin], inside, [end]])
        values = np.interp(times, self.time, self.value)
        return float(0.5 * (values[1:] + values[:-1]) @ np.diff(times))


@dataclass(frozen=True)
class Prescribed:
    """A body whose way is given, whatever it takes. direction: unit vector, (3,). course: of its travel [m], or of its
    speed [m/s]."""

    direction: np.ndarray
    course: Course
    is_speed: bool

    def way(self, time: float) -> float:
        """From its start until a time [s], [m]."""
        return self.course.integral(0.0, time) if self.is_speed else self.course.at(time) - self.course.at(0.0)


@dataclass(frozen=True)
class Guided:
    """A body of a mass [kg] on a rail. direction: unit vector, (3,). force: along it [N], beside contact and gravity;
    speed: at the start [m/s]."""

    direction: np.ndarray
    force: Course
    mass: float
    speed: float

    def kinetic_energy(self, motion: RigidState) -> float:
        """[J]"""
        return 0.5 * self.mass * float(motion.velocity @ motion.velocity)

    def acceleration(self, motion: RigidState, push: float, gravity: np.ndarray) -> np.ndarray:
        """[m/s^2], (3,), under the contact forces in `motion`, a push of the drive [N] and gravity [m/s^2], (3,)."""
        along = (self.direction @ motion.force + push) / self.mass + self.direction @ gravity
        return float(along) * self.direction


Drive = Prescribed | Guided


def begin(drive: Drive, motion: RigidState, start: np.ndarray, time: float, dt: float) -> float:
    """Set the velocity of a prescribed body that takes it from where it is at `time` [s] to where it shall be dt [s]
    later, evenly; returns the mean push on a guided one [N]. start: its centre at time zero [m], (3,)."""
    if isinstance(drive, Guided):
        return drive.force.integral(time, time + dt) / dt
    motion.velocity = (start + drive.way(time + dt) * drive.direction - motion.centre) / dt
    return 0.0


def advance(drive: Drive, motion: RigidState, push: float, gravity: np.ndarray, dt: float) -> tuple[float, float]:
    """A step of dt [s] under the mean contact forces in `motion` and the mean push [N]; returns the work of the drive
    and of gravity [J]. Both are exact for the way of the body, and so is the energy it gains."""
    if isinstance(drive, Prescribed):  # the forces of contact were solved for just this velocity
        way = dt * motion.velocity
        motion.centre += way
        return -float(motion.force @ way), 0.0
    acceleration = drive.acceleration(motion, push, gravity)
    way = dt * (motion.velocity + 0.5 * dt * acceleration)
    motion.centre += way
    motion.velocity += dt * acceleration
    return push * float(drive.direction @ way), drive.mass * float(gravity @ way)
