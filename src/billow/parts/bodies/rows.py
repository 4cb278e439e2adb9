"""Fabric nodes against the shapes of rigid bodies, solved together with what else changes velocities before the drift.

Contact between layers of fabric and contact with bodies push the same nodes. A spring that was solved for a motion that
did not come gives energy to nobody, so bodies take part in the sweeps: whenever another contact has changed a node, its
pushes are solved anew, each an average over the step that is a function of where the node really goes.
"""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, spliced
from billow.geometry.shapes.kinds import MESH, near_shape
from billow.geometry.shapes.pose import into_axes, into_space, pose_of
from billow.parts.bodies.contact import ContactState, Nodes, ShapeMotion, ShapeTable
from billow.parts.bodies.contact_block import (
    BLOCK,
    CLOSE,
    ROWS,
    SETTLED,
    SWEEPS,
    VX,
    VY,
    VZ,
    ask_block,
    kick_block,
)
from billow.parts.bodies.penalty import contact_force


class BodyRows:
    """The pushes of all shapes on all nodes over a step of dt [s], which begins with half a kick of the nodes.

    contact: that of the step before, which becomes that of this one. Velocities are those of the nodes in the middle of
    the step, with half of each push.
    """

    def __init__(
        self, table: ShapeTable, motion: ShapeMotion, area: np.ndarray, nodes: Nodes, dt: float, contact: ContactState
    ):
        self._table, self._motion, self._area = table, motion, area
        self._nodes, self._dt, self._contact = nodes, dt, contact
        self._old_offset = contact.offset.copy()
        self._kicked, self._settled_at = np.empty_like(nodes.velocities), np.empty_like(nodes.velocities)
        _begin(
            len(nodes.velocities), table.bound, tuple(motion), tuple(nodes), dt, contact.touching, contact.force,
            self._kicked, self._settled_at,
        )  # fmt: skip
        self.settle()

    def __len__(self) -> int:
        """Shapes that push."""
        return len(self._table.kind)

    def restart(self) -> None:
        """Take back whatever changed velocities since the half kick, and solve for bodies alone."""
        self._nodes.velocities[...] = self._kicked
        if len(self._table.kind):
            self._contact.force[...] = 0.0
            self._settled_at[...] = np.nan
            self.settle()

    def settle(self) -> float:
        """Solve the pushes on nodes that something else has changed; returns the largest change of a node's velocity
        [m/s]."""
        if not len(self._table.kind):
            return 0.0
        nodes, contact = self._nodes, self._contact
        changes = np.empty(-(-len(nodes.velocities) // CHUNK))
        _settle(
            len(nodes.velocities), tuple(self._table), tuple(self._motion), self._area, nodes.inverse_mass,
            nodes.positions, self._dt, self._old_offset, nodes.velocities, self._settled_at, contact.force,
            contact.offset, contact.touching, changes,
        )  # fmt: skip
        return float(changes.max())

    def before_others(self) -> np.ndarray:
        """Velocities [m/s] that the nodes would have with the pushes as they are and nothing else, (nodes, 3)."""
        nodes = self._nodes
        return self._kicked + (0.5 * self._dt * nodes.inverse_mass)[:, None] * self._contact.force.sum(axis=0)

    def pull(self) -> np.ndarray:
        """Accelerations of the half kick and of the pushes [m/s^2], (nodes, 3)."""
        nodes = self._nodes
        return nodes.inverse_mass[:, None] * (nodes.force + self._contact.force.sum(axis=0))

    def drift(self) -> np.ndarray:
        """Move the nodes, and say in `contact` what the springs hold and took; returns (shapes, 6): force [N] and
        torque about the centre of the body [N m] that each shape receives."""
        nodes, contact = self._nodes, self._contact
        reaction = np.zeros((len(self._table.kind), 6))
        if len(reaction):
            _close(
                len(nodes.velocities), tuple(self._table), tuple(self._motion), self._area, nodes.positions,
                nodes.velocities, self._dt, self._old_offset, contact.force, contact.offset, contact.touching,
                contact.stored, contact.dissipated, contact.deepest, reaction,
            )  # fmt: skip
        positions = nodes.positions
        positions += self._dt * nodes.velocities
        return reaction


@spliced
def reaches(o, i, px, py, pz, vx, vy, vz, dt, table, motion, geometry):
    """Whether node i at p [m] with the velocity v [m/s] comes to shape o in a step of dt [s]; if so, row o of geometry
    gets depth [m] and normal."""
    kind, numbers, bound, _ = table
    body, centre, pose, met = motion
    rx, ry, rz = px - body[o, 0], py - body[o, 1], pz - body[o, 2]
    tx = dt * (vx - body[o, 3] - (body[o, 7] * rz - body[o, 8] * ry))
    ty = dt * (vy - body[o, 4] - (body[o, 8] * rx - body[o, 6] * rz))
    tz = dt * (vz - body[o, 5] - (body[o, 6] * ry - body[o, 7] * rx))
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
            touches, depth, nx, ny, nz = near_shape(kind[o], own, pose_of(pose, o), sx, sy, sz, tx, ty, tz)
        if touches:
            geometry[o, 0], geometry[o, 1], geometry[o, 2], geometry[o, 3] = depth, nx, ny, nz
    return touches


@spliced
def push_node(
    i, px, py, pz, vx, vy, vz, area, inverse_mass, dt, count, near, geometry, table, motion, offset, answer
):  # fmt: skip
    """The velocity [m/s] of node i with half of the pushes of `count` shapes, without which it is v. offset: from the
    sticking points before [m], (shapes, nodes, 3). answer: (shapes, 9), its first three numbers zero; gets each push
    [N], the new offset in space [m], stored and lost energy [J] and the depth afterwards [m]."""
    law = table[3]
    body, _, pose, _ = motion
    half = 0.5 * dt * inverse_mass
    wx, wy, wz = vx, vy, vz
    for _ in range(SWEEPS if count > 1 else count):
        change, size = 0.0, 0.0
        for m in range(count):
            o = near[m]
            rx, ry, rz = px - body[o, 0], py - body[o, 1], pz - body[o, 2]
            # Without its own push, but with those of the others.
            ux, uy, uz = wx - half * answer[o, 0], wy - half * answer[o, 1], wz - half * answer[o, 2]
            sx, sy, sz = into_space(pose_of(pose, o), offset[o, i, 0], offset[o, i, 1], offset[o, i, 2])
            fx, fy, fz, sx, sy, sz, stored, lost, after = contact_force(
                geometry[o, 0], geometry[o, 1], geometry[o, 2], geometry[o, 3],
                ux - body[o, 3] - (body[o, 7] * rz - body[o, 8] * ry),
                uy - body[o, 4] - (body[o, 8] * rx - body[o, 6] * rz),
                uz - body[o, 5] - (body[o, 6] * ry - body[o, 7] * rx),
                law[o, 0] * area, inverse_mass, law[o, 2], law[o, 1], sx, sy, sz, dt,
            )  # fmt: skip
            wx, wy, wz = ux + half * fx, uy + half * fy, uz + half * fz
            change += abs(fx - answer[o, 0]) + abs(fy - answer[o, 1]) + abs(fz - answer[o, 2])
            size += abs(fx) + abs(fy) + abs(fz)
            answer[o, 0], answer[o, 1], answer[o, 2] = fx, fy, fz
            answer[o, 3], answer[o, 4], answer[o, 5] = sx, sy, sz
            answer[o, 6], answer[o, 7], answer[o, 8] = stored, lost, after
        if change <= SETTLED * size:
            break
    return wx, wy, wz


@kernel
def _begin(n, bound, motion, nodes, dt, touching, force_out, kicked_out, settled_out):
    """Half a kick of the nodes. Those that go on as they are and come to no shape are settled by that; others have
    been nowhere, and pushes on them are taken back."""
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        block = np.zeros(ROWS * BLOCK)
        for first in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK), BLOCK):
            count = min(BLOCK, n - first)
            kick_block(block, first, count, dt, nodes)
            ask_block(block, first, count, dt, bound, motion, touching)
            for j in range(count):
                i, close = first + j, block[CLOSE + j] > 0.0
                vx, vy, vz = block[VX + j], block[VY + j], block[VZ + j]
                kicked_out[i, 0], kicked_out[i, 1], kicked_out[i, 2] = vx, vy, vz
                settled_out[i, 0] = np.nan if close else vx
                settled_out[i, 1], settled_out[i, 2] = vy, vz
                if close:
                    for o in range(len(bound)):
                        force_out[o, i, 0] = force_out[o, i, 1] = force_out[o, i, 2] = 0.0


