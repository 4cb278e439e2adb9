"""Half space: everything below the plane z = 0 of its own axes."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from billow.base.compiled import spliced
from billow.geometry.shapes.pose import into_axes
from billow.geometry.shapes.shape import NUMBERS

DEPTH = 0.1
"""Thickness [m] that a plate is taken to have."""


class HalfSpace:
    """A plate without edges; its normal is the third axis. It has no volume of its own and never moves."""

    kind: ClassVar[str] = "plate"
    numbers: ClassVar[np.ndarray] = np.zeros(NUMBERS)
    bound: ClassVar[float] = np.inf
    size: ClassVar[float] = DEPTH

    def volume(self) -> float:
        return np.inf

    def inertia(self, mass: float) -> np.ndarray:
        return np.full(3, np.inf)

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return points[:, 2].copy(), np.tile([0.0, 0.0, 1.0], (len(points), 1))

    def level(self, points: np.ndarray) -> np.ndarray:
        return points[..., 2]

    def describe(self) -> dict:
        return {"kind": self.kind}

    @classmethod
    def from_description(cls, described: dict) -> HalfSpace:
        return cls()


@spliced
def near_half_space(numbers, pose, rx, ry, rz, tx, ty, tz):
    """As `Shape` says: only a node that is below the plane now or at the end of the step."""
    _, _, z = into_axes(pose, rx, ry, rz)
    _, _, travel = into_axes(pose, tx, ty, tz)
    return max(-z, -z - travel) > 0.0, -z, pose[2], pose[5], pose[8]
