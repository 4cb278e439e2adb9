"""Super-ellipsoid |x/a|^n + |y/b|^n + |z/c|^n = 1: inside test, closest point, volume and inertia.

Points are given in the body's own axes, relative to its centre. The shape is symmetric, so all work is done in the
first octant.
"""

from __future__ import annotations

from math import gamma

import numpy as np

from billow.base.compiled import scalar

NEWTON_STEPS = 40


def volume(radii: np.ndarray, degree: float) -> float:
    """Volume [m^3]: 8abc Gamma(1+1/n)^3 / Gamma(1+3/n)."""
    return float(8.0 * np.prod(radii) * gamma(1.0 + 1.0 / degree) ** 3 / gamma(1.0 + 3.0 / degree))


def principal_inertia(mass: float, radii: np.ndarray, degree: float) -> np.ndarray:
    """Moments of inertia [kg m^2], (3,), of a solid of uniform density and mass [kg].

    Ixx = m (b^2 + c^2) k with k = Gamma(3/n) Gamma(1+3/n) / (Gamma(1/n) Gamma(1+5/n)); k = 1/5 for an ellipsoid.
    """
    n = degree
    k = gamma(3.0 / n) * gamma(1.0 + 3.0 / n) / (gamma(1.0 / n) * gamma(1.0 + 5.0 / n))
    square = np.asarray(radii) ** 2
    return mass * k * (square.sum() - square)


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
    qx, qy, qz, wx, wy, wz = _onto_surface(px, py, pz, a, b, c, degree)
    gx, gy, gz = degree / (a * a) * wx * qx, degree / (b * b) * wy * qy, degree / (c * c) * wz * qz
    multiplier = ((px - qx) * gx + (py - qy) * gy + (pz - qz) * gz) / (gx * gx + gy * gy + gz * gz)
    tolerance = 1e-6 * max(a, b, c)  # Newton doubles its digits: the next step would be of the order of 1e-12
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
    length = np.sqrt(gx * gx + gy * gy + gz * gz)
    flip_x, flip_y, flip_z = _sign(x), _sign(y), _sign(z)
    return (
        flip_x * qx, flip_y * qy, flip_z * qz,
        flip_x * gx / length, flip_y * gy / length, flip_z * gz / length,
    )  # fmt: skip


@scalar
def _onto_surface(x, y, z, a, b, c, degree):
    """Radial projection (x, y, z) of a point of the first octant, and (q/a)^(n-2) there for each axis.

    Powers are what a closest point costs, so none is taken twice: slopes and curvatures follow from these three.
    """
    ux, uy, uz = x / a, y / b, z / c
    wx, wy, wz = ux ** (degree - 2.0), uy ** (degree - 2.0), uz ** (degree - 2.0)
    value = wx * ux * ux + wy * uy * uy + wz * uz * uz
    back = value ** (-1.0 / degree)
    scale = 1.0 / (value * back * back)
    return back * x, back * y, back * z, scale * wx, scale * wy, scale * wz


@scalar
def _sign(value):
    return -1.0 if value < 0.0 else 1.0
