"""Fabric nodes against rigid obstacles: a plate (half space) and a super-ellipsoid.

An obstacle is a shape, a surface law and a rigid body. Over a step every fabric node near it gets an average contact
force (`penalty`), half of whose impulse is added to its velocity at once, so that the velocity it drifts with is the
mean of before and after; the other half follows after the drift. What acts back on the body is collected per fixed
chunk.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.compiled import CHUNK, kernel
from billow.contact.penalty import A_REFERENCE, contact_force
from billow.geometry.super_ellipsoid import closest_point, radial_measure


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
    """Of one obstacle. force: average over the last step on each fabric node, [N], (nodes, 3). offset: from the
    sticking point, [m], (nodes, 3), in the body's axes. stored: energy in the contact springs [J]; dissipated: in the
    last step [J]; deepest: penetration [m]."""

    force: np.ndarray
    offset: np.ndarray
    stored: float = 0.0
    dissipated: float = 0.0
    deepest: float = 0.0


def push(
    shape: Plate | SuperEllipsoid, law: SurfaceLaw, area: np.ndarray, inverse_mass: np.ndarray,
    centre: np.ndarray, rotation: np.ndarray, velocity: np.ndarray, spin: np.ndarray,
    positions: np.ndarray, velocities: np.ndarray, dt: float, contact: ContactState,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Contact of all fabric nodes with one obstacle over a step of dt [s]; fills `contact` and adds half of each
    impulse to velocities [m/s] (nodes, 3).

    area [m^2] and inverse_mass [1/kg]: (nodes,). centre [m], rotation (3, 3) body to space, velocity [m/s], spin
    [rad/s] of the obstacle, positions [m] (nodes, 3), all at the start of the step. Returns force [N] (3,) and torque
    [N m] (3,) on the obstacle about its centre.
    """
    n = len(positions)
    partial = np.empty((-(-n // CHUNK), 9))
    common = (
        centre, rotation, velocity, spin, law.slope / A_REFERENCE, law.friction, law.damping,
        area, inverse_mass, positions, velocities, dt, contact.offset, contact.force, partial,
    )  # fmt: skip
    if isinstance(shape, Plate):
        _plate_contact(n, shape.normal, *common)
    else:
        _super_ellipsoid_contact(n, shape.radii, shape.degree, *common)
    total = partial.sum(axis=0)
    contact.stored, contact.dissipated = float(total[6]), float(total[7])
    contact.deepest = float(partial[:, 8].max())
    return total[:3], total[3:6]


@kernel
def _plate_contact(
    n, normal, centre, rotation, velocity, spin, slope, friction, damping, area, inverse_mass, positions, velocities,
    dt, offset, force_out, partial_out,
):  # fmt: skip
    nx, ny, nz = normal[0], normal[1], normal[2]
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        fx, fy, fz, tx, ty, tz, stored, lost, deepest = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            rx, ry, rz = positions[i, 0] - centre[0], positions[i, 1] - centre[1], positions[i, 2] - centre[2]
            ux, uy, uz = velocities[i, 0] - velocity[0], velocities[i, 1] - velocity[1], velocities[i, 2] - velocity[2]
            depth = -(rx * nx + ry * ny + rz * nz)
            if max(depth, depth - dt * (ux * nx + uy * ny + uz * nz)) <= 0.0 or area[i] == 0.0:
                for k in range(3):
                    force_out[i, k] = 0.0
                    offset[i, k] = 0.0
                continue
            px, py, pz, sx, sy, sz, energy, heat, after = contact_force(
                depth, nx, ny, nz, ux, uy, uz, slope * area[i], inverse_mass[i], damping, friction,
                offset[i, 0], offset[i, 1], offset[i, 2], dt,
            )  # fmt: skip
            offset[i, 0], offset[i, 1], offset[i, 2] = sx, sy, sz
            force_out[i, 0], force_out[i, 1], force_out[i, 2] = px, py, pz
            half = 0.5 * dt * inverse_mass[i]
            velocities[i, 0] += half * px
            velocities[i, 1] += half * py
            velocities[i, 2] += half * pz
            fx, fy, fz = fx - px, fy - py, fz - pz
            tx, ty, tz = tx - (ry * pz - rz * py), ty - (rz * px - rx * pz), tz - (rx * py - ry * px)
            stored += energy
            lost += heat
            deepest = max(deepest, after)
        out = partial_out[chunk]
        out[0], out[1], out[2], out[3], out[4], out[5] = fx, fy, fz, tx, ty, tz
        out[6], out[7], out[8] = stored, lost, deepest


@kernel
def _super_ellipsoid_contact(
    n, radii, degree, centre, rotation, velocity, spin, slope, friction, damping, area, inverse_mass, positions,
    velocities, dt, offset, force_out, partial_out,
):  # fmt: skip
    a, b, c = radii[0], radii[1], radii[2]
    smallest = min(a, b, c)
    flattest = 3.0 ** (1.0 / degree - 0.5)
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        fx, fy, fz, tx, ty, tz, stored, lost, deepest = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            rx, ry, rz = positions[i, 0] - centre[0], positions[i, 1] - centre[1], positions[i, 2] - centre[2]
            ux = velocities[i, 0] - velocity[0] - (spin[1] * rz - spin[2] * ry)
            uy = velocities[i, 1] - velocity[1] - (spin[2] * rx - spin[0] * rz)
            uz = velocities[i, 2] - velocity[2] - (spin[0] * ry - spin[1] * rx)
            reach = dt * np.sqrt(ux * ux + uy * uy + uz * uz)
            x = rotation[0, 0] * rx + rotation[1, 0] * ry + rotation[2, 0] * rz
            y = rotation[0, 1] * rx + rotation[1, 1] * ry + rotation[2, 1] * rz
            z = rotation[0, 2] * rx + rotation[1, 2] * ry + rotation[2, 2] * rz
            # G is convex with slope at most 1/smallest, so (G - 1) smallest is a lower bound of the distance. Powers
            # are spared where the box or the enclosing and enclosed ellipsoids (norm inequalities, n >= 2) decide.
            near = 1.0 + reach / smallest
            outside = abs(x) >= near * a or abs(y) >= near * b or abs(z) >= near * c or area[i] == 0.0
            if not outside:
                ellipsoid = np.sqrt((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2)
                outside = flattest * ellipsoid >= near
                if not outside and ellipsoid > 1.0:
                    outside = radial_measure(x, y, z, a, b, c, degree) >= near
            if outside:
                for k in range(3):
                    force_out[i, k] = 0.0
                    offset[i, k] = 0.0
                continue
            qx, qy, qz, mx, my, mz = closest_point(x, y, z, a, b, c, degree)
            depth = (qx - x) * mx + (qy - y) * my + (qz - z) * mz
            # In the body's axes, where the sticking point rests.
            px, py, pz, sx, sy, sz, energy, heat, after = contact_force(
                depth, mx, my, mz,
                rotation[0, 0] * ux + rotation[1, 0] * uy + rotation[2, 0] * uz,
                rotation[0, 1] * ux + rotation[1, 1] * uy + rotation[2, 1] * uz,
                rotation[0, 2] * ux + rotation[1, 2] * uy + rotation[2, 2] * uz,
                slope * area[i], inverse_mass[i], damping, friction, offset[i, 0], offset[i, 1], offset[i, 2], dt,
            )  # fmt: skip
            offset[i, 0], offset[i, 1], offset[i, 2] = sx, sy, sz
            gx = rotation[0, 0] * px + rotation[0, 1] * py + rotation[0, 2] * pz
            gy = rotation[1, 0] * px + rotation[1, 1] * py + rotation[1, 2] * pz
            gz = rotation[2, 0] * px + rotation[2, 1] * py + rotation[2, 2] * pz
            force_out[i, 0], force_out[i, 1], force_out[i, 2] = gx, gy, gz
            half = 0.5 * dt * inverse_mass[i]
            velocities[i, 0] += half * gx
            velocities[i, 1] += half * gy
            velocities[i, 2] += half * gz
            fx, fy, fz = fx - gx, fy - gy, fz - gz
            tx, ty, tz = tx - (ry * gz - rz * gy), ty - (rz * gx - rx * gz), tz - (rx * gy - ry * gx)
            stored += energy
            lost += heat
            deepest = max(deepest, after)
        out = partial_out[chunk]
        out[0], out[1], out[2], out[3], out[4], out[5] = fx, fy, fz, tx, ty, tz
        out[6], out[7], out[8] = stored, lost, deepest
