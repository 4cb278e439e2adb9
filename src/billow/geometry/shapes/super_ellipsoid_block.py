"""Closest points of a super-ellipsoid for many points at once, without branches, so that loops become vector
instructions: the search of `super_ellipsoid`, with the same answers but for rounding."""

from __future__ import annotations

import math

from billow.base.compiled import scalar, spliced
from billow.geometry.power import SMALLEST, power
from billow.geometry.shapes.super_ellipsoid import NEWTON_STEPS

BLOCK = 32
"""Points that are looked at together."""

# fmt: off
(
    X, Y, Z,  # points in the axes of the shape [m]
    REACH,  # farthest that a point may be from the surface to count [m]
    COUNTS,  # 1 for points to be looked at, and then for those within reach; 0 for others
    DEPTH, MX, MY, MZ,  # answers of those that count: depth [m], negative outside, and outward unit normal
    PX, PY, PZ, QX, QY, QZ, GX, GY, GZ, UX, UY, UZ, ALONG, OPEN,  # the search in the first octant
) = (BLOCK * row for row in range(23))
ROWS = 23
# fmt: on


@scalar
def near_points(block, numbers):
    """Fill the rows COUNTS to MZ from X to COUNTS, for the numbers of a `SuperEllipsoid`."""
    a, b, c, degree, _ = numbers
    smallest = a if a < b else b
    smallest = smallest if smallest < c else c
    if degree == 2.0 and a == b and b == c:
        for j in range(BLOCK):
            x, y, z = block[X + j], block[Y + j], block[Z + j]
            square = x * x + y * y + z * z
            z = z if square > 0.0 else 1e-12 * c
            away = math.sqrt(x * x + y * y + z * z)
            block[DEPTH + j] = a - away
            block[MX + j], block[MY + j], block[MZ + j] = x / away, y / away, z / away
            block[COUNTS + j] = block[COUNTS + j] if away < a + block[REACH + j] else 0.0
        return
    largest = a if a > b else b
    largest = largest if largest > c else c
    exponent, root = degree - 2.0, -1.0 / degree
    per_a, per_b, per_c = 1.0 / a, 1.0 / b, 1.0 / c
    # Slopes of the surface are u q, with u = n/a^2 (q/a)^(n-2).
    na, nb, nc = degree * per_a * per_a, degree * per_b * per_b, degree * per_c * per_c
    longest = 0.3 * smallest  # steps are shortened to stay near the surface, where the quadratic model holds
    tolerance = 1e-4 * largest  # Newton doubles its digits: the next step would be of the order of 1e-8
    for j in range(BLOCK):  # the radial projection, from which the search begins
        px, py, pz = abs(block[X + j]), abs(block[Y + j]), abs(block[Z + j])
        pz = pz if px + py + pz > 1e-12 * largest else 1e-12 * c
        qx, qy, qz, ux, uy, uz, back = _onto_surface(
            px, py, pz, per_a, per_b, per_c, na, nb, nc, exponent, degree, root
        )
        gx, gy, gz = ux * qx, uy * qy, uz * qz
        block[PX + j], block[PY + j], block[PZ + j] = px, py, pz
        block[QX + j], block[QY + j], block[QZ + j] = qx, qy, qz
        block[UX + j], block[UY + j], block[UZ + j] = ux, uy, uz
        block[GX + j], block[GY + j], block[GZ + j] = gx, gy, gz
        block[ALONG + j] = ((px - qx) * gx + (py - qy) * gy + (pz - qz) * gz) / (gx * gx + gy * gy + gz * gz)
        # G - 1 times the smallest radius is at most the distance, as in `near_super_ellipsoid`.
        block[COUNTS + j] = block[COUNTS + j] if 1.0 / back < 1.0 + block[REACH + j] / smallest else 0.0
        block[OPEN + j] = block[COUNTS + j]
    for _ in range(NEWTON_STEPS):
        remaining = 0
        for j in range(BLOCK):
            remaining += 1 if block[OPEN + j] > 0.0 else 0
        if remaining == 0:
            break
        for j in range(BLOCK):
            px, py, pz, along = block[PX + j], block[PY + j], block[PZ + j], block[ALONG + j]
            qx, qy, qz = block[QX + j], block[QY + j], block[QZ + j]
            gx, gy, gz = block[GX + j], block[GY + j], block[GZ + j]
            curved = along * (degree - 1.0)
            dx, dy, dz = 1.0 + curved * block[UX + j], 1.0 + curved * block[UY + j], 1.0 + curved * block[UZ + j]
            dx, dy, dz = (dx if dx > 0.1 else 0.1), (dy if dy > 0.1 else 0.1), (dz if dz > 0.1 else 0.1)
            dx, dy, dz = 1.0 / dx, 1.0 / dy, 1.0 / dz
            rx, ry, rz = px - qx - along * gx, py - qy - along * gy, pz - qz - along * gz
            change = (gx * rx * dx + gy * ry * dy + gz * rz * dz) / (gx * gx * dx + gy * gy * dy + gz * gz * dz)
            sx, sy, sz = (rx - gx * change) * dx, (ry - gy * change) * dy, (rz - gz * change) * dz
            step = abs(sx) + abs(sy) + abs(sz)
            shrink = longest / (step if step > longest else longest)
            sx, sy, sz = shrink * sx, shrink * sy, shrink * sz
            sx, sy, sz = (sx if sx > -qx else -qx), (sy if sy > -qy else -qy), (sz if sz > -qz else -qz)
            qx, qy, qz, ux, uy, uz, _ = _onto_surface(
                qx + sx, qy + sy, qz + sz, per_a, per_b, per_c, na, nb, nc, exponent, degree, root
            )
            gx, gy, gz = ux * qx, uy * qy, uz * qz
            along = ((px - qx) * gx + (py - qy) * gy + (pz - qz) * gz) / (gx * gx + gy * gy + gz * gz)
            is_open = block[OPEN + j] > 0.0
            block[QX + j] = qx if is_open else block[QX + j]
            block[QY + j] = qy if is_open else block[QY + j]
            block[QZ + j] = qz if is_open else block[QZ + j]
            block[UX + j] = ux if is_open else block[UX + j]
            block[UY + j] = uy if is_open else block[UY + j]
            block[UZ + j] = uz if is_open else block[UZ + j]
            block[GX + j] = gx if is_open else block[GX + j]
            block[GY + j] = gy if is_open else block[GY + j]
            block[GZ + j] = gz if is_open else block[GZ + j]
            block[ALONG + j] = along if is_open else block[ALONG + j]
            block[OPEN + j] = block[OPEN + j] if step >= tolerance else 0.0
    for j in range(BLOCK):
        gx, gy, gz = block[GX + j], block[GY + j], block[GZ + j]
        length = math.sqrt(gx * gx + gy * gy + gz * gz)
        mx, my, mz = gx / length, gy / length, gz / length
        px, py, pz = block[PX + j], block[PY + j], block[PZ + j]
        block[DEPTH + j] = (block[QX + j] - px) * mx + (block[QY + j] - py) * my + (block[QZ + j] - pz) * mz
        block[MX + j] = -mx if block[X + j] < 0.0 else mx
        block[MY + j] = -my if block[Y + j] < 0.0 else my
        block[MZ + j] = -mz if block[Z + j] < 0.0 else mz


@spliced
def _onto_surface(x, y, z, per_a, per_b, per_c, na, nb, nc, exponent, degree, root):
    """Radial projection q of a point of the first octant, u of each axis there, and its share of the way from the
    centre, 1/G. per_a: 1/a [1/m]; na: n/a^2 [1/m^2], and so on; exponent: n - 2; root: -1/n."""
    fx, fy, fz = x * per_a, y * per_b, z * per_c
    fx, fy, fz = fx if fx > SMALLEST else SMALLEST, fy if fy > SMALLEST else SMALLEST, fz if fz > SMALLEST else SMALLEST
    ux, uy, uz = na * power(fx, exponent), nb * power(fy, exponent), nc * power(fz, exponent)
    value = (ux * x * x + uy * y * y + uz * z * z) / degree  # G^n
    back = power(value if value > SMALLEST else SMALLEST, root)
    scale = 1.0 / (value * back * back)
    return back * x, back * y, back * z, scale * ux, scale * uy, scale * uz, back
