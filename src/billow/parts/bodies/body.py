"""A body: a rigid mass that moves, or is locked, and carries the shapes that fabric can touch."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from billow.geometry.shapes.shape import Shape
from billow.parts.bodies.contact import SurfaceLaw
from billow.parts.bodies.drive import Drive, Guided
from billow.parts.bodies.rigid_body import RigidBody, RigidState


@dataclass(frozen=True)
class Carried:
    """A shape and its place on a body: centre from the body's [m], (3,), and rotation of its axes to the body's, (3,
    3)."""

    shape: Shape
    centre: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))


@dataclass(frozen=True)
class Body:
    """Something rigid the fabric can touch. shapes: all with the same surface law; start: its motion at time zero;
    drive: what moves it, if it is neither locked nor free; then `rigid` is locked."""

    name: str
    shapes: tuple[Carried, ...]
    law: SurfaceLaw
    rigid: RigidBody
    start: RigidState
    drive: Drive | None = None

    @classmethod
    def of(
        cls, name: str, shape: Shape, law: SurfaceLaw, rigid: RigidBody, start: RigidState, drive: Drive | None = None
    ) -> Body:
        """A body of one shape in its centre."""
        return cls(name, (Carried(shape),), law, rigid, start, drive)

    @property
    def moves(self) -> bool:
        """Whether it does not stay where it starts."""
        return not self.rigid.locked or self.drive is not None

    @property
    def yields(self) -> bool:
        """Whether forces move it."""
        return not self.rigid.locked or isinstance(self.drive, Guided)

    @property
    def size(self) -> float:
        """Smallest radius of its shapes [m]."""
        return min(carried.shape.size for carried in self.shapes)

    @property
    def is_bounded(self) -> bool:
        """Whether it has an end, as an impactor has and a plate has not."""
        return all(np.isfinite(carried.shape.bound) for carried in self.shapes)

    @property
    def is_rigid(self) -> bool:
        """Whether its contact springs only keep fabric out; those of a locked impactor are its own characteristic."""
        return not self.is_bounded or self.yields

    def describe(self) -> list[dict]:
        """What pictures need, at the start: one entry a shape."""
        turn, found = self.start.rotation, []
        for carried in self.shapes:
            centre = self.start.centre + turn @ carried.centre
            rotation = turn @ carried.rotation
            place = {"center": centre.tolist(), "rotation": rotation.tolist(), "locked": not self.moves}
            found.append({"name": self.name, **carried.shape.describe(), **place})
        return found

    def encloses(self, points: np.ndarray) -> np.ndarray:
        """Whether points [m] (n, 3) lie inside one of its shapes at the start, (n,) bool."""
        return (self.distance(points) < 0.0).any(axis=0)

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of points [m] (n, 3) from each shape at the start, to first order: [m], (shapes, n)."""
        turned = (points - self.start.centre) @ self.start.rotation
        found = []
        for carried in self.shapes:
            own = turned - carried.centre
            found.append(carried.shape.distance(own @ carried.rotation)[0])
        return np.array(found)
