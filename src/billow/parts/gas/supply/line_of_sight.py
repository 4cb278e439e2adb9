"""What jets from a ring of holes fall on: the fabric in line of sight (docs/theory.md, Jets).

Seen from its hole, a point has lateral over axial coordinates (u, v) and nearness 1/axial. A line of sight is one point
(u, v), so hiding is a test of plane triangles. What may be lit is sorted into squares of (u, v); what may hide only
looks at the squares it lies over.
"""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.triangle import cross, double_area_vector

REACH = 1.5
"""Radius of the footprint in radii of the Gaussian; 99 % of the momentum flux lies within (1 - e^-4.5)."""

SQUARES, WIDEST = 24, 0.2
"""Squares along each axis, from -WIDEST to WIDEST (lateral over axial distance)."""

NO_WALLS = np.empty(0, np.int64), np.empty(0, np.bool_)
"""Walls and which of them are reversed, where all triangles are walls with normals outwards."""

WIDTH, HEIGHT, NEARNESS, WEIGHT, THRUST = range(5)
"""Columns of what may be lit: u, v, 1/axial [1/m], pressure over that on the axis of the jet at its hole [-], and the
part of the area vector along the jet [m^2]."""


@scalar
def lit_triangles(triangles, walls, turned_round, positions, holes, frames, ring, diameter):
    """Triangles (n,) int64 that the jets fall on, pressure per thrust of one jet [1/m^2] on each, (n,), negative where
    its normal points into the chamber, and the number of jets that see fabric.

    triangles: (all, 3). walls: (m,) int64, those around the chamber, and turned_round: (m,) bool, those whose normals
    point into it; NO_WALLS for all, outwards. positions: [m], (nodes, 3). holes, frames, ring: as `Jets.nozzles`.
    diameter: of the holes [m].
    """
    jets = len(holes)
    lit, of_lit, jet_of_lit, screens, jet_of_screen = sort_out(
        triangles, walls, turned_round, positions, holes, frames, ring, diameter
    )
    hide(of_lit, jet_of_lit, screens, jet_of_screen, jets)
    # Their thrust is along the axis of the jet.
    along, n = np.zeros(jets), 0
    for m in range(len(lit)):
        if of_lit[m, WEIGHT] > 0.0:
            along[jet_of_lit[m]] += 0.5 * of_lit[m, WEIGHT] * of_lit[m, THRUST]
            n += 1
    found, share, seen = np.empty(n, np.int64), np.empty(n), 0
    n = 0
    for m in range(len(lit)):
        if of_lit[m, WEIGHT] > 0.0:
            w, k = lit[m], jet_of_lit[m]
            found[n] = walls[w] if len(walls) > 0 else w
            share[n] = of_lit[m, WEIGHT] / along[k]
            if len(walls) > 0 and turned_round[w]:
                share[n] = -share[n]
            n += 1
    for k in range(jets):
        seen += along[k] > 0.0
    return found, share, seen


@scalar
def _doubled(rows):
    """The same rows with room for as many more."""
    more = np.empty((2 * len(rows), rows.shape[1]), rows.dtype)
    more[: len(rows)] = rows
    return more


