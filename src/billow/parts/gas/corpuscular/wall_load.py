"""The load on the fabric: the particles' impulses, patch by patch, and ambient pressure (docs/theory.md, Wall load)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar
from billow.geometry.triangle import cross, sides

PARTICLES_PER_PATCH = 150
"""Fewest particles beside a patch, unless the patch is a whole part."""

BLEED = 0.2e-3
"""Time constant [s] with which impulses that are left over are given to the fabric."""


@dataclass(frozen=True)
class Patches:
    """Groups of triangles that share a load.

    start: (patches + 1,) int64 and members: (triangles,) int64, the triangles of each patch.
    """

    start: np.ndarray
    members: np.ndarray

    @classmethod
    def of(cls, patch: np.ndarray) -> Patches:
        """From the patch of each triangle, integers from 0 on (triangles,)."""
        patch = (np.cumsum(np.bincount(patch) > 0) - 1)[patch]
        members = np.argsort(patch, kind="stable")
        start = np.concatenate([[0], np.cumsum(np.bincount(patch))])
        return cls(start.astype(np.int64), members.astype(np.int64))

    @property
    def count(self) -> int:
        return len(self.start) - 1


@dataclass(frozen=True)
class Squares:
    """Squares of the flat cut in levels, from whole parts down to two mesh edges, each within one part.

    levels: (levels, triangles) int64, the square of each triangle; each square is a quarter of one of the level above.
    """

    levels: np.ndarray

    @classmethod
    def of(cls, flat: np.ndarray, part: np.ndarray, edge: float) -> Squares:
        """flat: middle of each triangle in the flat cut [m], (triangles, 2); part: (triangles,); edge: mean edge
        [m]."""
        place = flat - flat.min(axis=0)
        side = float(place.max()) * (1.0 + 1e-9)
        levels, across = [], 1
        while side > 2.0 * edge or not levels:
            x, y = np.minimum((place / side).astype(np.int64), across - 1).T
            levels.append((part.astype(np.int64) * across + x) * across + y)
            side, across = 0.5 * side, 2 * across
        return cls(np.array(levels))

    def patches(self, beside: np.ndarray) -> np.ndarray:
        """Patch of each triangle, (triangles,) int64; beside: number of particles beside each triangle,
        (triangles,)."""
        patch, offset = self.levels[0].copy(), int(self.levels[0].max()) + 1
        splits = np.ones(len(patch), np.bool_)
        for coarse, fine in zip(self.levels[:-1], self.levels[1:], strict=True):
            poorest = np.full(int(coarse.max()) + 1, np.inf)
            np.minimum.at(poorest, coarse, np.bincount(fine, beside)[fine])
            splits &= poorest[coarse] >= PARTICLES_PER_PATCH
            if not splits.any():
                break
            patch[splits] = offset + fine[splits]
            offset += int(fine.max()) + 1
        return patch


@dataclass
class WallLoad:
    """held: impulse received and not given to the fabric yet [N s], (triangles, 3). force: on each triangle until the
    next gas step, before: in the last step, with the lead [N], (triangles, 3). given: impulse that structure and
    surroundings have taken so far [N s], (3,). work: done by the particles so far, and ambient_work: the part of it
    against the ambient pressure [J]."""

    held: np.ndarray
    force: np.ndarray
    before: np.ndarray
    given: np.ndarray
    work: float = 0.0
    ambient_work: float = 0.0

    @classmethod
    def none(cls, triangles: int) -> WallLoad:
        """No load."""
        return cls.of_pressure(np.zeros(triangles), np.zeros((triangles, 3)))

    @classmethod
    def of_pressure(cls, pressure: np.ndarray, normals: np.ndarray) -> WallLoad:
        """The load of a steady pressure [Pa] on each triangle, (triangles,); normals: area vectors [m^2]."""
        force = pressure[:, None] * normals
        return cls(np.zeros_like(force), force, force.copy(), np.zeros(3))

    def renew(self, patches: Patches, impulse: np.ndarray, normals: np.ndarray, span: float) -> None:
        """Take the impulses [N s] (triangles, 3, 3) of a gas step of `span` [s], which are then set to zero.

        normals: area vectors [m^2], (triangles, 3), of the present surface.
        """
        _renew(
            len(normals), patches.start, patches.members, impulse, normals, 1.0 / span, 1.0 / max(BLEED, 2.0 * span),
            self.held, self.force,
        )  # fmt: skip

    def push(
        self, solid: np.ndarray, ambient: np.ndarray, lead: np.ndarray, triangles: np.ndarray, positions: np.ndarray,
        velocities: np.ndarray, dt: float, corner_force: np.ndarray,
    ) -> float:  # fmt: skip
        """Add the forces of a step of dt [s] to corner_force [N] (triangles, 3, 3).

        solid: (triangles,) bool, false for holes. ambient: pressure on each triangle against its normal [Pa],
        (triangles,). lead: additional pressure on each triangle along its normal [Pa], (triangles,). positions [m] at
        the end of the step, velocities [m/s] at its middle. Returns the work [J] that the impulses still held would do
        at these velocities.
        """
        n = len(triangles)
        sums = np.empty((-(-n // CHUNK), 6))
        _push(
            n, triangles, positions, velocities, dt, solid, ambient, lead, self.before, self.force, self.held,
            corner_force, sums,
        )  # fmt: skip
        total = sums.sum(axis=0)
        self.given += total[:3]
        self.work += float(total[3])
        self.ambient_work += float(total[4])
        return float(total[5])


@kernel
def _renew(n, start, members, impulse, normals, rate, bleed, held, force_out):
    """n: triangles, which decide whether it runs in parallel."""
    for p in prange(len(start) - 1):
        gx, gy, gz, hx, hy, hz, nx, ny, nz, area, pressure = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for m in range(start[p], start[p + 1]):
            t = members[m]
            x, y, z = 0.0, 0.0, 0.0
            for c in range(3):
                x, y, z = x + impulse[t, c, 0], y + impulse[t, c, 1], z + impulse[t, c, 2]
                impulse[t, c, 0], impulse[t, c, 1], impulse[t, c, 2] = 0.0, 0.0, 0.0
            gx, gy, gz = gx + x, gy + y, gz + z
            hx, hy, hz = hx + held[t, 0], hy + held[t, 1], hz + held[t, 2]
            own = math.sqrt(normals[t, 0] ** 2 + normals[t, 1] ** 2 + normals[t, 2] ** 2)
            if own > 0.0:
                pressure += rate * (x * normals[t, 0] + y * normals[t, 1] + z * normals[t, 2]) / own
            nx, ny, nz = nx + normals[t, 0], ny + normals[t, 1], nz + normals[t, 2]
            area += own
        fx, fy, fz = rate * gx + bleed * hx, rate * gy + bleed * hy, rate * gz + bleed * hz
        gx, gy, gz = gx + hx, gy + hy, gz + hz
        pressure = pressure / area if area > 0.0 else 0.0
        fx, fy, fz = fx - pressure * nx, fy - pressure * ny, fz - pressure * nz
        last = members[start[p + 1] - 1]
        # The last triangle holds what rounding leaves, so that nothing is lost.
        hx, hy, hz = gx, gy, gz
        for m in range(start[p], start[p + 1]):
            t = members[m]
            own = math.sqrt(normals[t, 0] ** 2 + normals[t, 1] ** 2 + normals[t, 2] ** 2)
            share = own / area if area > 0.0 else 1.0 / (start[p + 1] - start[p])
            force_out[t, 0] = pressure * normals[t, 0] + share * fx
            force_out[t, 1] = pressure * normals[t, 1] + share * fy
            force_out[t, 2] = pressure * normals[t, 2] + share * fz
            if t != last:
                held[t, 0], held[t, 1], held[t, 2] = share * gx, share * gy, share * gz
                hx, hy, hz = hx - held[t, 0], hy - held[t, 1], hz - held[t, 2]
        held[last, 0], held[last, 1], held[last, 2] = hx, hy, hz


def wall_speed(patches: Patches, triangles: np.ndarray, start: np.ndarray, end: np.ndarray, span: float) -> np.ndarray:
    """Speed of each triangle along its normal [m/s], (triangles,), as the load of its patch feels it.

    start, end: node positions [m], (nodes, 3), of a gas step of `span` [s].
    """
    speed = np.empty(len(triangles))
    middle = 0.5 * (start + end)
    _wall_speed(len(triangles), patches.start, patches.members, triangles, start, end, middle, 1.0 / span, speed)
    return speed


@kernel
def _wall_speed(n, start, members, triangles, before, after, middle, rate, speed_out):
    """n: triangles, which decide whether it runs in parallel."""
    for p in prange(len(start) - 1):
        vx, vy, vz, nx, ny, nz, area, flux = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for m in range(start[p], start[p + 1]):
            a, b, c = triangles[members[m], 0], triangles[members[m], 1], triangles[members[m], 2]
            mx, my, mz = _area_vector(middle, a, b, c)
            own = math.sqrt(mx * mx + my * my + mz * mz)
            sx, sy = _mean_velocity(before, after, a, b, c, rate, 0), _mean_velocity(before, after, a, b, c, rate, 1)
            sz = _mean_velocity(before, after, a, b, c, rate, 2)
            vx, vy, vz = vx + own * sx, vy + own * sy, vz + own * sz
            nx, ny, nz = nx + mx, ny + my, nz + mz
            area += own
            flux += mx * sx + my * sy + mz * sz
        if area > 0.0:
            vx, vy, vz, flux = vx / area, vy / area, vz / area, flux / area
            flux -= (nx * vx + ny * vy + nz * vz) / area
        for m in range(start[p], start[p + 1]):
            t = members[m]
            mx, my, mz = _area_vector(middle, triangles[t, 0], triangles[t, 1], triangles[t, 2])
            own = math.sqrt(mx * mx + my * my + mz * mz)
            speed_out[t] = flux + (mx * vx + my * vy + mz * vz) / own if own > 0.0 else flux


@scalar
def _mean_velocity(before, after, a, b, c, rate, axis):
    """Mean velocity [m/s] of three nodes along an axis."""
    moved = after[a, axis] + after[b, axis] + after[c, axis] - before[a, axis] - before[b, axis] - before[c, axis]
    return rate * moved / 3.0


@scalar
def _area_vector(positions, a, b, c):
    """Normal times area [m^2] of the triangle of nodes a, b, c."""
    ux, uy, uz, wx, wy, wz = sides(positions, a, b, c)
    nx, ny, nz = cross(ux, uy, uz, wx, wy, wz)
    return 0.5 * nx, 0.5 * ny, 0.5 * nz


@kernel
def _push(
    n, triangles, positions, velocities, dt, solid, ambient, lead, before, force, held, corner_force, sums_out
):  # fmt: skip
    chunks = (n + CHUNK - 1) // CHUNK
    half = 0.5 * dt
    for chunk in prange(chunks):
        gx, gy, gz, work, against, waiting = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
            vx = (velocities[a, 0] + velocities[b, 0] + velocities[c, 0]) / 3.0
            vy = (velocities[a, 1] + velocities[b, 1] + velocities[c, 1]) / 3.0
            vz = (velocities[a, 2] + velocities[b, 2] + velocities[c, 2]) / 3.0
            ux, uy, uz, wx, wy, wz = sides(positions, a, b, c)
            nx, ny, nz = cross(ux, uy, uz, wx, wy, wz)
            nx, ny, nz = 0.5 * nx, 0.5 * ny, 0.5 * nz
            fx, fy, fz = force[i, 0] + lead[i] * nx, force[i, 1] + lead[i] * ny, force[i, 2] + lead[i] * nz
            x, y, z = half * (before[i, 0] + fx), half * (before[i, 1] + fy), half * (before[i, 2] + fz)
            before[i, 0], before[i, 1], before[i, 2] = fx, fy, fz
            gx, gy, gz = gx + x, gy + y, gz + z
            given = x * vx + y * vy + z * vz
            work += given
            held[i, 0], held[i, 1], held[i, 2] = held[i, 0] - x, held[i, 1] - y, held[i, 2] - z
            waiting += held[i, 0] * vx + held[i, 1] * vy + held[i, 2] * vz
            if not solid[i]:
                against += given
                continue
            outside = ambient[i]
            if outside != 0.0:
                fx, fy, fz = fx - outside * nx, fy - outside * ny, fz - outside * nz
                # At the beginning of the step: half of the force there acted over this motion, too.
                dux, duy, duz, dwx, dwy, dwz = sides(velocities, a, b, c)
                bx, by, bz = cross(
                    ux - dt * dux, uy - dt * duy, uz - dt * duz, wx - dt * dwx, wy - dt * dwy, wz - dt * dwz
                )
                against += half * outside * (nx + 0.5 * bx) * vx
                against += half * outside * (ny + 0.5 * by) * vy
                against += half * outside * (nz + 0.5 * bz) * vz
            fx, fy, fz = fx / 3.0, fy / 3.0, fz / 3.0
            for k in range(3):
                corner_force[i, k, 0] += fx
                corner_force[i, k, 1] += fy
                corner_force[i, k, 2] += fz
        sums_out[chunk, 0], sums_out[chunk, 1], sums_out[chunk, 2] = gx, gy, gz
        sums_out[chunk, 3], sums_out[chunk, 4], sums_out[chunk, 5] = work, against, waiting
