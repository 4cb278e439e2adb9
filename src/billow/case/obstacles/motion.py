"""The `[obstacles.motion]` table: what moves an obstacle along a line."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import field_validator, model_validator

from billow.case.quantity import Strict, chosen_by, curve, number_or_curve, quantity, refused
from billow.parts.bodies.drive import Course, Drive, Guided, Prescribed

FASTEST = 100.0
"""Speed [m/s] of what moves an obstacle."""
Component = quantity("-", -1e3, 1e3)


def unit_vector(components: tuple[float, float, float]) -> np.ndarray:
    """The direction of a vector that is not zero, (3,)."""
    scaled = np.array(components) / np.abs(components).max()  # so that no square is lost
    return scaled / np.linalg.norm(scaled)


def points_somewhere(value):
    """A validator that refuses the zero vector."""
    if not any(value):
        raise refused("it has no direction", "write [0, 0, 1]")
    return value


class MotionTable(Strict):
    """Settings common to all that moves obstacles."""

    chooser: ClassVar[str] = "kind"


class AtRest(MotionTable):
    """Nothing moves the obstacle but what touches it, if it is free."""

    kind: Literal["none"] = "none"
    """none"""

    def build(self) -> None:
        return None


class Directed(MotionTable):
    """Along a line; the obstacle does not turn."""

    direction: tuple[Component, Component, Component] = (0.0, 0.0, -1.0)
    """Direction of the line; its length does not count."""

    _points_somewhere = field_validator("direction")(points_somewhere)


class Travel(Directed):
    """Its way from the start is given."""

    kind: Literal["travel"]
    """travel"""
    travel: curve("m", -10.0, 10.0)
    """Way along the direction against time, 0 at time 0; after the last point it stays."""

    @model_validator(mode="after")
    def _begins_at_its_start_and_is_not_too_fast(self):
        speeds = np.abs(np.diff(self.travel.value) / np.diff(self.travel.time))
        if speeds.max() > FASTEST:
            reason = f"it would move at {speeds.max():.3g} m/s; at most {FASTEST:g} m/s are plausible"
            raise refused(reason, 'write units, for example time = [0, "10 ms"], value = [0, "20 mm"]', kind="range")
        if first := Course(np.array(self.travel.time), np.array(self.travel.value)).at(0.0):
            reason = f"travel is {first:g} m at time 0, where the obstacle is at its start"
            raise refused(reason, "begin with time 0 and value 0, and place the obstacle where it starts")
        return self

    def build(self) -> Drive:
        return Prescribed(unit_vector(self.direction), _course(self.travel), is_speed=False)


class Speed(Directed):
    """Its speed is given."""

    kind: Literal["speed"]
    """speed"""
    speed: number_or_curve("m/s", -FASTEST, FASTEST, "time")
    """Speed along the direction: a number, or a curve against time."""

    def build(self) -> Drive:
        return Prescribed(unit_vector(self.direction), _course(self.speed), is_speed=True)


class Guide(Directed):
    """On a rail: it yields along the direction only, and a force pushes it."""

    kind: Literal["guided"]
    """guided"""
    mass: quantity("kg", 1e-3, 1000.0)
    """Mass that moves."""
    force: number_or_curve("N", -1e6, 1e6, "time") = 0.0
    """Force along the direction, beside contact and gravity: a number, or a curve against time."""
    speed: quantity("m/s", -FASTEST, FASTEST) = 0.0
    """Speed along the direction at the start."""

    def build(self) -> Drive:
        return Guided(unit_vector(self.direction), _course(self.force), self.mass, self.speed)


def _course(value) -> Course:
    if isinstance(value, float):
        return Course(np.zeros(1), np.array([value]))
    return Course(np.array(value.time), np.array(value.value))


MOTIONS: dict[str, type[MotionTable]] = {"none": AtRest, "travel": Travel, "speed": Speed, "guided": Guide}
"""Table of each kind."""

Motion = chosen_by("kind", MOTIONS, default="none")
