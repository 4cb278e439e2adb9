"""Closest points of many pairs at once: nodes and triangles, or two segments, in blocks, without branches.

Which part of a triangle is closest cannot be foreseen, and a wrong guess costs a processor more than all the sums. So
every part is looked at, and the nearest taken; loops of that kind become vector instructions. Same results as
`closest_points`, but for rounding.
"""

from __future__ import annotations

from billow.base.compiled import inlined
from billow.geometry.closest_points import PARALLEL

BLOCK = 32
"""Pairs that are looked at together."""

AX, AY, AZ, BX, BY, BZ, CX, CY, CZ, DX, DY, DZ = (BLOCK * row for row in range(12))
"""Rows of a block: places of the four nodes [m]."""

S, T, X, Y, Z, SQUARE = (BLOCK * row for row in range(12, 18))
"""Rows of the answers: as `on_triangle` and `of_segments`, and the square of the distance [m^2]."""

ROWS = 18

TINY = 1e-300
"""Instead of a length of zero, by which nothing can be divided."""


@inlined
def fill(block, j, positions, a, b, c, d):
    """Column j of a block: four nodes."""
    block[AX + j], block[AY + j], block[AZ + j] = positions[a, 0], positions[a, 1], positions[a, 2]
    block[BX + j], block[BY + j], block[BZ + j] = positions[b, 0], positions[b, 1], positions[b, 2]
    block[CX + j], block[CY + j], block[CZ + j] = positions[c, 0], positions[c, 1], positions[c, 2]
    block[DX + j], block[DY + j], block[DZ + j] = positions[d, 0], positions[d, 1], positions[d, 2]


@inlined
def nodes_on_triangles(block):
    """Answers for nodes a and triangles b, c, d: S and T are the area coordinates of c and d."""
    for j in range(BLOCK):
        ux, uy, uz = block[CX + j] - block[BX + j], block[CY + j] - block[BY + j], block[CZ + j] - block[BZ + j]
        vx, vy, vz = block[DX + j] - block[BX + j], block[DY + j] - block[BY + j], block[DZ + j] - block[BZ + j]
        qx, qy, qz = block[AX + j] - block[BX + j], block[AY + j] - block[BY + j], block[AZ + j] - block[BZ + j]
        wx, wy, wz, rx, ry, rz = vx - ux, vy - uy, vz - uz, qx - ux, qy - uy, qz - uz
        uu, vv, uv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, ux * vx + uy * vy + uz * vz
        ww, rw = wx * wx + wy * wy + wz * wz, rx * wx + ry * wy + rz * wz
        uq, vq = ux * qx + uy * qy + uz * qz, vx * qx + vy * qy + vz * qz
        # The three sides.
        s = uq / (uu if uu > TINY else TINY)
        t = vq / (vv if vv > TINY else TINY)
        w = rw / (ww if ww > TINY else TINY)
        s = s if s > 0.0 else 0.0
        s = s if s < 1.0 else 1.0
        t = t if t > 0.0 else 0.0
        t = t if t < 1.0 else 1.0
        w = w if w > 0.0 else 0.0
        w = w if w < 1.0 else 1.0
        x, y, z = qx - s * ux, qy - s * uy, qz - s * uz
        mx, my, mz = qx - t * vx, qy - t * vy, qz - t * vz
        kx, ky, kz = rx - w * wx, ry - w * wy, rz - w * wz
        least, second, third = x * x + y * y + z * z, mx * mx + my * my + mz * mz, kx * kx + ky * ky + kz * kz
        nearer = second < least
        least = second if nearer else least
        x, y, z = (mx if nearer else x), (my if nearer else y), (mz if nearer else z)
        s, t = (0.0 if nearer else s), (t if nearer else 0.0)
        nearer = third < least
        least = third if nearer else least
        x, y, z = (kx if nearer else x), (ky if nearer else y), (kz if nearer else z)
        s, t = (1.0 - w if nearer else s), (w if nearer else t)
        # Its inside.
        whole = uu * vv - uv * uv
        per = 1.0 / (whole if whole > TINY else TINY)
        si, ti = (vv * uq - uv * vq) * per, (uu * vq - uv * uq) * per
        within = (si > 0.0) & (ti > 0.0) & (si + ti < 1.0) & (whole > PARALLEL * uu * vv)
        mx, my, mz = qx - si * ux - ti * vx, qy - si * uy - ti * vy, qz - si * uz - ti * vz
        x, y, z = (mx if within else x), (my if within else y), (mz if within else z)
        block[S + j], block[T + j] = (si if within else s), (ti if within else t)
        block[X + j], block[Y + j], block[Z + j] = x, y, z
        block[SQUARE + j] = x * x + y * y + z * z


@inlined
def segments_on_segments(block):
    """Answers for segments a, b and c, d: S and T are the shares of the way along them."""
    for j in range(BLOCK):
        ux, uy, uz = block[BX + j] - block[AX + j], block[BY + j] - block[AY + j], block[BZ + j] - block[AZ + j]
        vx, vy, vz = block[DX + j] - block[CX + j], block[DY + j] - block[CY + j], block[DZ + j] - block[CZ + j]
        rx, ry, rz = block[AX + j] - block[CX + j], block[AY + j] - block[CY + j], block[AZ + j] - block[CZ + j]
        uu, vv, uv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, ux * vx + uy * vy + uz * vz
        ur, vr = ux * rx + uy * ry + uz * rz, vx * rx + vy * ry + vz * rz
        per_u, per_v = 1.0 / (uu if uu > TINY else TINY), 1.0 / (vv if vv > TINY else TINY)
        square = uu * vv - uv * uv
        s = (uv * vr - ur * vv) / (square if square > TINY else TINY)
        s = s if s > 0.0 else 0.0
        s = s if s < 1.0 else 1.0
        s = s if square > PARALLEL * uu * vv else 0.0
        t = (uv * s + vr) * per_v
        inside = (t >= 0.0) & (t <= 1.0)
        t = t if t > 0.0 else 0.0
        t = t if t < 1.0 else 1.0
        m = (uv * t - ur) * per_u
        m = m if m > 0.0 else 0.0
        m = m if m < 1.0 else 1.0
        s = s if inside else m
        x, y, z = rx + s * ux - t * vx, ry + s * uy - t * vy, rz + s * uz - t * vz
        block[S + j], block[T + j] = s, t
        block[X + j], block[Y + j], block[Z + j] = x, y, z
        block[SQUARE + j] = x * x + y * y + z * z
