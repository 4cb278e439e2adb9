"""Closest points of a point and a triangle, and of two segments (Ericson, Real-Time Collision Detection, 2005, 5.1)."""

from __future__ import annotations

from billow.base.compiled import scalar

PARALLEL = 1e-10
"""Square of the sine of the angle between two segments below which they count as parallel."""


@scalar
def on_triangle(px, py, pz, ax, ay, az, bx, by, bz, cx, cy, cz):
    """Area coordinates of b and c of the point of the triangle a, b, c that is closest to p, and the way from there to
    p [m]: (second, third, x, y, z)."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    qx, qy, qz = px - ax, py - ay, pz - az
    d1, d2 = ux * qx + uy * qy + uz * qz, vx * qx + vy * qy + vz * qz
    if d1 <= 0.0 and d2 <= 0.0:
        return 0.0, 0.0, qx, qy, qz
    rx, ry, rz = px - bx, py - by, pz - bz
    d3, d4 = ux * rx + uy * ry + uz * rz, vx * rx + vy * ry + vz * rz
    if d3 >= 0.0 and d4 <= d3:
        return 1.0, 0.0, rx, ry, rz
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0 and d1 > d3:
        s = d1 / (d1 - d3)
        return s, 0.0, qx - s * ux, qy - s * uy, qz - s * uz
    sx, sy, sz = px - cx, py - cy, pz - cz
    d5, d6 = ux * sx + uy * sy + uz * sz, vx * sx + vy * sy + vz * sz
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 1.0, sx, sy, sz
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0 and d2 > d6:
        t = d2 / (d2 - d6)
        return 0.0, t, qx - t * vx, qy - t * vy, qz - t * vz
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0 and (d4 - d3) + (d5 - d6) > 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 1.0 - t, t, rx - t * (cx - bx), ry - t * (cy - by), rz - t * (cz - bz)
    whole = va + vb + vc
    uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    if not whole > PARALLEL * uu * vv:  # a triangle without area: its sides are all there is
        s = min(1.0, max(0.0, d1 / uu)) if uu > 0.0 else 0.0
        t = min(1.0, max(0.0, d2 / vv)) if vv > 0.0 else 0.0
        wx, wy, wz = cx - bx, cy - by, cz - bz
        ww = wx * wx + wy * wy + wz * wz
        r = min(1.0, max(0.0, (rx * wx + ry * wy + rz * wz) / ww)) if ww > 0.0 else 0.0
        ox, oy, oz = qx - s * ux, qy - s * uy, qz - s * uz
        kx, ky, kz = qx - t * vx, qy - t * vy, qz - t * vz
        mx, my, mz = rx - r * wx, ry - r * wy, rz - r * wz
        first, second = ox * ox + oy * oy + oz * oz, kx * kx + ky * ky + kz * kz
        third = mx * mx + my * my + mz * mz
        if first <= second and first <= third:
            return s, 0.0, ox, oy, oz
        if second <= third:
            return 0.0, t, kx, ky, kz
        return 1.0 - r, r, mx, my, mz
    s, t = vb / whole, vc / whole
    return s, t, qx - s * ux - t * vx, qy - s * uy - t * vy, qz - s * uz - t * vz


@scalar
def of_segments(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz):
    """Shares of the way from a to b and from c to d at the closest points of two segments, and the way from the second
    point to the first [m]: (s, t, x, y, z)."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = dx - cx, dy - cy, dz - cz
    rx, ry, rz = ax - cx, ay - cy, az - cz
    uu, vv, uv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, ux * vx + uy * vy + uz * vz
    ur, vr = ux * rx + uy * ry + uz * rz, vx * rx + vy * ry + vz * rz
    square = uu * vv - uv * uv
    s = 0.0
    if square > PARALLEL * uu * vv:
        s = min(1.0, max(0.0, (uv * vr - ur * vv) / square))
    t = (uv * s + vr) / vv if vv > 0.0 else 0.0
    if t < 0.0:
        t = 0.0
        s = min(1.0, max(0.0, -ur / uu)) if uu > 0.0 else 0.0
    elif t > 1.0:
        t = 1.0
        s = min(1.0, max(0.0, (uv - ur) / uu)) if uu > 0.0 else 0.0
    return s, t, rx + s * ux - t * vx, ry + s * uy - t * vy, rz + s * uz - t * vz
