"""Contact of fabric nodes with the shapes of rigid bodies as kernels see it: nodes in blocks, one quantity a row, so
that arithmetic runs over rows and becomes vector instructions (docs/theory.md, Contact over a step).

All nodes of a chunk are kicked, and asked whether they come close to a shape: most do not. Those that do are gathered
in blocks of their own, in which the pushes of all shapes on each are solved together. Nodes that come close to the same
shape stand together, so that blocks have little to do with the others.
"""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar, spliced
from billow.geometry.shapes import super_ellipsoid_block
from billow.geometry.shapes.half_space import near_half_space
from billow.geometry.shapes.kinds import HALF_SPACE, MESH, SUPER_ELLIPSOID, near_other_shape
from billow.geometry.shapes.pose import into_axes, into_space, pose_of
from billow.parts.bodies.penalty import contact_force

BLOCK = super_ellipsoid_block.BLOCK
"""Nodes in a block."""

# fmt: off
(
    PX, PY, PZ, VX, VY, VZ,  # positions at the start of the step [m], velocities [m/s]
    WAY,  # a bound of the way [m]
    CLOSE,  # 1 + o for nodes that may come to shape o, 0 for none
    AREA, INVERSE_MASS, PUSHERS,  # [m^2], [1/kg], shapes that push
    OPEN, CHANGE, SIZE,  # above zero if the pushes have not settled; change and sum in the last sweep [N]
) = (BLOCK * row for row in range(14))
ROWS = 14
"""Rows of a block of nodes."""

(
    TOUCHES,  # 1 for nodes that touch the shape within the step, 0 for others
    RX, RY, RZ, SX, SY, SZ, TX, TY, TZ,  # from the body, from the shape [m], way relative to the body [m]
    DEPTH, NX, NY, NZ,  # depth [m], negative outside, and outward normal
    OX, OY, OZ,  # offset from the sticking point before the step, in space [m]
    FX, FY, FZ, AX, AY, AZ,  # the push [N] and the offset after the step, in space [m]
    STORED, LOST, AFTER,  # energy in the springs and lost [J], depth after the step [m]
    SUM,  # of all blocks of a chunk so far: SUMS rows, as in `add_up`
) = (BLOCK * row for row in range(27))
SUMS = 9
PAIR_ROWS = 26 + SUMS
"""Rows of a block of nodes and one shape."""
# fmt: on

SWEEPS, SETTLED = 100, 1e-10
"""Most sweeps over the shapes that pinch a node, and the relative change of force at which they end."""


@spliced
def kick_block(block, first, count, dt, nodes):
    """Half a kick of `count` nodes from `first` on, kept in the rows PX to VZ too; and where they are before."""
    inverse_mass, nodal_force, positions, velocities, before = nodes
    for j in range(count):
        i = np.uint64(first + j)
        half = 0.5 * dt * inverse_mass[i]
        x, y, z = positions[i, 0], positions[i, 1], positions[i, 2]
        vx = velocities[i, 0] + half * nodal_force[i, 0]
        vy = velocities[i, 1] + half * nodal_force[i, 1]
        vz = velocities[i, 2] + half * nodal_force[i, 2]
        block[PX + j], block[PY + j], block[PZ + j] = x, y, z
        block[VX + j], block[VY + j], block[VZ + j] = vx, vy, vz
        velocities[i, 0], velocities[i, 1], velocities[i, 2] = vx, vy, vz
    if len(before) > 0:
        for j in range(count):
            i = np.uint64(first + j)
            before[i, 0], before[i, 1], before[i, 2] = block[PX + j], block[PY + j], block[PZ + j]


