"""Fabric nodes against rigid obstacles: a plate (half space) and a super-ellipsoid.

An obstacle is a shape, a surface law and a rigid body. Over a step every fabric node near it gets an average contact
force (`penalty`), half of whose impulse is added to its velocity at once, so that the velocity it drifts with is the
mean of before and after; the other half follows after the drift. What acts back on the body is collected per fixed
chunk.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar
from billow.geometry.shapes.super_ellipsoid import closest_point, radial_measure
from billow.parts.bodies.penalty import A_REFERENCE, contact_force


@dataclass(frozen=True)
class SurfaceLaw:
    """slope: force per penetration of a node with 1e-4 m^2 of fabric [N/m]; friction [-]; damping: of critical [-]."""

    slope: float
    friction: float
    damping: float


@dataclass(frozen=True)
class Plate:
    """Half space below a plane: normal (3,), unit, pointing to the free side."""

    normal: np.ndarray


@dataclass(frozen=True)
class SuperEllipsoid:
    """|x/a|^n + |y/b|^n + |z/c|^n <= 1: radii (a, b, c) [m], (3,), degree n [-]."""

    radii: np.ndarray
    degree: float


@dataclass
class ContactState:
    """Of all obstacles. force: average over the last step on each fabric node, [N], (obstacles, nodes, 3). offset: from
    the sticking point, [m], (obstacles, nodes, 3), in each body's axes. stored: energy in the contact springs [J];
    dissipated: in the last step [J]; deepest: penetration [m]; all three (obstacles,)."""

    force: np.ndarray
    offset: np.ndarray
    touching: np.ndarray
    stored: np.ndarray
    dissipated: np.ndarray
    deepest: np.ndarray

    @classmethod
    def none(cls, obstacles: int, nodes: int) -> ContactState:
        """Nothing touches."""
        field, sums = np.zeros((obstacles, nodes, 3)), np.zeros(obstacles)
        return cls(field, field.copy(), np.zeros((obstacles, nodes), np.bool_), sums, sums.copy(), sums.copy())


SWEEPS, SETTLED = 100, 1e-10
"""Most sweeps over the obstacles that pinch a node, and the relative change of force at which they end."""

PLATE, SUPER_ELLIPSOID = 0, 1


@dataclass(frozen=True)
class ObstacleTable:
    """What kernels need of all obstacles and never changes; every array has one row per obstacle.

    kind: PLATE or SUPER_ELLIPSOID. vector: plate normal, or radii [m], (obstacles, 3). degree. flattest: an ellipsoid
    larger by 1/flattest holds the body. bound: radius of a sphere around it [m]. law: slope per fabric area [N/m^3],
    friction [-], damping [-], (obstacles, 3).
    """

    kind: np.ndarray
    vector: np.ndarray
    degree: np.ndarray
    flattest: np.ndarray
    bound: np.ndarray
    law: np.ndarray

    @classmethod
    def build(cls, shapes: Sequence[Plate | SuperEllipsoid], laws: Sequence[SurfaceLaw]) -> ObstacleTable:
        plates = [isinstance(shape, Plate) for shape in shapes]
        degree = np.array([2.0 if plate else s.degree for s, plate in zip(shapes, plates, strict=True)])
        vector = np.array(
            [s.normal if plate else s.radii for s, plate in zip(shapes, plates, strict=True)], dtype=float
        )
        vector = vector.reshape(-1, 3)
        flattest = 3.0 ** (1.0 / degree - 0.5)
        return cls(
            kind=np.array([PLATE if plate else SUPER_ELLIPSOID for plate in plates], dtype=np.int64),
            degree=degree,
            flattest=flattest,
            bound=vector.max(axis=1, initial=0.0) / flattest,
            vector=vector,
            law=np.array([(law.slope / A_REFERENCE, law.friction, law.damping) for law in laws]).reshape(-1, 3),
        )


def push(
    table: ObstacleTable, motion: np.ndarray, area: np.ndarray, inverse_mass: np.ndarray,
    positions: np.ndarray, velocities: np.ndarray, dt: float, contact: ContactState,
) -> np.ndarray:  # fmt: skip
    """Contact of all fabric nodes with all obstacles over a step of dt [s]; fills `contact` and adds half of each
    impulse to velocities [m/s] (nodes, 3).

    motion: (obstacles, 18), of each obstacle centre [m], velocity [m/s], spin [rad/s] and rotation body to space, row
    by row. area [m^2] and inverse_mass [1/kg]: (nodes,). positions [m]: (nodes, 3), at the start of the step. Returns
    (obstacles, 6): force [N] and torque about its centre [N m] on each obstacle.
    """
    reaction = np.empty((len(table.kind), 6))
    _push(
        len(positions), table.kind, table.vector, table.degree, table.flattest, table.bound, table.law, motion, area,
        inverse_mass, positions, velocities, dt, contact.offset, contact.force, contact.touching, contact.stored,
        contact.dissipated, contact.deepest, reaction,
    )  # fmt: skip
    return reaction


@scalar
def _near_super_ellipsoid(o, radii, degree, flattest, motion, rx, ry, rz, reach):
    """Whether a node at r from the centre of obstacle o may touch it, and how: (near, depth, outward normal (3))."""
    a, b, c = radii[o, 0], radii[o, 1], radii[o, 2]
    x = motion[o, 9] * rx + motion[o, 12] * ry + motion[o, 15] * rz
    y = motion[o, 10] * rx + motion[o, 13] * ry + motion[o, 16] * rz
    z = motion[o, 11] * rx + motion[o, 14] * ry + motion[o, 17] * rz
    # G is convex with slope at most 1/smallest, so (G - 1) smallest is a lower bound of the distance. Powers are spared
    # where the box or the enclosing and enclosed ellipsoids (norm inequalities, n >= 2) decide.
    near = 1.0 + reach / min(a, b, c)
    if abs(x) >= near * a or abs(y) >= near * b or abs(z) >= near * c:
        return False, 0.0, 0.0, 0.0, 0.0
    ellipsoid = np.sqrt((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2)
    if ellipsoid > 1.0 and (flattest[o] * ellipsoid >= near or radial_measure(x, y, z, a, b, c, degree[o]) >= near):
        return False, 0.0, 0.0, 0.0, 0.0
    qx, qy, qz, mx, my, mz = closest_point(x, y, z, a, b, c, degree[o])
    depth = (qx - x) * mx + (qy - y) * my + (qz - z) * mz
    nx = motion[o, 9] * mx + motion[o, 10] * my + motion[o, 11] * mz
    ny = motion[o, 12] * mx + motion[o, 13] * my + motion[o, 14] * mz
    nz = motion[o, 15] * mx + motion[o, 16] * my + motion[o, 17] * mz
    return True, depth, nx, ny, nz


@kernel
def _push(
    n, kind, vector, degree, flattest, bound, law, motion, area, inverse_mass, positions, velocities, dt, offset, force,
    touching, stored_out, dissipated_out, deepest_out, reaction_out,
):  # fmt: skip
    chunks, obstacles = (n + CHUNK - 1) // CHUNK, len(kind)
    partial = np.empty((chunks, obstacles, 9))  # reaction, stored, dissipated, deepest
    for chunk in prange(chunks):
        partial[chunk] = 0.0
        near = np.empty(obstacles, dtype=np.int64)
        geometry = np.empty((obstacles, 4))  # depth and normal
        answer = np.empty((obstacles, 9))  # force, new offset in space, stored, dissipated, depth after
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            px, py, pz = positions[i, 0], positions[i, 1], positions[i, 2]
            count = 0
            for o in range(obstacles):
                # The cheap questions first: which side of the plate, within the sphere around the body?
                rx, ry, rz = px - motion[o, 0], py - motion[o, 1], pz - motion[o, 2]
                ux = velocities[i, 0] - motion[o, 3] - (motion[o, 7] * rz - motion[o, 8] * ry)
                uy = velocities[i, 1] - motion[o, 4] - (motion[o, 8] * rx - motion[o, 6] * rz)
                uz = velocities[i, 2] - motion[o, 5] - (motion[o, 6] * ry - motion[o, 7] * rx)
                depth, nx, ny, nz = 0.0, vector[o, 0], vector[o, 1], vector[o, 2]
                if kind[o] == PLATE:
                    depth = -(rx * nx + ry * ny + rz * nz)
                    touches = max(depth, depth - dt * (ux * nx + uy * ny + uz * nz)) > 0.0
                else:
                    reach = dt * np.sqrt(ux * ux + uy * uy + uz * uz)
                    touches = rx * rx + ry * ry + rz * rz < (bound[o] + reach) ** 2
                    if touches:
                        touches, depth, nx, ny, nz = _near_super_ellipsoid(
                            o, vector, degree, flattest, motion, rx, ry, rz, reach
                        )
                if touches and area[i] > 0.0:
                    near[count] = o
                    geometry[o, 0], geometry[o, 1], geometry[o, 2], geometry[o, 3] = depth, nx, ny, nz
                    answer[o, 0] = answer[o, 1] = answer[o, 2] = 0.0
                    count += 1
                    touching[o, i] = True
                elif touching[o, i]:
                    touching[o, i] = False
                    for k in range(3):
                        force[o, i, k] = 0.0
                        offset[o, i, k] = 0.0
            if count == 0:
                continue
            half = 0.5 * dt * inverse_mass[i]
            for _ in range(SWEEPS if count > 1 else 1):
                change, size = 0.0, 0.0
                for m in range(count):
                    o = near[m]
                    rx, ry, rz = px - motion[o, 0], py - motion[o, 1], pz - motion[o, 2]
                    # Without its own push, but with those of the others.
                    ux = velocities[i, 0] - half * answer[o, 0]
                    uy = velocities[i, 1] - half * answer[o, 1]
                    uz = velocities[i, 2] - half * answer[o, 2]
                    sx, sy, sz = offset[o, i, 0], offset[o, i, 1], offset[o, i, 2]
                    fx, fy, fz, sx, sy, sz, stored, lost, after = contact_force(
                        geometry[o, 0], geometry[o, 1], geometry[o, 2], geometry[o, 3],
                        ux - motion[o, 3] - (motion[o, 7] * rz - motion[o, 8] * ry),
                        uy - motion[o, 4] - (motion[o, 8] * rx - motion[o, 6] * rz),
                        uz - motion[o, 5] - (motion[o, 6] * ry - motion[o, 7] * rx),
                        law[o, 0] * area[i], inverse_mass[i], law[o, 2], law[o, 1],
                        motion[o, 9] * sx + motion[o, 10] * sy + motion[o, 11] * sz,
                        motion[o, 12] * sx + motion[o, 13] * sy + motion[o, 14] * sz,
                        motion[o, 15] * sx + motion[o, 16] * sy + motion[o, 17] * sz,
                        dt,
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
            for m in range(count):
                o = near[m]
                rx, ry, rz = px - motion[o, 0], py - motion[o, 1], pz - motion[o, 2]
                fx, fy, fz = answer[o, 0], answer[o, 1], answer[o, 2]
                sx, sy, sz = answer[o, 3], answer[o, 4], answer[o, 5]
                force[o, i, 0], force[o, i, 1], force[o, i, 2] = fx, fy, fz
                # Kept in the body's axes, where the sticking point rests.
                offset[o, i, 0] = motion[o, 9] * sx + motion[o, 12] * sy + motion[o, 15] * sz
                offset[o, i, 1] = motion[o, 10] * sx + motion[o, 13] * sy + motion[o, 16] * sz
                offset[o, i, 2] = motion[o, 11] * sx + motion[o, 14] * sy + motion[o, 17] * sz
                partial[chunk, o, 0] -= fx
                partial[chunk, o, 1] -= fy
                partial[chunk, o, 2] -= fz
                partial[chunk, o, 3] -= ry * fz - rz * fy
                partial[chunk, o, 4] -= rz * fx - rx * fz
                partial[chunk, o, 5] -= rx * fy - ry * fx
                partial[chunk, o, 6] += answer[o, 6]
                partial[chunk, o, 7] += answer[o, 7]
                partial[chunk, o, 8] = max(partial[chunk, o, 8], answer[o, 8])
    stored_out[:], dissipated_out[:], deepest_out[:], reaction_out[:] = 0.0, 0.0, 0.0, 0.0
    for chunk in range(chunks):
        for o in range(obstacles):
            for k in range(6):
                reaction_out[o, k] += partial[chunk, o, k]
            stored_out[o] += partial[chunk, o, 6]
            dissipated_out[o] += partial[chunk, o, 7]
            deepest_out[o] = max(deepest_out[o], partial[chunk, o, 8])