@kernel
def _settle(
    n, table, motion, area, inverse_mass, positions, dt, old_offset, velocities, settled_at, force, offset, touching,
    change_out,
):  # fmt: skip
    pose, shapes = motion[2], len(table[0])
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        near = np.empty(shapes, dtype=np.int64)
        geometry, answer = np.empty((shapes, 4)), np.empty((shapes, 9))  # depth and normal; as of `push_node`
        largest = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            vx, vy, vz = velocities[i, 0], velocities[i, 1], velocities[i, 2]
            if vx == settled_at[i, 0] and vy == settled_at[i, 1] and vz == settled_at[i, 2]:
                continue
            px, py, pz = positions[i, 0], positions[i, 1], positions[i, 2]
            half = 0.5 * dt * inverse_mass[i]
            ux, uy, uz = vx, vy, vz
            for o in range(shapes):  # without any push
                if touching[o, i]:
                    ux -= half * force[o, i, 0]
                    uy -= half * force[o, i, 1]
                    uz -= half * force[o, i, 2]
            count = 0
            for o in range(shapes):
                touches = area[i] > 0.0 and reaches(o, i, px, py, pz, ux, uy, uz, dt, table, motion, geometry)
                if touches:
                    near[count] = o
                    count += 1
                    answer[o, 0] = answer[o, 1] = answer[o, 2] = 0.0
                elif touching[o, i]:
                    for k in range(3):
                        force[o, i, k] = offset[o, i, k] = 0.0
                touching[o, i] = touches
            wx, wy, wz = push_node(
                i, px, py, pz, ux, uy, uz, area[i], inverse_mass[i], dt, count, near, geometry, table, motion,
                old_offset, answer,
            )  # fmt: skip
            for m in range(count):
                o = near[m]
                sx, sy, sz = into_axes(pose_of(pose, o), answer[o, 3], answer[o, 4], answer[o, 5])
                offset[o, i, 0], offset[o, i, 1], offset[o, i, 2] = sx, sy, sz
                for k in range(3):
                    force[o, i, k] = answer[o, k]
            largest = max(largest, abs(wx - vx), abs(wy - vy), abs(wz - vz))
            velocities[i, 0], velocities[i, 1], velocities[i, 2] = wx, wy, wz
            settled_at[i, 0], settled_at[i, 1], settled_at[i, 2] = wx, wy, wz
        change_out[chunk] = largest