@scalar
def sort_out(triangles, walls, turned_round, positions, holes, frames, ring, diameter):
    """What may be lit and what may hide it.

    Returns the walls (lit,) int64 that a jet would fall on if nothing hid them, what there is to know of them, (lit,
    5), and their jets, (lit,) int64; and of walls seen from outside the projected corners and their nearness, u, v, n
    of each, (screens, 9), and their jets, (screens,) int64.
    """
    jets, n = len(holes), len(walls) if len(walls) > 0 else len(triangles)
    pitch = 2.0 * math.pi / jets
    cx, cy, cz = 0.0, 0.0, 0.0
    for k in range(jets):
        cx, cy, cz = cx + holes[k, 0], cy + holes[k, 1], cz + holes[k, 2]
    cx, cy, cz = cx / jets, cy / jets, cz / jets
    ox, oy, oz = holes[0, 0] - cx, holes[0, 1] - cy, holes[0, 2] - cz
    radius_of_ring = math.sqrt(ox * ox + oy * oy + oz * oz)
    rise = frames[0, 0, 0] * ring[0, 0] + frames[0, 0, 1] * ring[0, 1] + frames[0, 0, 2] * ring[0, 2]
    lean = math.sqrt(max(0.0, 1.0 - rise * rise))
    upx, upy, upz = ring[0, 0], ring[0, 1], ring[0, 2]
    lit, of_lit, lights = np.empty((256, 2), np.int64), np.empty((256, 5)), 0
    screens, jet_of_screen, hides = np.empty((256, 9)), np.empty((256, 1), np.int64), 0
    for w in range(n):
        i = walls[w] if len(walls) > 0 else w
        a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
        if len(walls) > 0 and turned_round[w]:
            a, c = c, a
        ax, ay, az = positions[a, 0] - cx, positions[a, 1] - cy, positions[a, 2] - cz
        bx, by, bz = positions[b, 0] - cx, positions[b, 1] - cy, positions[b, 2] - cz
        dx, dy, dz = positions[c, 0] - cx, positions[c, 1] - cy, positions[c, 2] - cz
        gx, gy, gz = (ax + bx + dx) / 3.0, (ay + by + dy) / 3.0, (az + bz + dz) / 3.0
        # All jets lie on one cone; most fabric is too far from it for the nearest jet to matter.
        height = gx * upx + gy * upy + gz * upz
        beyond = math.sqrt(max(0.0, gx * gx + gy * gy + gz * gz - height * height)) - radius_of_ring
        axial = beyond * lean + height * rise
        ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, dx - ax, dy - ay, dz - az
        off2, core2 = (beyond * rise - height * lean) ** 2, (0.11 * axial) ** 2 + 0.25 * diameter * diameter
        # A bound of twice the area, with room for rounding: most need not know it better.
        largest = 0.500001 * (ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz)
        if (axial <= 0.0) | (off2 > REACH * REACH * (core2 + 0.25 * largest) + 2.0 * largest):
            continue
        nx, ny, nz = cross(ux, uy, uz, vx, vy, vz)
        double_area = math.sqrt(nx * nx + ny * ny + nz * nz)
        if double_area == 0.0 or off2 > REACH * REACH * (core2 + 0.25 * double_area) + 2.0 * double_area:
            continue
        azimuth = math.atan2(
            gx * ring[2, 0] + gy * ring[2, 1] + gz * ring[2, 2], gx * ring[1, 0] + gy * ring[1, 1] + gz * ring[1, 2]
        )
        k = math.floor(azimuth / pitch + 0.5) % jets  # the footprints of neighbouring jets hardly overlap
        hx, hy, hz = holes[k, 0], holes[k, 1], holes[k, 2]
        rx, ry, rz = gx + cx - hx, gy + cy - hy, gz + cz - hz
        s = rx * frames[k, 0, 0] + ry * frames[k, 0, 1] + rz * frames[k, 0, 2]
        if s <= 0.0:
            continue
        distance2 = rx * rx + ry * ry + rz * rz
        spread2 = (0.11 * s) ** 2 + 0.25 * diameter * diameter + 0.25 * double_area
        across2 = max(0.0, distance2 - s * s)
        facing = (nx * rx + ny * ry + nz * rz) / (double_area * math.sqrt(distance2))
        if facing < 0.0 and across2 <= REACH * REACH * spread2 + 2.0 * double_area:
            if hides == len(screens):
                screens, jet_of_screen = _doubled(screens), _doubled(jet_of_screen)
            jet_of_screen[hides, 0] = k
            behind = False
            for m, (px, py, pz) in enumerate(((ax, ay, az), (bx, by, bz), (dx, dy, dz))):
                px, py, pz = px + cx - hx, py + cy - hy, pz + cz - hz
                along_axis = px * frames[k, 0, 0] + py * frames[k, 0, 1] + pz * frames[k, 0, 2]
                behind = behind or along_axis <= 0.0
                near = 1.0 / along_axis
                screens[hides, 3 * m] = near * (px * frames[k, 1, 0] + py * frames[k, 1, 1] + pz * frames[k, 1, 2])
                screens[hides, 3 * m + 1] = near * (px * frames[k, 2, 0] + py * frames[k, 2, 1] + pz * frames[k, 2, 2])
                screens[hides, 3 * m + 2] = near
            if not behind:
                hides += 1
        elif facing > 1e-6 and across2 <= REACH * REACH * spread2:
            cosine = (nx * frames[k, 0, 0] + ny * frames[k, 0, 1] + nz * frames[k, 0, 2]) / double_area
            if cosine > 0.0:
                if lights == len(lit):
                    lit, of_lit = _doubled(lit), _doubled(of_lit)
                speed = min(1.0, 6.0 * diameter / s)
                nx, ny, nz = double_area_vector(positions, a, b, c)
                lit[lights, 0], lit[lights, 1] = w, k
                of_lit[lights, WIDTH] = (rx * frames[k, 1, 0] + ry * frames[k, 1, 1] + rz * frames[k, 1, 2]) / s
                of_lit[lights, HEIGHT] = (rx * frames[k, 2, 0] + ry * frames[k, 2, 1] + rz * frames[k, 2, 2]) / s
                of_lit[lights, NEARNESS] = 1.0 / s
                of_lit[lights, WEIGHT] = speed * speed * cosine * cosine * math.exp(-2.0 * across2 / spread2)
                of_lit[lights, THRUST] = nx * frames[k, 0, 0] + ny * frames[k, 0, 1] + nz * frames[k, 0, 2]
                lights += 1
    return lit[:lights, 0], of_lit[:lights], lit[:lights, 1], screens[:hides], jet_of_screen[:hides, 0]


