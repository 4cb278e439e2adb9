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

SHORT = 0.01
"""Relative change below which a power follows from the one before by a series."""


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
    if ellipsoid > 1.0 and flatness * ellipsoid >= near:
        return False, 0.0, 0.0, 0.0, 0.0
    measure, qx, qy, qz, mx, my, mz = _closest_within(x, y, z, a, b, c, degree, near)
    if measure >= near:
        return False, 0.0, 0.0, 0.0, 0.0
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
def closest_point(x, y, z, a, b, c, degree):
    """Closest surface point and outward unit normal there: (qx, qy, qz, nx, ny, nz)."""
    _, qx, qy, qz, nx, ny, nz = _closest_within(x, y, z, a, b, c, degree, math.inf)
    return qx, qy, qz, nx, ny, nz


@scalar
def _closest_within(x, y, z, a, b, c, degree, near):
    """G(x, y, z) [-], below 1 inside, 1 on the surface, homogeneous of degree one; and what `closest_point` returns,
    zeros if G is `near` or more.

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
        return away / a, a * nx, a * ny, a * nz, nx, ny, nz
    exponent, aa, bb, cc = degree - 2.0, 1.0 / (a * a), 1.0 / (b * b), 1.0 / (c * c)
    wx, wy, wz = (px / a) ** exponent, (py / b) ** exponent, (pz / c) ** exponent
    back, qx, qy, qz, wx, wy, wz = _onto_surface(px, py, pz, wx, wy, wz, aa, bb, cc, degree)
    if 1.0 / back >= near:
        return 1.0 / back, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    measure = 1.0 / back
    gx, gy, gz = degree * aa * wx * qx, degree * bb * wy * qy, degree * cc * wz * qz
    multiplier = ((px - qx) * gx + (py - qy) * gy + (pz - qz) * gz) / (gx * gx + gy * gy + gz * gz)
    tolerance = 1e-4 * max(a, b, c)  # Newton doubles its digits: the next step would be of the order of 1e-8
    for _ in range(NEWTON_STEPS):
        # Curvature terms are kept positive: inside, beyond a curvature centre, Newton would run to a farthest point.
        curvature = multiplier * degree * (degree - 1.0)
        dx = 1.0 / max(0.1, 1.0 + curvature * aa * wx)
        dy = 1.0 / max(0.1, 1.0 + curvature * bb * wy)
        dz = 1.0 / max(0.1, 1.0 + curvature * cc * wz)
        rx, ry, rz = px - qx - multiplier * gx, py - qy - multiplier * gy, pz - qz - multiplier * gz
        change = (gx * rx * dx + gy * ry * dy + gz * rz * dz) / (gx * gx * dx + gy * gy * dy + gz * gz * dz)
        sx, sy, sz = (rx - gx * change) * dx, (ry - gy * change) * dy, (rz - gz * change) * dz
        # Steps are shortened to stay near the surface, where the quadratic model holds.
        step = abs(sx) + abs(sy) + abs(sz)
        shrink = min(1.0, 0.3 * min(a, b, c) / step) if step > 0.0 else 1.0
        sx, sy, sz = max(-qx, shrink * sx), max(-qy, shrink * sy), max(-qz, shrink * sz)
        wx = _power_after(wx, qx, sx, a, exponent)
        wy = _power_after(wy, qy, sy, b, exponent)
        wz = _power_after(wz, qz, sz, c, exponent)
        _, qx, qy, qz, wx, wy, wz = _onto_surface(qx + sx, qy + sy, qz + sz, wx, wy, wz, aa, bb, cc, degree)
        gx, gy, gz = degree * aa * wx * qx, degree * bb * wy * qy, degree * cc * wz * qz
        multiplier = ((px - qx) * gx + (py - qy) * gy + (pz - qz) * gz) / (gx * gx + gy * gy + gz * gz)
        if shrink == 1.0 and step < tolerance:
            break
    length = math.sqrt(gx * gx + gy * gy + gz * gz)
    qx, qy, qz = _sign(x) * qx, _sign(y) * qy, _sign(z) * qz
    return measure, qx, qy, qz, _sign(x) * gx / length, _sign(y) * gy / length, _sign(z) * gz / length


@scalar
def _onto_surface(x, y, z, wx, wy, wz, aa, bb, cc, degree):
    """Radial projection of a point of the first octant: its share of the way from the centre, 1/G; the point; and
    (q/a)^(n-2) there for each axis, from those of the point before, wx to wz. aa to cc: 1/a^2 to 1/c^2 [1/m^2].

    Powers are what a closest point costs, so none is taken twice: slopes and curvatures follow from these three.
    """
    value = wx * aa * x * x + wy * bb * y * y + wz * cc * z * z
    if degree == 2.0:
        back = 1.0 / math.sqrt(value)
    elif abs(value - 1.0) < SHORT:
        back = _power_near_one(value - 1.0, -1.0 / degree)
    else:
        back = value ** (-1.0 / degree)
    scale = 1.0 / (value * back * back)
    return back, back * x, back * y, back * z, scale * wx, scale * wy, scale * wz


@scalar
def _power_after(power, q, change, radius, exponent):
    """((q + change) / radius)^exponent, where power is (q / radius)^exponent."""
    if exponent == 0.0:
        return 1.0
    if abs(change) < SHORT * q:
        return power * _power_near_one(change / q, exponent)
    return ((q + change) / radius) ** exponent


@scalar
def _power_near_one(d, p):
    """(1 + d)^p for |d| below SHORT to rounding, by the binomial series: a fifth of the time of a power."""
    total, term = 1.0, 1.0
    for k in range(8):
        term *= (p - k) * (d / (k + 1.0))
        total += term
        if abs(term) < 1e-17:
            break
    return total


@scalar
def _sign(value):
    return -1.0 if value < 0.0 else 1.0