@kernel
def _close(
    n, table, motion, area, positions, velocities, dt, old_offset, force, offset, touching, stored_out, dissipated_out,
    deepest_out, reaction_out,
):  # fmt: skip
    """What the springs hold at the end of the step and what was lost, from the pushes and the way that nodes go."""
    kind, numbers, _, law = table
    body, centre, pose, met = motion
    chunks, shapes = (n + CHUNK - 1) // CHUNK, len(kind)
    partial = np.zeros((chunks, shapes, 9))  # reaction, stored, dissipated, deepest
    for chunk in prange(chunks):
        for o in range(shapes):
            for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
                if not touching[o, i]:
                    continue
                rx, ry, rz = positions[i, 0] - body[o, 0], positions[i, 1] - body[o, 1], positions[i, 2] - body[o, 2]
                tx = dt * (velocities[i, 0] - body[o, 3] - (body[o, 7] * rz - body[o, 8] * ry))
                ty = dt * (velocities[i, 1] - body[o, 4] - (body[o, 8] * rx - body[o, 6] * rz))
                tz = dt * (velocities[i, 2] - body[o, 5] - (body[o, 6] * ry - body[o, 7] * rx))
                if kind[o] == MESH:
                    depth, nx, ny, nz = met[o, i, 0], met[o, i, 1], met[o, i, 2], met[o, i, 3]
                else:
                    own = numbers[o, 0], numbers[o, 1], numbers[o, 2], numbers[o, 3], numbers[o, 4]
                    sx, sy, sz = rx - centre[o, 0], ry - centre[o, 1], rz - centre[o, 2]
                    _, depth, nx, ny, nz = near_shape(kind[o], own, pose_of(pose, o), sx, sy, sz, tx, ty, tz)
                after = depth - (tx * nx + ty * ny + tz * nz)
                fx, fy, fz = force[o, i, 0], force[o, i, 1], force[o, i, 2]
                old, new = max(0.0, depth) ** 2, max(0.0, after) ** 2
                for k in range(3):
                    old += old_offset[o, i, k] ** 2
                    new += offset[o, i, k] ** 2
                stiffness = law[o, 0] * area[i]
                partial[chunk, o, 0] -= fx
                partial[chunk, o, 1] -= fy
                partial[chunk, o, 2] -= fz
                partial[chunk, o, 3] -= ry * fz - rz * fy
                partial[chunk, o, 4] -= rz * fx - rx * fz
                partial[chunk, o, 5] -= rx * fy - ry * fx
                partial[chunk, o, 6] += 0.5 * stiffness * new
                partial[chunk, o, 7] -= fx * tx + fy * ty + fz * tz + 0.5 * stiffness * (new - old)
                partial[chunk, o, 8] = max(partial[chunk, o, 8], after)
    stored_out[:], dissipated_out[:], deepest_out[:], reaction_out[:] = 0.0, 0.0, 0.0, 0.0
    for chunk in range(chunks):
        for o in range(shapes):
            for k in range(6):
                reaction_out[o, k] += partial[chunk, o, k]
            stored_out[o] += partial[chunk, o, 6]
            dissipated_out[o] += partial[chunk, o, 7]
            deepest_out[o] = max(deepest_out[o], partial[chunk, o, 8])
