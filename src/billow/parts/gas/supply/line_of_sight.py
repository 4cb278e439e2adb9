"""What jets from a ring of holes fall on: the fabric in line of sight (docs/theory.md, Jets).

Seen from its hole, a point has lateral over axial coordinates (u, v) and nearness 1/axial. A line of sight is one point
(u, v), so hiding is a test of plane triangles. What may be lit is sorted into squares of (u, v); what may hide only
looks at the squares it lies over.
"""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar, spliced
from billow.geometry.angle import angle
from billow.geometry.triangle import double_area_vector

REACH = 1.5
"""Radius of the footprint in radii of the Gaussian; 99 % of the momentum flux lies within (1 - e^-4.5)."""

MOST = 2.0
"""Force of a jet on all it falls on, at most, in its thrust: no wall can do more than turn it back."""

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
    # Their thrust is along the axis of the jet, unless all that it falls on lies nearly along it.
    along, total, n = np.zeros(jets), np.zeros((jets, 3)), 0
    for m in range(len(lit)):
        if of_lit[m, WEIGHT] > 0.0:
            w, k = lit[m], jet_of_lit[m]
            along[k] += 0.5 * of_lit[m, WEIGHT] * of_lit[m, THRUST]
            t = walls[w] if len(walls) > 0 else w
            nx, ny, nz = double_area_vector(positions, triangles[t, 0], triangles[t, 1], triangles[t, 2])
            part = -0.5 * of_lit[m, WEIGHT] if len(walls) > 0 and turned_round[w] else 0.5 * of_lit[m, WEIGHT]
            total[k, 0] += part * nx
            total[k, 1] += part * ny
            total[k, 2] += part * nz
            n += 1
    for k in range(jets):
        x, y, z = total[k]
        along[k] = max(along[k], math.sqrt(x * x + y * y + z * z) / MOST)
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
    for i in range(len(rows)):  # an assigned slice would bring the text of an error with it: seconds of compiling
        for j in range(rows.shape[1]):
            more[i, j] = rows[i, j]
    return more


BLOCK = 32
"""Triangles that are looked at together, in loops without branches."""
THIRD = 1.0 / 3.0
# fmt: off
(
    AX, AY, AZ, BX, BY, BZ, DX, DY, DZ, GX, GY, GZ,  # corners and middle from the middle of the ring [m]
    NX, NY, NZ, AREA2,  # twice the area vector, and its size [m^2]
    NEAR,  # below zero where the triangle is too far from the cone of all jets
    AZIMUTH,  # about the axis of the ring, from the first jet [rad]
    HX, HY, HZ, JX, JY, JZ,  # hole of its jet from the middle of the ring [m], and direction of the jet
    ALONG, OFF, COSINE,  # distance along the jet [m]; squared distance from its axis over squared width; angle to it
    KIND,  # above zero where it may be lit, below zero where it may hide what is
) = (BLOCK * row for row in range(28))
ROWS = 28
# fmt: on


@spliced
def _gather_corners(block, first, count, triangles, walls, turned_round, positions, cx, cy, cz):
    """Fill the rows AX to DZ with `count` walls from `first` on."""
    for j in range(count):
        w = first + j
        i = walls[w] if len(walls) > 0 else w
        a, b, c = np.uint64(triangles[i, 0]), np.uint64(triangles[i, 1]), np.uint64(triangles[i, 2])
        if len(walls) > 0 and turned_round[w]:
            a, c = c, a
        block[AX + j], block[AY + j], block[AZ + j] = positions[a, 0] - cx, positions[a, 1] - cy, positions[a, 2] - cz
        block[BX + j], block[BY + j], block[BZ + j] = positions[b, 0] - cx, positions[b, 1] - cy, positions[b, 2] - cz
        block[DX + j], block[DY + j], block[DZ + j] = positions[c, 0] - cx, positions[c, 1] - cy, positions[c, 2] - cz


@spliced
def _ask_cone(block, count, ring, radius_of_ring, lean, rise, diameter):
    """Fill the rows GX to AZIMUTH; returns whether any of `count` triangles is near. All jets lie on one cone; most
    fabric is too far from it for the nearest jet to matter."""
    upx, upy, upz = ring[0, 0], ring[0, 1], ring[0, 2]
    for j in range(BLOCK):
        ax, ay, az = block[AX + j], block[AY + j], block[AZ + j]
        bx, by, bz = block[BX + j], block[BY + j], block[BZ + j]
        dx, dy, dz = block[DX + j], block[DY + j], block[DZ + j]
        gx, gy, gz = THIRD * (ax + bx + dx), THIRD * (ay + by + dy), THIRD * (az + bz + dz)
        ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, dx - ax, dy - ay, dz - az
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        area2 = math.sqrt(nx * nx + ny * ny + nz * nz)
        height = gx * upx + gy * upy + gz * upz
        out2 = gx * gx + gy * gy + gz * gz - height * height
        beyond = math.sqrt(out2 if out2 > 0.0 else 0.0) - radius_of_ring
        axial, off = beyond * lean + height * rise, beyond * rise - height * lean
        core2 = 0.11 * axial * (0.11 * axial) + 0.25 * diameter * diameter
        near = REACH * REACH * (core2 + 0.25 * area2) + 2.0 * area2 - off * off
        block[GX + j], block[GY + j], block[GZ + j] = gx, gy, gz
        block[NX + j], block[NY + j], block[NZ + j], block[AREA2 + j] = nx, ny, nz, area2
        block[NEAR + j] = near if (axial > 0.0) & (area2 > 0.0) else -1.0
        first = gx * ring[1, 0] + gy * ring[1, 1] + gz * ring[1, 2]
        block[AZIMUTH + j] = angle(first, gx * ring[2, 0] + gy * ring[2, 1] + gz * ring[2, 2])
    near_ones = 0
    for j in range(count):
        near_ones += 1 if block[NEAR + j] >= 0.0 else 0
    return near_ones > 0