@spliced
def ask_block(block, first, count, dt, bound, motion, touching):
    """Fill the row CLOSE: 1 + o for nodes that touch shape o, and for all that may come into the sphere around it, or
    below a plane, if they go on as they are, for the last such o; returns whether there is any. Most do not, so these
    are loops without branches, in which ways are bounded and not measured."""
    body, centre, pose, _ = motion
    for j in range(BLOCK):
        block[CLOSE + j] = 0.0
        block[WAY + j] = dt * (abs(block[VX + j]) + abs(block[VY + j]) + abs(block[VZ + j]))
    for o in range(len(bound)):
        mx, my, mz, radius = centre[o, 0], centre[o, 1], centre[o, 2], bound[o]
        cx, cy, cz, ux, uy, uz = body[o, 0], body[o, 1], body[o, 2], body[o, 3], body[o, 4], body[o, 5]
        mark = o + 1.0
        turn = dt * (abs(body[o, 6]) + abs(body[o, 7]) + abs(body[o, 8]))
        if radius < math.inf:
            # A place at s from the middle of the shape goes with the body by at most dt |u| + turn (|s| + |m|).
            own = radius + dt * (abs(ux) + abs(uy) + abs(uz)) + turn * (abs(mx) + abs(my) + abs(mz))
            more = 1.0 / (1.0 - turn) if turn < 0.5 else math.inf
            cx, cy, cz = cx + mx, cy + my, cz + mz
            for j in range(BLOCK):
                sx, sy, sz = block[PX + j] - cx, block[PY + j] - cy, block[PZ + j] - cz
                reach = more * (own + block[WAY + j])
                block[CLOSE + j] = mark if sx * sx + sy * sy + sz * sz < reach * reach else block[CLOSE + j]
        else:
            nx, ny, nz = pose[o, 2], pose[o, 5], pose[o, 8]
            height, rise = nx * (cx + mx) + ny * (cy + my) + nz * (cz + mz), nx * ux + ny * uy + nz * uz
            farther = 0.0 if turn == 0.0 else math.inf
            for j in range(BLOCK):
                z = nx * block[PX + j] + ny * block[PY + j] + nz * block[PZ + j] - height
                way = dt * (nx * block[VX + j] + ny * block[VY + j] + nz * block[VZ + j] - rise)
                lowest = z + way if way < 0.0 else z
                block[CLOSE + j] = mark if lowest < farther else block[CLOSE + j]
        for j in range(count):
            block[CLOSE + j] = mark if touching[o, np.uint64(first + j)] else block[CLOSE + j]
    close = 0
    for j in range(count):
        close += 1 if block[CLOSE + j] > 0.0 else 0
    return close > 0


@spliced
def drift_block(block, first, count, dt, nodes):
    """Move `count` nodes from `first` on as if nothing touched them; those that come close wait."""
    positions = nodes[2]
    for j in range(count):
        i = np.uint64(first + j)
        way = 0.0 if block[CLOSE + j] > 0.0 else dt
        positions[i, 0] = block[PX + j] + way * block[VX + j]
        positions[i, 1] = block[PY + j] + way * block[VY + j]
        positions[i, 2] = block[PZ + j] + way * block[VZ + j]


@scalar
def sort_by_shape(nodes, shape, many, starts, sorted_out):
    """The first `many` nodes, those of one shape together, else in their order; starts: room for each shape and one."""
    for o in range(len(starts)):
        starts[o] = 0
    for k in range(many):
        starts[shape[k] + 1] += 1
    for o in range(1, len(starts)):
        starts[o] += starts[o - 1]
    for k in range(many):
        sorted_out[starts[shape[k]]] = nodes[k]
        starts[shape[k]] += 1


@spliced
def fetch(block, close, first, count, dt, area, nodes):
    """Fill the rows PX to VZ and AREA to PUSHERS with `count` nodes, close[first] and so on; columns beyond the last
    one have no fabric."""
    inverse_mass, _, positions, velocities, _ = nodes
    for j in range(BLOCK):
        block[AREA + j] = block[PUSHERS + j] = 0.0
    for j in range(count):
        i = np.uint64(close[first + j])
        block[PX + j], block[PY + j], block[PZ + j] = positions[i, 0], positions[i, 1], positions[i, 2]
        block[VX + j], block[VY + j], block[VZ + j] = velocities[i, 0], velocities[i, 1], velocities[i, 2]
        block[AREA + j], block[INVERSE_MASS + j] = area[i], inverse_mass[i]


