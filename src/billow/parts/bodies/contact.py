"""Fabric nodes against the shapes of rigid bodies, over a step (docs/theory.md, Contact over a step): one pass over the
nodes gives half a kick, half of each contact impulse, and the drift. So the drift has the mean of both velocities; the
other half of kick and impulses comes after it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, inlined, kernel
from billow.geometry.shapes.kinds import MESH, near_shape, number_of
from billow.geometry.shapes.pose import into_axes, into_space, pose_of
from billow.geometry.shapes.shape import NUMBERS, Shape
from billow.parts.bodies.penalty import A_REFERENCE, contact_force


@dataclass(frozen=True)
class SurfaceLaw:
    """slope: force per penetration of a node with 1e-4 m^2 of fabric [N/m]; friction [-]; damping: of critical [-]."""

    slope: float
    friction: float
    damping: float


@dataclass
class ContactState:
    """Of all shapes. force: average over the last step on each fabric node, [N], (shapes, nodes, 3). offset: from the
    sticking point, [m], (shapes, nodes, 3), in each shape's axes. touching: (shapes, nodes) bool. stored: energy in the
    contact springs [J]; dissipated: in the last step [J]; deepest: penetration [m]; all three (shapes,)."""

    force: np.ndarray
    offset: np.ndarray
    touching: np.ndarray
    stored: np.ndarray
    dissipated: np.ndarray
    deepest: np.ndarray

    @classmethod
    def none(cls, shapes: int, nodes: int) -> ContactState:
        """Nothing touches."""
        field, sums = np.zeros((shapes, nodes, 3)), np.zeros(shapes)
        return cls(field, field.copy(), np.zeros((shapes, nodes), np.bool_), sums, sums.copy(), sums.copy())


BLOCK = 32
"""Nodes that are kicked, and asked whether they come close to a shape, together."""
PX, PY, PZ, VX, VY, VZ, WAY, CLOSE = (BLOCK * row for row in range(8))
"""Rows of a block: positions [m], velocities [m/s], a bound of the way [m], how far a node comes into a shape's reach
(in no unit)."""
ROWS = 8

SWEEPS, SETTLED = 100, 1e-10
"""Most sweeps over the shapes that pinch a node, and the relative change of force at which they end."""


class ShapeTable(NamedTuple):
    """What kernels need of all shapes and never changes; a row a shape.

    kind: of `near_shape`, (shapes,) int64. numbers: (shapes, NUMBERS). bound: radius of a sphere around it [m],
    (shapes,). law: slope per fabric area [N/m^3], friction [-], damping [-], (shapes, 3).
    """

    kind: np.ndarray
    numbers: np.ndarray
    bound: np.ndarray
    law: np.ndarray

    @classmethod
    def build(cls, shapes: Sequence[Shape], laws: Sequence[SurfaceLaw]) -> ShapeTable:
        return cls(
            np.array([number_of(shape) for shape in shapes], dtype=np.int64),
            np.array([shape.numbers for shape in shapes], dtype=float).reshape(-1, NUMBERS),
            np.array([shape.bound for shape in shapes], dtype=float),
            np.array([(law.slope / A_REFERENCE, law.friction, law.damping) for law in laws]).reshape(-1, 3),
        )


class Nodes(NamedTuple):
    """inverse_mass [1/kg], (nodes,); force [N] at the start of a step, positions [m], velocities [m/s], and room for
    the positions before the drift: (nodes, 3). No room, (0, 3), where nobody asks for them."""

    inverse_mass: np.ndarray
    force: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    before: np.ndarray


class ShapeMotion(NamedTuple):
    """Where shapes are and how they move, a row a shape.

    body: centre [m], velocity [m/s] and spin [rad/s] of the body that carries it, (shapes, 9). centre: of the shape
    from that of the body [m], in space, (shapes, 3). pose: rotation of the shape's axes to space, row by row, (shapes,
    9). met: depth of each node in each mesh [m] and normal, (shapes, nodes, 4), as `Mesh.look` finds it; without rows
    if no shape is a mesh.
    """

    body: np.ndarray
    centre: np.ndarray
    pose: np.ndarray
    met: np.ndarray

    @classmethod
    def room(cls, shapes: int, nodes: int = 0) -> ShapeMotion:
        """Rows to be filled; shapes lie in their bodies' centres. nodes: if one of them is a mesh."""
        met = np.full((shapes if nodes else 0, nodes, 4), -np.inf)
        return cls(np.zeros((shapes, 9)), np.zeros((shapes, 3)), np.zeros((shapes, 9)), met)


