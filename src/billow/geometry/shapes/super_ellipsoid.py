"""Super-ellipsoid in its own axes about its centre (docs/theory.md, Super-ellipsoid). It is symmetric, so the closest
point is found in the first octant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.shapes.pose import into_axes, into_space
from billow.geometry.shapes.shape import NUMBERS

NEWTON_STEPS = 40


@dataclass(frozen=True)
class SuperEllipsoid:
    """radii (a, b, c) [m], (3,); degree n [-]: 2 is an ellipsoid, larger is boxier."""

    radii: np.ndarray
    degree: float
    kind: ClassVar[str] = "super-ellipsoid"

    @cached_property
    def numbers(self) -> np.ndarray:
        """Radii, degree, and its flatness: an ellipsoid larger by 1/flatness holds the body (norm inequality)."""
        flatness = 3.0 ** (1.0 / self.degree - 0.5)
        numbers = np.array([*self.radii, self.degree, flatness])
        return np.pad(numbers, (0, NUMBERS - len(numbers)))

    @property
    def bound(self) -> float:
        return float(max(self.radii) / self.numbers[4])

    @property
    def size(self) -> float:
        return float(min(self.radii))

    def volume(self) -> float:
        """8abc Gamma(1+1/n)^3 / Gamma(1+3/n)."""
        n = self.degree
        return float(8.0 * np.prod(self.radii) * math.gamma(1.0 + 1.0 / n) ** 3 / math.gamma(1.0 + 3.0 / n))

    def inertia(self, mass: float) -> np.ndarray:
        """Ixx = m (b^2 + c^2) k with k = Gamma(3/n) Gamma(1+3/n) / (Gamma(1/n) Gamma(1+5/n)); 1/5 for an ellipsoid."""
        n = self.degree
        k = math.gamma(3.0 / n) * math.gamma(1.0 + 3.0 / n) / (math.gamma(1.0 / n) * math.gamma(1.0 + 5.0 / n))
        square = np.asarray(self.radii) ** 2
        return mass * k * (square.sum() - square)

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """With G = (sum |y_k / a_k|^n)^(1/n), homogeneous of degree one, the distance is (G - 1) / |grad G|: exact for
        a sphere, and on the surface of any."""
        y = points / self.radii
        size = np.abs(y)
        # Scaled by its largest entry, no power overflows or vanishes; a point in the centre has no direction.
        largest = np.maximum(size.max(axis=1, keepdims=True), 1e-12)
        power = (size / largest) ** (self.degree - 1.0)
        sum_of_powers = np.maximum((power * size / largest).sum(axis=1), 1e-300)
        gauge = largest[:, 0] * sum_of_powers ** (1.0 / self.degree)
        gradient = np.sign(y) * power / self.radii * (sum_of_powers ** (1.0 / self.degree - 1.0))[:, None]
        steepness = np.maximum(np.linalg.norm(gradient, axis=1), 1e-12)
        return (gauge - 1.0) / steepness, gradient / steepness[:, None]

    def level(self, points: np.ndarray) -> np.ndarray:
        return (np.abs(points / np.asarray(self.radii)) ** self.degree).sum(axis=-1) - 1.0

    def describe(self) -> dict:
        return {"kind": self.kind, "radii": [float(r) for r in self.radii], "degree": float(self.degree)}

    @classmethod
    def from_description(cls, described: dict) -> SuperEllipsoid:
        return cls(np.array(described["radii"], float), float(described["degree"]))


@scalar
def near_super_ellipsoid(numbers, pose, rx, ry, rz, tx, ty, tz):
    """As `Shape` says."""
    a, b, c, degree, flatness = numbers
    x, y, z = into_axes(pose, rx, ry, rz)
    # G is convex with slope at most 1/smallest, so (G - 1) smallest is a lower bound of the distance. No power is taken
    # where the box or the enclosing and enclosed ellipsoids (norm inequalities, n >= 2) decide.
    near = 1.0 + math.sqrt(tx * tx + ty * ty + tz * tz) / min(a, b, c)
    if abs(x) >= near * a or abs(y) >= near * b or abs(z) >= near * c:
        return False, 0.0, 0.0, 0.0, 0.0
    ellipsoid = math.sqrt((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2)
    if ellipsoid > 1.0 and (flatness * ellipsoid >= near or radial_measure(x, y, z, a, b, c, degree) >= near):
        return False, 0.0, 0.0, 0.0, 0.0
    qx, qy, qz, mx, my, mz = closest_point(x, y, z, a, b, c, degree)
    depth = (qx - x) * mx + (qy - y) * my + (qz - z) * mz
    nx, ny, nz = into_space(pose, mx, my, mz)
    return True, depth, nx, ny, nz


@scalar
def farthest_of_super_ellipsoid(numbers, dx, dy, dz):
    """As `Shape` says: a s/|s| (|s|/|s|_m)^(m-1) with s = a d and m = n/(n - 1), whose norm is dual to that of the
    body."""
    a, b, c, degree, _ = numbers
    sx, sy, sz = abs(a * dx), abs(b * dy), abs(c * dz)
    largest = max(sx, sy, sz)
    sx, sy, sz = sx / largest, sy / largest, sz / largest
    less = 1.0 / (degree - 1.0)
    whole = (sx ** (1.0 + less) + sy ** (1.0 + less) + sz ** (1.0 + less)) ** (1.0 - 1.0 / degree)
    sx, sy, sz = (sx / whole) ** less, (sy / whole) ** less, (sz / whole) ** less
    return a * _sign(dx) * sx, b * _sign(dy) * sy, c * _sign(dz) * sz


@scalar
def radial_measure(x, y, z, a, b, c, degree):
    """G(x, y, z) [-]: below 1 inside, 1 on the surface, homogeneous of degree one."""
    return (abs(x / a) ** degree + abs(y / b) ** degree + abs(z / c) ** degree) ** (1.0 / degree)


@scalar
def closest_point(x, y, z, a, b, c, degree):
    """Closest surface point and outward unit normal there: (qx, qy, qz, nx, ny, nz).

    Newton on q + lambda grad F(q) = p, F(q) = 0 with F = sum |q_i/a_i|^n - 1. F is separable, so the Hessian of the
    Lagrangian is diagonal and a step is a handful of divisions. Starts from the radial projection, which is also the
    answer for a point so deep that "closest" means nothing (its curvature centre is nearer than itself).
    """
    px, py, pz = abs(x), abs(y), abs(z)
    if px + py + pz < 1e-12 * max(a, b, c):
        pz = 1e-12 * c
    if degree == 2.0 and a == b and b == c:  # a sphere
        away = math.sqrt(px * px + py * py + pz * pz)
        nx, ny, nz = _sign(x) * px / away, _sign(y) * py / away, _sign(z) * pz / away
        return a * nx, a * ny, a * nz, nx, ny, nz
    qx, qy, qz, wx, wy, wz = _onto_surface(px, py, pz, a, b, c, degree)
    gx, gy, gz = degree / (a * a) * wx * qx, degree / (b * b) * wy * qy, degree / (c * c) * wz * qz
    multiplier = ((px - qx) * gx + (py - qy) * gy + (pz - qz) * gz) / (gx * gx + gy * gy + gz * gz)
    tolerance = 1e-4 * max(a, b, c)  # Newton doubles its digits: the next step would be of the order of 1e-8
    for _ in range(NEWTON_STEPS):
        # Curvature terms are kept positive: inside, beyond a curvature centre, Newton would run to a farthest point.
        curvature = multiplier * degree * (degree - 1.0)
        dx = max(0.1, 1.0 + curvature / (a * a) * wx)
        dy = max(0.1, 1.0 + curvature / (b * b) * wy)
        dz = max(0.1, 1.0 + curvature / (c * c) * wz)
        rx, ry, rz = px - qx - multiplier * gx, py - qy - multiplier * gy, pz - qz - multiplier * gz
        change = (gx * rx / dx + gy * ry / dy + gz * rz / dz) / (gx * gx / dx + gy * gy / dy + gz * gz / dz)
        sx, sy, sz = (rx - gx * change) / dx, (ry - gy * change) / dy, (rz - gz * change) / dz
        # Steps are shortened to stay near the surface, where the quadratic model holds.
        step = abs(sx) + abs(sy) + abs(sz)
        shrink = min(1.0, 0.3 * min(a, b, c) / step) if step > 0.0 else 1.0
        qx, qy, qz = max(0.0, qx + shrink * sx), max(0.0, qy + shrink * sy), max(0.0, qz + shrink * sz)
        qx, qy, qz, wx, wy, wz = _onto_surface(qx, qy, qz, a, b, c, degree)
        gx, gy, gz = degree / (a * a) * wx * qx, degree / (b * b) * wy * qy, degree / (c * c) * wz * qz
        multiplier = ((px - qx) * gx + (py - qy) * gy + (pz - qz) * gz) / (gx * gx + gy * gy + gz * gz)
        if shrink == 1.0 and step < tolerance:
            break
    length = math.sqrt(gx * gx + gy * gy + gz * gz)
    flip_x, flip_y, flip_z = _sign(x), _sign(y), _sign(z)
    return flip_x * qx, flip_y * qy, flip_z * qz, flip_x * gx / length, flip_y * gy / length, flip_z * gz / length


@scalar
def _onto_surface(x, y, z, a, b, c, degree):
    """Radial projection (x, y, z) of a point of the first octant, and (q/a)^(n-2) there for each axis.

    Powers are what a closest point costs, so none is taken twice: slopes and curvatures follow from these three.
    """
    ux, uy, uz = x / a, y / b, z / c
    if degree == 2.0:
        back = 1.0 / math.sqrt(ux * ux + uy * uy + uz * uz)
        return back * x, back * y, back * z, 1.0, 1.0, 1.0
    wx, wy, wz = ux ** (degree - 2.0), uy ** (degree - 2.0), uz ** (degree - 2.0)
    value = wx * ux * ux + wy * uy * uy + wz * uz * uz
    back = value ** (-1.0 / degree)
    scale = 1.0 / (value * back * back)
    return back * x, back * y, back * z, scale * wx, scale * wy, scale * wz


@scalar
def _sign(value):
    return -1.0 if value < 0.0 else 1.0