@scalar
def find_touching(block, pairs, work, close, first, count, dt, table, motion, touching, offset, force):
    """Fill the rows TOUCHES to OZ of all shapes, and count PUSHERS; nodes that touch no more forget what they knew.
    work: room for `super_ellipsoid_block`."""
    kind, numbers, bound, _ = table
    body, centre, pose, met = motion
    for o in range(len(kind)):
        turned, own = pose_of(pose, o), (numbers[o, 0], numbers[o, 1], numbers[o, 2], numbers[o, 3], numbers[o, 4])
        for j in range(BLOCK):
            rx, ry, rz = block[PX + j] - body[o, 0], block[PY + j] - body[o, 1], block[PZ + j] - body[o, 2]
            tx = dt * (block[VX + j] - body[o, 3] - (body[o, 7] * rz - body[o, 8] * ry))
            ty = dt * (block[VY + j] - body[o, 4] - (body[o, 8] * rx - body[o, 6] * rz))
            tz = dt * (block[VZ + j] - body[o, 5] - (body[o, 6] * ry - body[o, 7] * rx))
            sx, sy, sz = rx - centre[o, 0], ry - centre[o, 1], rz - centre[o, 2]
            pairs[o, RX + j], pairs[o, RY + j], pairs[o, RZ + j] = rx, ry, rz
            pairs[o, SX + j], pairs[o, SY + j], pairs[o, SZ + j] = sx, sy, sz
            pairs[o, TX + j], pairs[o, TY + j], pairs[o, TZ + j] = tx, ty, tz
            # The cheap question first: within the sphere around the shape? A plane has none.
            reach = bound[o] + math.sqrt(tx * tx + ty * ty + tz * tz)
            touches = 1.0 if sx * sx + sy * sy + sz * sz < reach * reach else 0.0
            touches = touches if block[AREA + j] > 0.0 else 0.0
            pairs[o, TOUCHES + j] = touches
        if _any(pairs, o, TOUCHES):
            if kind[o] == HALF_SPACE:
                for j in range(BLOCK):
                    sx, sy, sz = pairs[o, SX + j], pairs[o, SY + j], pairs[o, SZ + j]
                    tx, ty, tz = pairs[o, TX + j], pairs[o, TY + j], pairs[o, TZ + j]
                    touches, depth, nx, ny, nz = near_half_space(own, turned, sx, sy, sz, tx, ty, tz)
                    pairs[o, TOUCHES + j] = pairs[o, TOUCHES + j] if touches else 0.0
                    pairs[o, DEPTH + j] = depth
                    pairs[o, NX + j], pairs[o, NY + j], pairs[o, NZ + j] = nx, ny, nz
            elif kind[o] == SUPER_ELLIPSOID:
                _near_super_ellipsoid(pairs, o, own, turned, work)
            else:
                for j in range(count):
                    tx, ty, tz = pairs[o, TX + j], pairs[o, TY + j], pairs[o, TZ + j]
                    if pairs[o, TOUCHES + j] == 0.0:
                        continue
                    if kind[o] == MESH:
                        i = close[first + j]
                        depth, nx, ny, nz = met[o, i, 0], met[o, i, 1], met[o, i, 2], met[o, i, 3]
                        touches = depth > -math.sqrt(tx * tx + ty * ty + tz * tz)
                    else:
                        sx, sy, sz = pairs[o, SX + j], pairs[o, SY + j], pairs[o, SZ + j]
                        touches, depth, nx, ny, nz = near_other_shape(kind[o], own, turned, sx, sy, sz, tx, ty, tz)
                    pairs[o, TOUCHES + j], pairs[o, DEPTH + j] = (1.0 if touches else 0.0), depth
                    pairs[o, NX + j], pairs[o, NY + j], pairs[o, NZ + j] = nx, ny, nz
        for j in range(count):
            i = np.uint64(close[first + j])
            if pairs[o, TOUCHES + j] > 0.0:
                block[PUSHERS + j] += 1.0
                touching[o, i] = True
                pairs[o, OX + j], pairs[o, OY + j], pairs[o, OZ + j] = into_space(
                    turned, offset[o, i, 0], offset[o, i, 1], offset[o, i, 2]
                )
            elif touching[o, i]:
                touching[o, i] = False
                for k in range(3):
                    force[o, i, k] = 0.0
                    offset[o, i, k] = 0.0


@spliced
def _any(pairs, o, row):
    """Whether a number of a row of shape o is above zero."""
    above = 0
    for j in range(BLOCK):
        above += 1 if pairs[o, row + j] > 0.0 else 0
    return above > 0


