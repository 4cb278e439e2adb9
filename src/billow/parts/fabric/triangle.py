"""One membrane triangle as kernels see it: how it is deformed, and what its stress does to its corners.

Every law's kernel calls these functions in this order: `along` twice, `products`, the law's own stress,
`stretch_bound`, `add_corner_forces`. The axes are warp and weft, which need not be at right angles.
"""

from __future__ import annotations

from billow.base.compiled import scalar


@scalar
def along(field, a, b, c, d11, d12, d21, d22):
    """Derivatives of a nodal field (nodes, 3) along warp and weft, (f1x, f1y, f1z, f2x, f2y, f2z).

    a, b, c: nodes of the triangle; d: inverse of its flat edges [1/m]. Of positions these are the columns of the
    deformation gradient F = [x1 - x0, x2 - x0] Dm^-1 [-], of velocities those of its rate [1/s].
    """
    ux, uy, uz = field[b, 0] - field[a, 0], field[b, 1] - field[a, 1], field[b, 2] - field[a, 2]
    wx, wy, wz = field[c, 0] - field[a, 0], field[c, 1] - field[a, 1], field[c, 2] - field[a, 2]
    return (
        ux * d11 + wx * d21, uy * d11 + wy * d21, uz * d11 + wz * d21,
        ux * d12 + wx * d22, uy * d12 + wy * d22, uz * d12 + wz * d22,
    )  # fmt: skip


@scalar
def products(f, g):
    """(F^T F)_11, _22 and _12 [-], then the rates of Green strain E_11, E_22 and E_12 [1/s].

    f, g: columns of the deformation gradient and of its rate, as `along` returns them.
    """
    ax, ay, az, bx, by, bz = f
    gax, gay, gaz, gbx, gby, gbz = g
    return (
        ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, ax * bx + ay * by + az * bz,
        ax * gax + ay * gay + az * gaz, bx * gbx + by * gby + bz * gbz,
        0.5 * (ax * gbx + ay * gby + az * gbz + bx * gax + by * gay + bz * gaz),
    )  # fmt: skip


@scalar
def stretch_bound(aa, bb, ab, cot, csc):
    """Gershgorin's bound of the largest squared stretch [-]; aa, bb, ab: of `products`; cot, csc: cotangent and
    cosecant of the angle between the yarns in the flat cut."""
    if cot == 0.0:
        return max(aa, bb) + abs(ab)
    c12 = csc * ab - cot * aa
    return max(aa, csc * csc * bb - 2.0 * csc * cot * ab + cot * cot * aa) + abs(c12)


@scalar
def add_corner_forces(corner_force, t, v, f, s11, s22, s12, d11, d12, d21, d22):
    """Add -v P Dm^-T [N] with P = F S to the corners of triangle t; f: columns of F; s: stress [Pa]; v: volume."""
    f1x, f1y, f1z, f2x, f2y, f2z = f
    p1x, p1y, p1z = f1x * s11 + f2x * s12, f1y * s11 + f2y * s12, f1z * s11 + f2z * s12
    p2x, p2y, p2z = f1x * s12 + f2x * s22, f1y * s12 + f2y * s22, f1z * s12 + f2z * s22
    bx, by, bz = v * (p1x * d11 + p2x * d12), v * (p1y * d11 + p2y * d12), v * (p1z * d11 + p2z * d12)
    cx, cy, cz = v * (p1x * d21 + p2x * d22), v * (p1y * d21 + p2y * d22), v * (p1z * d21 + p2z * d22)
    corner_force[t, 0, 0] += bx + cx
    corner_force[t, 0, 1] += by + cy
    corner_force[t, 0, 2] += bz + cz
    corner_force[t, 1, 0] -= bx
    corner_force[t, 1, 1] -= by
    corner_force[t, 1, 2] -= bz
    corner_force[t, 2, 0] -= cx
    corner_force[t, 2, 1] -= cy
    corner_force[t, 2, 2] -= cz