@spliced
def _ask_jet(block, diameter):
    """Fill the rows ALONG to KIND; they mean nothing where NEAR is below zero."""
    for j in range(BLOCK):
        rx, ry, rz = block[GX + j] - block[HX + j], block[GY + j] - block[HY + j], block[GZ + j] - block[HZ + j]
        nx, ny, nz, area2 = block[NX + j], block[NY + j], block[NZ + j], block[AREA2 + j]
        jx, jy, jz = block[JX + j], block[JY + j], block[JZ + j]
        s, distance2 = rx * jx + ry * jy + rz * jz, rx * rx + ry * ry + rz * rz
        spread2 = 0.11 * s * (0.11 * s) + 0.25 * diameter * diameter + 0.25 * area2
        across2 = distance2 - s * s
        across2 = across2 if across2 > 0.0 else 0.0
        facing = (nx * rx + ny * ry + nz * rz) / (area2 * math.sqrt(distance2))
        cosine = (nx * jx + ny * jy + nz * jz) / area2
        lit = (facing > 1e-6) & (cosine > 0.0) & (across2 <= REACH * REACH * spread2)
        hides = (facing < 0.0) & (across2 <= REACH * REACH * spread2 + 2.0 * area2)
        block[ALONG + j], block[OFF + j], block[COSINE + j] = s, across2 / spread2, cosine
        block[KIND + j] = 0.0 if s <= 0.0 else 1.0 if lit else -1.0 if hides else 0.0


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
    lit, of_lit, lights = np.empty((256, 2), np.int64), np.empty((256, 5)), 0
    screens, jet_of_screen, hides = np.empty((256, 9)), np.empty((256, 1), np.int64), 0
    block, jet_of = np.zeros(ROWS * BLOCK), np.zeros(BLOCK, np.int64)
    for first in range(0, n, BLOCK):
        count = min(BLOCK, n - first)
        _gather_corners(block, first, count, triangles, walls, turned_round, positions, cx, cy, cz)
        if not _ask_cone(block, count, ring, radius_of_ring, lean, rise, diameter):
            continue
        for j in range(count):
            if block[NEAR + j] >= 0.0:
                k = math.floor(block[AZIMUTH + j] / pitch + 0.5)  # footprints of neighbouring jets hardly overlap
                k = k + jets if k < 0 else k - jets if k >= jets else k
                jet_of[j] = k
                block[HX + j], block[HY + j], block[HZ + j] = holes[k, 0] - cx, holes[k, 1] - cy, holes[k, 2] - cz
                block[JX + j], block[JY + j], block[JZ + j] = frames[k, 0, 0], frames[k, 0, 1], frames[k, 0, 2]
        _ask_jet(block, diameter)
        for j in range(count):
            if block[NEAR + j] < 0.0 or block[KIND + j] == 0.0:
                continue
            w, k = first + j, jet_of[j]
            if block[KIND + j] < 0.0:
                if hides == len(screens):
                    screens, jet_of_screen = _doubled(screens), _doubled(jet_of_screen)
                jet_of_screen[hides, 0] = k
                behind = False
                for m in range(3):
                    px = block[AX + 3 * BLOCK * m + j] - block[HX + j]
                    py = block[AY + 3 * BLOCK * m + j] - block[HY + j]
                    pz = block[AZ + 3 * BLOCK * m + j] - block[HZ + j]
                    along_axis = px * frames[k, 0, 0] + py * frames[k, 0, 1] + pz * frames[k, 0, 2]
                    behind = behind or along_axis <= 0.0
                    near = 1.0 / along_axis
                    screens[hides, 3 * m] = near * (px * frames[k, 1, 0] + py * frames[k, 1, 1] + pz * frames[k, 1, 2])
                    screens[hides, 3 * m + 1] = near * (
                        px * frames[k, 2, 0] + py * frames[k, 2, 1] + pz * frames[k, 2, 2]
                    )
                    screens[hides, 3 * m + 2] = near
                if not behind:
                    hides += 1
            else:
                if lights == len(lit):
                    lit, of_lit = _doubled(lit), _doubled(of_lit)
                s, area2, cosine = block[ALONG + j], block[AREA2 + j], block[COSINE + j]
                rx, ry, rz = block[GX + j] - block[HX + j], block[GY + j] - block[HY + j], block[GZ + j] - block[HZ + j]
                speed = min(1.0, 6.0 * diameter / s)
                lit[lights, 0], lit[lights, 1] = w, k
                of_lit[lights, WIDTH] = (rx * frames[k, 1, 0] + ry * frames[k, 1, 1] + rz * frames[k, 1, 2]) / s
                of_lit[lights, HEIGHT] = (rx * frames[k, 2, 0] + ry * frames[k, 2, 1] + rz * frames[k, 2, 2]) / s
                of_lit[lights, NEARNESS] = 1.0 / s
                of_lit[lights, WEIGHT] = speed * speed * cosine * cosine * math.exp(-2.0 * block[OFF + j])
                of_lit[lights, THRUST] = cosine * area2
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