def kick_touch_drift(
    table: ShapeTable, motion: ShapeMotion, area: np.ndarray, nodes: Nodes, dt: float, contact: ContactState
) -> np.ndarray:
    """Half a kick of all fabric nodes, their contact with all shapes over a step of dt [s], and their drift; fills
    `contact`. area: [m^2], (nodes,). Returns (shapes, 6): force [N] and torque about the centre of the body [N m] that
    each shape receives.
    """
    reaction = np.empty((len(table.kind), 6))
    _kick_touch_drift(
        len(nodes.positions), tuple(table), tuple(motion), area, tuple(nodes), dt, contact.force, contact.offset,
        contact.touching, contact.stored, contact.dissipated, contact.deepest, reaction,
    )  # fmt: skip
    return reaction


@inlined
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


@inlined
def ask_block(block, first, count, dt, bound, motion, touching):
    """Fill the row CLOSE: above zero for nodes that touch a shape, and for all that may come into the sphere around
    one, or below a plane, if they go on as they are; returns whether there is any. Most do not, so these are loops
    without branches, in which ways are bounded and not measured."""
    body, centre, pose, _ = motion
    for j in range(BLOCK):
        block[CLOSE + j] = 0.0
        block[WAY + j] = dt * (abs(block[VX + j]) + abs(block[VY + j]) + abs(block[VZ + j]))
    for o in range(len(bound)):
        mx, my, mz, radius = centre[o, 0], centre[o, 1], centre[o, 2], bound[o]
        cx, cy, cz, ux, uy, uz = body[o, 0], body[o, 1], body[o, 2], body[o, 3], body[o, 4], body[o, 5]
        turn = dt * (abs(body[o, 6]) + abs(body[o, 7]) + abs(body[o, 8]))
        if radius < math.inf:
            # A place at s from the middle of the shape goes with the body by at most dt |u| + turn (|s| + |m|).
            own = radius + dt * (abs(ux) + abs(uy) + abs(uz)) + turn * (abs(mx) + abs(my) + abs(mz))
            more = 1.0 / (1.0 - turn) if turn < 0.5 else math.inf
            cx, cy, cz = cx + mx, cy + my, cz + mz
            for j in range(BLOCK):
                sx, sy, sz = block[PX + j] - cx, block[PY + j] - cy, block[PZ + j] - cz
                reach = more * (own + block[WAY + j])
                close = reach * reach - (sx * sx + sy * sy + sz * sz)
                block[CLOSE + j] = close if close > block[CLOSE + j] else block[CLOSE + j]
        else:
            nx, ny, nz = pose[o, 2], pose[o, 5], pose[o, 8]
            height, rise = nx * (cx + mx) + ny * (cy + my) + nz * (cz + mz), nx * ux + ny * uy + nz * uz
            farther = 0.0 if turn == 0.0 else math.inf
            for j in range(BLOCK):
                z = nx * block[PX + j] + ny * block[PY + j] + nz * block[PZ + j] - height
                way = dt * (nx * block[VX + j] + ny * block[VY + j] + nz * block[VZ + j] - rise)
                close = farther - (z + way if way < 0.0 else z)
                block[CLOSE + j] = close if close > block[CLOSE + j] else block[CLOSE + j]
        for j in range(count):
            block[CLOSE + j] = 1.0 if touching[o, np.uint64(first + j)] else block[CLOSE + j]
    closest = 0.0
    for j in range(count):
        closest = block[CLOSE + j] if block[CLOSE + j] > closest else closest
    return closest > 0.0


