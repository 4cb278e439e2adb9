"""A cylinder with rounded edges: all points within the radius of its edges from a smaller cylinder, as a box is of a
smaller box. Its axis is the third."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.shapes.pose import into_axes, into_space
from billow.geometry.shapes.shape import NUMBERS
from billow.geometry.shapes.super_ellipsoid import farthest_of_super_ellipsoid

MEETS_AS = 10.0
"""Degree n of (r/a)^n + |z/c|^n = 1, as which it meets other bodies: theirs is a search for smooth shapes."""


@dataclass(frozen=True)
class Cylinder:
    """radius, half: of its length, edge: radius of its edges, at most the smaller of both; [m]."""

    radius: float
    half: float
    edge: float
    kind: ClassVar[str] = "cylinder"

    @property
    def numbers(self) -> np.ndarray:
        own = np.array([self.radius, self.half, self.edge])
        return np.pad(own, (0, NUMBERS - len(own)))

    @property
    def bound(self) -> float:
        return math.hypot(self.radius, self.half)

    @property
    def size(self) -> float:
        return min(self.radius, self.half)

    def volume(self) -> float:
        """By Steiner's formula, from the smaller cylinder."""
        e, a, length = self.edge, self.radius - self.edge, 2.0 * (self.half - self.edge)
        faces, curved = 2.0 * math.pi * a * (length + a), math.pi * (length + math.pi * a)
        return math.pi * a**2 * length + e * faces + e**2 * curved + 4.0 / 3.0 * math.pi * e**3

    def inertia(self, mass: float) -> np.ndarray:
        """m r^2/2 and m (3 r^2 + (2 h)^2)/12, as if its edges were sharp."""
        across = mass * (3.0 * self.radius**2 + 4.0 * self.half**2) / 12.0
        return np.array([across, across, 0.5 * mass * self.radius**2])

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        out = np.hypot(points[:, 0], points[:, 1])
        radial = np.where(out[:, None] > 0.0, points[:, :2] / np.maximum(out, 1e-300)[:, None], [1.0, 0.0])
        side, end = out - (self.radius - self.edge), np.abs(points[:, 2]) - (self.half - self.edge)
        away = np.hypot(np.maximum(side, 0.0), np.maximum(end, 0.0))
        outside, size = away > 0.0, np.maximum(away, 1e-300)
        along = np.where(outside, np.maximum(side, 0.0) / size, side >= end)
        up = np.sign(points[:, 2]) * np.where(outside, np.maximum(end, 0.0) / size, side < end)
        normal = np.column_stack([along[:, None] * radial, up])
        return np.where(outside, away, np.maximum(side, end)) - self.edge, normal

    def level(self, points: np.ndarray) -> np.ndarray:
        return self.distance(points.reshape(-1, 3))[0].reshape(points.shape[:-1])

    def describe(self) -> dict:
        return {
            "kind": self.kind, "radius": float(self.radius), "half": float(self.half), "edge": float(self.edge)
        }  # fmt: skip

    @classmethod
    def from_description(cls, described: dict) -> Cylinder:
        return cls(*(float(described[key]) for key in ("radius", "half", "edge")))


@scalar
def near_cylinder(numbers, pose, rx, ry, rz, tx, ty, tz):
    """As `Shape` says."""
    radius, half, edge, _, _ = numbers
    x, y, z = into_axes(pose, rx, ry, rz)
    out = math.sqrt(x * x + y * y)
    reach = math.sqrt(tx * tx + ty * ty + tz * tz)
    if out >= radius + reach or abs(z) >= half + reach:
        return False, 0.0, 0.0, 0.0, 0.0
    ux, uy = (x / out, y / out) if out > 0.0 else (1.0, 0.0)
    side, end = out - (radius - edge), abs(z) - (half - edge)
    along, up = max(side, 0.0), max(end, 0.0)
    away = math.sqrt(along * along + up * up)
    if away > 0.0:
        depth, along, up = edge - away, along / away, up / away
    elif side >= end:
        depth, along, up = edge - side, 1.0, 0.0
    else:
        depth, along, up = edge - end, 0.0, 1.0
    nx, ny, nz = into_space(pose, along * ux, along * uy, math.copysign(up, z))
    return depth > -reach, depth, nx, ny, nz


@scalar
def farthest_of_cylinder(numbers, dx, dy, dz):
    """As `Shape` says."""
    radius, half, _, _, _ = numbers
    across = math.sqrt(dx * dx + dy * dy)
    out, _, z = farthest_of_super_ellipsoid((radius, radius, half, MEETS_AS, 0.0), across, 0.0, dz)
    if across == 0.0:
        return 0.0, 0.0, z
    return out * dx / across, out * dy / across, z
