"""Where two convex shapes touch, or would (docs/theory.md, Obstacles that meet).

Scaled by a common factor t about their centres, two bodies just touch for one t: below 1 if they overlap. With their
reach h(d) in a direction d (support function) and their centres c apart, t = c.d / (h_a(d) + h_b(-d)) for the normal d
at which they touch, which makes this the largest: h_a + h_b is smallest on the plane c.d = 1, a convex problem in two
unknowns.
"""

from __future__ import annotations

import math

from billow.base.compiled import scalar
from billow.geometry.shapes.kinds import farthest
from billow.geometry.shapes.pose import into_axes, into_space
from billow.geometry.triangle import cross

MOST_STEPS, FLAT = 100, 1e-12
"""Steps of the search, and the relative slope at which it ends."""

NUDGE = 1e-6
"""Of a direction, relative to its length."""


@scalar
def farthest_in_space(kind, numbers, pose, dx, dy, dz):
    """The farthest point of a shape in a direction of space, from its centre [m]: three numbers. numbers and pose:
    tuples, as `Shape` says."""
    x, y, z = into_axes(pose, dx, dy, dz)
    x, y, z = farthest(kind, numbers, x, y, z)
    return into_space(pose, x, y, z)


@scalar
def touch(kind_a, numbers_a, pose_a, kind_b, numbers_b, pose_b, cx, cy, cz):
    """Two convex shapes with ends, the centre of the second c [m] from that of the first: unit normal from the first to
    the second, the span of both along it [m], of which c . normal is the part t, and the place where they touch, from
    the centre of the first [m]: seven numbers.

    They overlap along the normal by span - c . normal: exactly for balls, and for any shapes in the limit of a small
    overlap.
    """
    size = math.sqrt(cx * cx + cy * cy + cz * cz)
    if size < 1e-12:  # one within the other: any direction will do
        cx, cy, cz, size = 0.0, 0.0, 1e-12, 1e-12
    ax, ay, az = cx / size, cy / size, cz / size
    if abs(ax) <= min(abs(ay), abs(az)):
        ux, uy, uz = cross(ax, ay, az, 1.0, 0.0, 0.0)
    elif abs(ay) <= abs(az):
        ux, uy, uz = cross(ax, ay, az, 0.0, 1.0, 0.0)
    else:
        ux, uy, uz = cross(ax, ay, az, 0.0, 0.0, 1.0)
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / length, uy / length, uz / length
    vx, vy, vz = cross(ax, ay, az, ux, uy, uz)

    # BFGS from the line between the centres, direction = a + p u + q v; steps are halved until they go down.
    p, q, sp, sq, share, value = 0.0, 0.0, 0.0, 0.0, 1.0, math.inf
    gp, gq, hpp, hpq, hqq = 0.0, 0.0, 0.0, 0.0, 0.0
    first = True
    dx = dy = dz = px = py = pz = ox = oy = oz = 0.0
    for _ in range(20 * MOST_STEPS):
        at_p, at_q = p + sp, q + sq
        dx, dy, dz = ax + at_p * ux + at_q * vx, ay + at_p * uy + at_q * vy, az + at_p * uz + at_q * vz
        px, py, pz = farthest_in_space(kind_a, numbers_a, pose_a, dx, dy, dz)
        ox, oy, oz = farthest_in_space(kind_b, numbers_b, pose_b, -dx, -dy, -dz)
        bx, by, bz = px - ox, py - oy, pz - oz
        new = bx * dx + by * dy + bz * dz
        if not first and new > value * (1.0 + 1e-15) + 1e-4 * (gp * sp + gq * sq) and share > 1e-9:
            share, sp, sq = 0.5 * share, 0.5 * sp, 0.5 * sq
            continue
        steep = max(abs(gp), abs(gq))
        yp, yq = bx * ux + by * uy + bz * uz - gp, bx * vx + by * vy + bz * vz - gq
        p, q, gp, gq = p + sp, q + sq, gp + yp, gq + yq
        curved = sp * yp + sq * yq
        if first:
            hpp = hqq = 1.0 / new
        elif curved > 0.0:  # H' = (1 - s y'/y's) H (1 - y s'/y's) + s s'/y's
            hp, hq = hpp * yp + hpq * yq, hpq * yp + hqq * yq
            more = (1.0 + (yp * hp + yq * hq) / curved) / curved
            hpp += more * sp * sp - 2.0 * sp * hp / curved
            hpq += more * sp * sq - (sp * hq + sq * hp) / curved
            hqq += more * sq * sq - 2.0 * sq * hq / curved
        now = max(abs(gp), abs(gq))  # near the end the slope still falls where the value is flat to rounding
        over = now <= FLAT * new or (abs(new - value) <= 1e-15 * new and now >= 0.5 * steep)
        first, value = False, new
        if over:
            break
        sp, sq, share = -(hpp * gp + hpq * gq), -(hpq * gp + hqq * gq), 1.0
    # Both shapes have the place on their surface. On a side that is nearly flat it hardly depends on the normal, and is
    # found badly from it: the shape whose farthest point moves less when the normal is nudged counts more.
    firm_a = _firmness(kind_a, numbers_a, pose_a, dx, dy, dz, px, py, pz, ux, uy, uz, vx, vy, vz)
    firm_b = _firmness(kind_b, numbers_b, pose_b, -dx, -dy, -dz, ox, oy, oz, ux, uy, uz, vx, vy, vz)
    length, scale, share = math.sqrt(dx * dx + dy * dy + dz * dz), size / value, firm_a / (firm_a + firm_b)
    x = share * scale * px + (1.0 - share) * (cx + scale * ox)
    y = share * scale * py + (1.0 - share) * (cy + scale * oy)
    z = share * scale * pz + (1.0 - share) * (cz + scale * oz)
    return dx / length, dy / length, dz / length, value / length, x, y, z


@scalar
def _firmness(kind, numbers, pose, dx, dy, dz, x, y, z, ux, uy, uz, vx, vy, vz):
    """How little the farthest point (x, y, z) in direction d moves when d is nudged along u and v."""
    moves = 0.0
    for sign in (NUDGE, -NUDGE):
        qx, qy, qz = farthest_in_space(kind, numbers, pose, dx + sign * ux, dy + sign * uy, dz + sign * uz)
        moves += (qx - x) ** 2 + (qy - y) ** 2 + (qz - z) ** 2
        qx, qy, qz = farthest_in_space(kind, numbers, pose, dx + sign * vx, dy + sign * vy, dz + sign * vz)
        moves += (qx - x) ** 2 + (qy - y) ** 2 + (qz - z) ** 2
    return 1.0 / max(moves, 1e-300)