@inlined
def _drift(block, first, count, dt, positions):
    """Move `count` nodes from `first` on as if nothing touched them."""
    for j in range(count):
        i = np.uint64(first + j)
        positions[i, 0] = block[PX + j] + dt * block[VX + j]
        positions[i, 1] = block[PY + j] + dt * block[VY + j]
        positions[i, 2] = block[PZ + j] + dt * block[VZ + j]


@kernel
def _kick_touch_drift(
    n, table, motion, area, nodes, dt, force, offset, touching, stored_out, dissipated_out, deepest_out, reaction_out
):
    # The node's solve stands here as text. By `reaches` and `push_node` of rows.py it takes 28 ns
    # a node more: arrays given to an inlined function have their references counted at every node.
    inverse_mass, _, positions, velocities, _ = nodes
    body, centre, pose, met = motion
    kind, numbers, bound, law = table
    chunks, shapes = (n + CHUNK - 1) // CHUNK, len(kind)
    partial = np.empty((chunks, shapes, 9))  # reaction, stored, dissipated, deepest
    for chunk in prange(chunks):
        partial[chunk] = 0.0
        block = np.zeros(ROWS * BLOCK)
        near = np.empty(shapes, dtype=np.int64)
        geometry = np.empty((shapes, 4))  # depth and normal
        answer = np.empty((shapes, 9))  # force, new offset in space, stored, dissipated, depth after
        end = min(n, (chunk + 1) * CHUNK)
        for first in range(chunk * CHUNK, end, BLOCK):
            count = min(BLOCK, end - first)
            kick_block(block, first, count, dt, nodes)
            any_close = ask_block(block, first, count, dt, bound, motion, touching)
            _drift(block, first, count, dt, positions)
            if not any_close:
                continue
            for j in range(count):
                if block[CLOSE + j] == 0.0:
                    continue
                px, py, pz = block[PX + j], block[PY + j], block[PZ + j]
                i = first + j
                half, pushers = 0.5 * dt * inverse_mass[i], 0
                for o in range(shapes):
                    rx, ry, rz = px - body[o, 0], py - body[o, 1], pz - body[o, 2]
                    tx = dt * (velocities[i, 0] - body[o, 3] - (body[o, 7] * rz - body[o, 8] * ry))
                    ty = dt * (velocities[i, 1] - body[o, 4] - (body[o, 8] * rx - body[o, 6] * rz))
                    tz = dt * (velocities[i, 2] - body[o, 5] - (body[o, 6] * ry - body[o, 7] * rx))
                    sx, sy, sz = rx - centre[o, 0], ry - centre[o, 1], rz - centre[o, 2]
                    # The cheap question first: within the sphere around the shape, or below the plane above it?
                    if bound[o] < math.inf:
                        reach = bound[o] + math.sqrt(tx * tx + ty * ty + tz * tz)
                        touches = sx * sx + sy * sy + sz * sz < reach * reach
                    else:
                        z = pose[o, 2] * sx + pose[o, 5] * sy + pose[o, 8] * sz
                        touches = min(z, z + (pose[o, 2] * tx + pose[o, 5] * ty + pose[o, 8] * tz)) < 0.0
                    if touches:
                        if kind[o] == MESH:
                            depth, nx, ny, nz = met[o, i, 0], met[o, i, 1], met[o, i, 2], met[o, i, 3]
                            touches = depth > -math.sqrt(tx * tx + ty * ty + tz * tz)
                        else:
                            own = numbers[o, 0], numbers[o, 1], numbers[o, 2], numbers[o, 3], numbers[o, 4]
                            touches, depth, nx, ny, nz = near_shape(
                                kind[o], own, pose_of(pose, o), sx, sy, sz, tx, ty, tz
                            )
                        if touches:
                            geometry[o, 0], geometry[o, 1], geometry[o, 2], geometry[o, 3] = depth, nx, ny, nz
                    if touches and area[i] > 0.0:
                        near[pushers] = o
                        answer[o, 0] = answer[o, 1] = answer[o, 2] = 0.0
                        pushers += 1
                        touching[o, i] = True
                    elif touching[o, i]:
                        touching[o, i] = False
                        for k in range(3):
                            force[o, i, k] = 0.0
                            offset[o, i, k] = 0.0
                if pushers == 0:
                    continue
                for _ in range(SWEEPS if pushers > 1 else 1):
                    change, size = 0.0, 0.0
                    for m in range(pushers):
                        o = near[m]
                        rx, ry, rz = px - body[o, 0], py - body[o, 1], pz - body[o, 2]
                        # Without its own push, but with those of the others.
                        ux = velocities[i, 0] - half * answer[o, 0]
                        uy = velocities[i, 1] - half * answer[o, 1]
                        uz = velocities[i, 2] - half * answer[o, 2]
                        sx, sy, sz = into_space(pose_of(pose, o), offset[o, i, 0], offset[o, i, 1], offset[o, i, 2])
                        fx, fy, fz, sx, sy, sz, stored, lost, after = contact_force(
                            geometry[o, 0], geometry[o, 1], geometry[o, 2], geometry[o, 3],
                            ux - body[o, 3] - (body[o, 7] * rz - body[o, 8] * ry),
                            uy - body[o, 4] - (body[o, 8] * rx - body[o, 6] * rz),
                            uz - body[o, 5] - (body[o, 6] * ry - body[o, 7] * rx),
                            law[o, 0] * area[i], inverse_mass[i], law[o, 2], law[o, 1], sx, sy, sz, dt,
                        )  # fmt: skip
                        velocities[i, 0] = ux + half * fx
                        velocities[i, 1] = uy + half * fy
                        velocities[i, 2] = uz + half * fz
                        change += abs(fx - answer[o, 0]) + abs(fy - answer[o, 1]) + abs(fz - answer[o, 2])
                        size += abs(fx) + abs(fy) + abs(fz)
                        answer[o, 0], answer[o, 1], answer[o, 2] = fx, fy, fz
                        answer[o, 3], answer[o, 4], answer[o, 5] = sx, sy, sz
                        answer[o, 6], answer[o, 7], answer[o, 8] = stored, lost, after
                    if change <= SETTLED * size:
                        break
                for m in range(pushers):
                    o = near[m]
                    rx, ry, rz = px - body[o, 0], py - body[o, 1], pz - body[o, 2]
                    fx, fy, fz = answer[o, 0], answer[o, 1], answer[o, 2]
                    force[o, i, 0], force[o, i, 1], force[o, i, 2] = fx, fy, fz
                    # Kept in the shape's axes, where the sticking point rests.
                    sx, sy, sz = into_axes(pose_of(pose, o), answer[o, 3], answer[o, 4], answer[o, 5])
                    offset[o, i, 0], offset[o, i, 1], offset[o, i, 2] = sx, sy, sz
                    partial[chunk, o, 0] -= fx
                    partial[chunk, o, 1] -= fy
                    partial[chunk, o, 2] -= fz
                    partial[chunk, o, 3] -= ry * fz - rz * fy
                    partial[chunk, o, 4] -= rz * fx - rx * fz
                    partial[chunk, o, 5] -= rx * fy - ry * fx
                    partial[chunk, o, 6] += answer[o, 6]
                    partial[chunk, o, 7] += answer[o, 7]
                    partial[chunk, o, 8] = max(partial[chunk, o, 8], answer[o, 8])
                positions[i, 0] = px + dt * velocities[i, 0]
                positions[i, 1] = py + dt * velocities[i, 1]
                positions[i, 2] = pz + dt * velocities[i, 2]
    stored_out[:], dissipated_out[:], deepest_out[:], reaction_out[:] = 0.0, 0.0, 0.0, 0.0
    for chunk in range(chunks):
        for o in range(shapes):
            for k in range(6):
                reaction_out[o, k] += partial[chunk, o, k]
            stored_out[o] += partial[chunk, o, 6]
            dissipated_out[o] += partial[chunk, o, 7]
            deepest_out[o] = max(deepest_out[o], partial[chunk, o, 8])