@scalar
def _near_super_ellipsoid(pairs, o, numbers, pose, work):
    """Depth and normal of the nodes that touch super-ellipsoid o; those in the sphere around it may not."""
    for j in range(BLOCK):
        sx, sy, sz = pairs[o, SX + j], pairs[o, SY + j], pairs[o, SZ + j]
        tx, ty, tz = pairs[o, TX + j], pairs[o, TY + j], pairs[o, TZ + j]
        x, y, z = into_axes(pose, sx, sy, sz)
        work[super_ellipsoid_block.X + j], work[super_ellipsoid_block.Y + j] = x, y
        work[super_ellipsoid_block.Z + j] = z
        work[super_ellipsoid_block.REACH + j] = math.sqrt(tx * tx + ty * ty + tz * tz)
        work[super_ellipsoid_block.COUNTS + j] = pairs[o, TOUCHES + j]
    super_ellipsoid_block.near_points(work, numbers)
    for j in range(BLOCK):
        mx, my = work[super_ellipsoid_block.MX + j], work[super_ellipsoid_block.MY + j]
        nx, ny, nz = into_space(pose, mx, my, work[super_ellipsoid_block.MZ + j])
        pairs[o, NX + j], pairs[o, NY + j], pairs[o, NZ + j] = nx, ny, nz
        pairs[o, DEPTH + j] = work[super_ellipsoid_block.DEPTH + j]
        pairs[o, TOUCHES + j] = work[super_ellipsoid_block.COUNTS + j]


@scalar
def solve(block, pairs, dt, table, motion):
    """Fill the rows FX to AFTER of all shapes, and bring VX to VZ to half of the pushes. Shapes that push one node are
    solved in sweeps until their forces settle."""
    body, law = motion[0], table[3]
    for j in range(BLOCK):
        block[OPEN + j] = block[PUSHERS + j]
    for o in range(len(law)):
        for j in range(BLOCK):
            pairs[o, FX + j] = pairs[o, FY + j] = pairs[o, FZ + j] = 0.0
    for _ in range(SWEEPS):
        remaining = 0
        for j in range(BLOCK):
            remaining += 1 if block[OPEN + j] > 0.0 else 0
        if remaining == 0:
            break
        for j in range(BLOCK):
            block[CHANGE + j] = block[SIZE + j] = 0.0
        for o in range(len(law)):
            if _any(pairs, o, TOUCHES):
                _push(block, pairs, o, dt, law, body)
        for j in range(BLOCK):
            goes_on = (block[PUSHERS + j] > 1.0) & (block[CHANGE + j] > SETTLED * block[SIZE + j])
            block[OPEN + j] = block[OPEN + j] if goes_on else 0.0


@scalar
def _push(block, pairs, o, dt, law, body):
    """The push of shape o on each node whose pushes have not settled, with those of the others."""
    slope, friction, damping = law[o, 0], law[o, 1], law[o, 2]
    cx, cy, cz, wx, wy, wz = body[o, 3], body[o, 4], body[o, 5], body[o, 6], body[o, 7], body[o, 8]
    for j in range(BLOCK):
        is_open = (pairs[o, TOUCHES + j] > 0.0) & (block[OPEN + j] > 0.0)
        half = 0.5 * dt * block[INVERSE_MASS + j]
        rx, ry, rz = pairs[o, RX + j], pairs[o, RY + j], pairs[o, RZ + j]
        ox, oy, oz = pairs[o, FX + j], pairs[o, FY + j], pairs[o, FZ + j]
        vx, vy, vz = block[VX + j], block[VY + j], block[VZ + j]
        ux, uy, uz = vx - half * ox, vy - half * oy, vz - half * oz
        fx, fy, fz, ax, ay, az, stored, lost, after = contact_force(
            pairs[o, DEPTH + j], pairs[o, NX + j], pairs[o, NY + j], pairs[o, NZ + j],
            ux - cx - (wy * rz - wz * ry), uy - cy - (wz * rx - wx * rz), uz - cz - (wx * ry - wy * rx),
            slope * block[AREA + j], block[INVERSE_MASS + j], damping, friction,
            pairs[o, OX + j], pairs[o, OY + j], pairs[o, OZ + j], dt,
        )  # fmt: skip
        block[VX + j] = ux + half * fx if is_open else vx
        block[VY + j] = uy + half * fy if is_open else vy
        block[VZ + j] = uz + half * fz if is_open else vz
        block[CHANGE + j] += (abs(fx - ox) + abs(fy - oy) + abs(fz - oz)) if is_open else 0.0
        block[SIZE + j] += (abs(fx) + abs(fy) + abs(fz)) if is_open else 0.0
        pairs[o, FX + j] = fx if is_open else ox
        pairs[o, FY + j] = fy if is_open else oy
        pairs[o, FZ + j] = fz if is_open else oz
        pairs[o, AX + j] = ax if is_open else pairs[o, AX + j]
        pairs[o, AY + j] = ay if is_open else pairs[o, AY + j]
        pairs[o, AZ + j] = az if is_open else pairs[o, AZ + j]
        pairs[o, STORED + j] = stored if is_open else pairs[o, STORED + j]
        pairs[o, LOST + j] = lost if is_open else pairs[o, LOST + j]
        pairs[o, AFTER + j] = after if is_open else pairs[o, AFTER + j]


