"""A box with rounded edges: all points within the radius of its edges from a smaller box, so that its distance is
exact and its normal turns without a jump. Walls, flaps and tables are made of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.shapes.pose import into_axes, into_space
from billow.geometry.shapes.shape import NUMBERS

MEETS_AS = 10.0
"""Degree of the super-ellipsoid as which a box meets other bodies: theirs is a search for smooth shapes."""


@dataclass(frozen=True)
class Box:
    """half: half of its lengths along its own axes [m], (3,); edge: radius of its edges [m], at most the least half."""

    half: np.ndarray
    edge: float
    kind: ClassVar[str] = "box"

    @property
    def numbers(self) -> np.ndarray:
        own = np.array([*self.half, self.edge])
        return np.pad(own, (0, NUMBERS - len(own)))

    @property
    def bound(self) -> float:
        return float(np.linalg.norm(self.half))

    @property
    def size(self) -> float:
        return float(min(self.half))

    def volume(self) -> float:
        """By Steiner's formula: of the smaller box, and of what lies on its faces, edges and corners."""
        r = self.edge
        a, b, c = 2.0 * (np.asarray(self.half) - r)
        return float(a * b * c + 2.0 * r * (a * b + b * c + c * a) + math.pi * r**2 * (a + b + c + 4.0 / 3.0 * r))

    def inertia(self, mass: float) -> np.ndarray:
        """m (b^2 + c^2)/3 of half lengths, as if its edges were sharp."""
        square = np.asarray(self.half) ** 2
        return mass * (square.sum() - square) / 3.0

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        inner = np.asarray(self.half) - self.edge
        beyond = points - np.clip(points, -inner, inner)
        away = np.linalg.norm(beyond, axis=1)
        left = np.abs(points) - inner  # negative within the smaller box, whose nearest face counts there
        face = np.sign(points) * (np.arange(3) == left.argmax(axis=1)[:, None])
        outside = away > 0.0
        normal = np.where(outside[:, None], beyond / np.maximum(away, 1e-300)[:, None], face)
        return np.where(outside, away, left.max(axis=1)) - self.edge, normal

    def level(self, points: np.ndarray) -> np.ndarray:
        return self.distance(points.reshape(-1, 3))[0].reshape(points.shape[:-1])

    def describe(self) -> dict:
        return {"kind": self.kind, "half": [float(h) for h in self.half], "edge": float(self.edge)}

    @classmethod
    def from_description(cls, described: dict) -> Box:
        return cls(np.array(described["half"], float), float(described["edge"]))


@scalar
def near_box(numbers, pose, rx, ry, rz, tx, ty, tz):
    """As `Shape` says."""
    a, b, c, edge, _ = numbers
    x, y, z = into_axes(pose, rx, ry, rz)
    reach = math.sqrt(tx * tx + ty * ty + tz * tz)
    if abs(x) >= a + reach or abs(y) >= b + reach or abs(z) >= c + reach:
        return False, 0.0, 0.0, 0.0, 0.0
    mx, my, mz = _beyond(x, a - edge), _beyond(y, b - edge), _beyond(z, c - edge)
    away = math.sqrt(mx * mx + my * my + mz * mz)
    if away > 0.0:
        depth, mx, my, mz = edge - away, mx / away, my / away, mz / away
    else:
        left, mx, my, mz = a - abs(x), math.copysign(1.0, x), 0.0, 0.0
        if b - abs(y) < left:
            left, mx, my, mz = b - abs(y), 0.0, math.copysign(1.0, y), 0.0
        if c - abs(z) < left:
            left, mx, my, mz = c - abs(z), 0.0, 0.0, math.copysign(1.0, z)
        depth = left
    nx, ny, nz = into_space(pose, mx, my, mz)
    return depth > -reach, depth, nx, ny, nz


@scalar
def _beyond(x, half):
    """How far a coordinate lies beyond -half..half."""
    return x - min(max(x, -half), half)
