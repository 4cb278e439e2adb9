"""The contract of a rigid shape that fabric can touch.

A shape lives in axes of its own; bodies carry it about. It answers in two languages: NumPy methods for set-up, pictures
and mass properties, and one compiled function per kind for contact, which `kinds.py` lists.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np


class Shape(Protocol):
    """A shape in its own axes, about its own centre.

    kind: its name in cases and results. numbers: what its compiled function needs, (NUMBERS,). bound: radius of the
    sphere about the centre that holds it [m], inf for a shape below the plane z = 0. size: its smallest radius [m], or
    the depth it is taken to have.

    Its compiled function `near(numbers, pose, rx, ry, rz, tx, ty, tz)` takes the shape's numbers and its pose (see
    `into_axes`) as tuples, since arrays would be counted at each call and cost more than all the rest, a point r
    relative to the centre [m] and its travel t relative to the shape over the step [m], both in space. It returns
    whether the point may touch it within the step, the point's depth (negative outside) [m], and the outward unit
    normal in space, three numbers.
    """

    kind: str
    numbers: np.ndarray
    bound: float
    size: float

    def volume(self) -> float:
        """[m^3]."""

    def inertia(self, mass: float) -> np.ndarray:
        """Principal moments of inertia [kg m^2], (3,), of a solid of uniform density and mass [kg]."""

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance from the surface [m], (n,), negative inside, to first order, and outward normals (n, 3).

        points: [m], (n, 3).
        """

    def level(self, points: np.ndarray) -> np.ndarray:
        """A smooth function that is zero on the surface and negative inside: its zero line is the outline in a plane.

        points: [m], (..., 3); returns (...).
        """

    def describe(self) -> dict:
        """What a picture needs, for run.json; `kinds.from_description` makes the shape again."""


NUMBERS = 5
"""Room for the numbers of a shape."""