@scalar
def finish(block, pairs, close, first, count, dt, motion, nodes, offset, force):
    """Move the nodes and keep what the shapes did to them; bring SUM up to date."""
    pose, positions, velocities = motion[2], nodes[2], nodes[3]
    for j in range(count):
        i = np.uint64(close[first + j])
        vx, vy, vz = block[VX + j], block[VY + j], block[VZ + j]
        velocities[i, 0], velocities[i, 1], velocities[i, 2] = vx, vy, vz
        positions[i, 0] = block[PX + j] + dt * vx
        positions[i, 1] = block[PY + j] + dt * vy
        positions[i, 2] = block[PZ + j] + dt * vz
    for o in range(len(pose)):
        if not _any(pairs, o, TOUCHES):
            continue
        turned = pose_of(pose, o)
        for j in range(BLOCK):
            touches = pairs[o, TOUCHES + j] > 0.0
            rx, ry, rz = pairs[o, RX + j], pairs[o, RY + j], pairs[o, RZ + j]
            fx, fy, fz = pairs[o, FX + j], pairs[o, FY + j], pairs[o, FZ + j]
            pairs[o, SUM + 0 * BLOCK + j] -= fx
            pairs[o, SUM + 1 * BLOCK + j] -= fy
            pairs[o, SUM + 2 * BLOCK + j] -= fz
            pairs[o, SUM + 3 * BLOCK + j] -= ry * fz - rz * fy
            pairs[o, SUM + 4 * BLOCK + j] -= rz * fx - rx * fz
            pairs[o, SUM + 5 * BLOCK + j] -= rx * fy - ry * fx
            pairs[o, SUM + 6 * BLOCK + j] += pairs[o, STORED + j] if touches else 0.0
            pairs[o, SUM + 7 * BLOCK + j] += pairs[o, LOST + j] if touches else 0.0
            after, deepest = pairs[o, AFTER + j], pairs[o, SUM + 8 * BLOCK + j]
            deeper = touches & (after > deepest)
            pairs[o, SUM + 8 * BLOCK + j] = after if deeper else deepest
        for j in range(count):
            if pairs[o, TOUCHES + j] > 0.0:
                i = np.uint64(close[first + j])
                force[o, i, 0] = pairs[o, FX + j]
                force[o, i, 1] = pairs[o, FY + j]
                force[o, i, 2] = pairs[o, FZ + j]
                # Kept in the shape's axes, where the sticking point rests.
                ax, ay, az = into_axes(turned, pairs[o, AX + j], pairs[o, AY + j], pairs[o, AZ + j])
                offset[o, i, 0], offset[o, i, 1], offset[o, i, 2] = ax, ay, az


@scalar
def add_up(pairs, chunk, partial_out):
    """Add up a chunk, whose sums are zero: force [N] and torque [N m] on each shape, energy stored and lost [J],
    deepest penetration [m]."""
    for o in range(len(pairs)):
        for k in range(SUMS):
            for j in range(BLOCK):
                value = pairs[o, SUM + k * BLOCK + j]
                if k < SUMS - 1:
                    partial_out[chunk, o, k] += value
                else:
                    partial_out[chunk, o, k] = max(partial_out[chunk, o, k], value)