@scalar
def _square(u):
    """Square of the lateral direction u; the outermost ones take everything beyond."""
    return int(min(max(0.5 * SQUARES * (1.0 + u / WIDEST), 0.0), SQUARES - 1.0))


@scalar
def hide(of_lit, jet_of_lit, screens, jet_of_screen, jets):
    """Set to zero the weight of what is hidden.

    A ray that starts inside leaves through a wall seen from inside, and only comes back through a wall seen from
    outside. So fabric is hidden only if a wall seen from outside crosses the line of sight.
    """
    first = np.full((jets, SQUARES, SQUARES), -1, np.int64)
    after, farthest = np.empty(len(of_lit), np.int64), np.full(jets, math.inf)
    for m in range(len(of_lit)):
        k, x, y = jet_of_lit[m], _square(of_lit[m, WIDTH]), _square(of_lit[m, HEIGHT])
        after[m], first[k, x, y] = first[k, x, y], m
        farthest[k] = min(farthest[k], of_lit[m, NEARNESS])
    for i in range(len(screens)):
        au, av, an = screens[i, 0], screens[i, 1], screens[i, 2]
        bu, bv, bn = screens[i, 3], screens[i, 4], screens[i, 5]
        cu, cv, cn = screens[i, 6], screens[i, 7], screens[i, 8]
        whole = (bu - au) * (cv - av) - (bv - av) * (cu - au)
        k, nearest, lowest, highest = jet_of_screen[i], max(an, bn, cn), min(av, bv, cv), max(av, bv, cv)
        if whole == 0.0 or not nearest > farthest[k]:
            continue
        for x in range(_square(min(au, bu, cu)), _square(max(au, bu, cu)) + 1):
            for y in range(_square(lowest), _square(highest) + 1):
                before, m = -1, first[k, x, y]
                while m >= 0:
                    u, v, near, hidden = of_lit[m, WIDTH], of_lit[m, HEIGHT], of_lit[m, NEARNESS], False
                    if lowest <= v <= highest and near < nearest:
                        second = ((u - au) * (cv - av) - (v - av) * (cu - au)) / whole
                        third = ((bu - au) * (v - av) - (bv - av) * (u - au)) / whole
                        if second >= 0.0 and third >= 0.0 and second + third <= 1.0:
                            # Nearness is linear over a projected triangle.
                            hidden = an + second * (bn - an) + third * (cn - an) > near * (1.0 + 1e-6)
                    if hidden:
                        of_lit[m, WEIGHT] = 0.0
                        if before < 0:
                            first[k, x, y] = after[m]
                        else:
                            after[before] = after[m]
                    else:
                        before = m
                    m = after[m]
