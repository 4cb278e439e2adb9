"""Momentum of the inflator's jets, for gas models that do not resolve the flow.

Each hole of the ring blows an axisymmetric turbulent jet: on its axis u = u0 min(1, 6 d / s), across it a Gaussian of
radius 0.11 s, at distance s along the axis (physics notes, section 1; the LS-DYNA hybrid-jetting model rests on the
same profile). It presses on fabric in its line of sight with rho u^2 cos^2(angle to the normal). The profile is
scaled so that the force along each jet's axis equals its thrust mdot u0; a jet that sees no fabric delivers nothing,
and both sums are booked. The footprint is never narrower than the hole and the element it falls on.

Where the jets fall is found anew every UPDATE_INTERVAL; in between the pattern moves with the fabric.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.compiled import kernel, scalar
from billow.gas.inflator import JetRing

UPDATE_INTERVAL = 1e-4
"""Time [s] between two searches for what the jets hit."""

REACH = 2.0
"""Footprint radius considered, in radii of the Gaussian; the momentum flux beyond is e^-8 of that on the axis."""


@dataclass(frozen=True)
class Jets:
    """A jet ring mounted in a mouth.

    mouth_nodes: (n,) int64, nodes that carry the inflator. axis: unit vector into the bag, (3,).
    """

    ring: JetRing
    mouth_nodes: np.ndarray
    axis: np.ndarray

    def nozzles(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Hole positions [m] (jets, 3), jet directions (jets, 3), and (3, 3) rows: axis, first and second radial
        vector."""
        seed = np.array([1.0, 0.0, 0.0]) if abs(self.axis[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
        first = seed - seed.dot(self.axis) * self.axis
        first /= np.linalg.norm(first)
        frame = np.array([self.axis, first, np.cross(self.axis, first)])
        angle = 2.0 * np.pi * np.arange(self.ring.count) / self.ring.count
        radial = np.cos(angle)[:, None] * frame[1] + np.sin(angle)[:, None] * frame[2]
        centre = positions[self.mouth_nodes].mean(axis=0)
        direction = np.sin(self.ring.angle) * radial + np.cos(self.ring.angle) * self.axis
        return centre + self.ring.ring_radius * radial, direction, frame


@dataclass
class JetPattern:
    """What the jets fall on: triangles (n,) int64, pressure per thrust of one jet [1/m^2] (n,), number of jets that
    see fabric."""

    triangles: np.ndarray
    share: np.ndarray
    seen: int


def aim(jets: Jets, triangles: np.ndarray, positions: np.ndarray) -> JetPattern:
    """Find the fabric in line of sight of each jet. triangles (n, 3), positions [m] (nodes, 3)."""
    holes, directions, frame = jets.nozzles(positions)
    centre = holes.mean(axis=0)
    n = len(triangles)
    weight, jet = np.zeros(n), np.zeros(n, dtype=np.int64)
    along = np.zeros(len(holes))
    _aim(n, triangles, positions, holes, directions, centre, frame, jets.ring.hole_diameter, weight, jet, along)
    lit = np.flatnonzero(weight > 0.0)
    return JetPattern(lit, weight[lit] / along[jet[lit]], int(np.count_nonzero(along > 0.0)))


def add_jet_force(
    pattern: JetPattern, thrust: float, triangles: np.ndarray, positions: np.ndarray, velocities: np.ndarray,
    mouth_velocity: np.ndarray, corner_force: np.ndarray,
) -> float:  # fmt: skip
    """Add the force of jets of `thrust` [N] each to corner_force [N] (triangles, 3, 3); returns their power [W].

    Power is measured against fabric moving relative to the mouth, so that it does not depend on the observer.
    """
    return _add_jet_force.serial(
        len(pattern.triangles), pattern.triangles, pattern.share, thrust, triangles, positions, velocities,
        mouth_velocity, corner_force,
    )  # fmt: skip


@scalar
def _corner_vectors(triangles, positions, i, ox, oy, oz):
    """The three corners of triangle i relative to a point: nine numbers."""
    a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
    return (
        positions[a, 0] - ox, positions[a, 1] - oy, positions[a, 2] - oz,
        positions[b, 0] - ox, positions[b, 1] - oy, positions[b, 2] - oz,
        positions[c, 0] - ox, positions[c, 1] - oy, positions[c, 2] - oz,
    )  # fmt: skip


@scalar
def _blocks(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz):
    """Whether triangle a, b, c crosses the segment from the origin to d (Moeller-Trumbore)."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    wx, wy, wz = cx - ax, cy - ay, cz - az
    hx, hy, hz = dy * wz - dz * wy, dz * wx - dx * wz, dx * wy - dy * wx
    determinant = ux * hx + uy * hy + uz * hz
    if determinant == 0.0:
        return False
    first = -(ax * hx + ay * hy + az * hz) / determinant
    if first < 0.0 or first > 1.0:
        return False
    qx, qy, qz = az * uy - ay * uz, ax * uz - az * ux, ay * ux - ax * uy
    second = (dx * qx + dy * qy + dz * qz) / determinant
    if second < 0.0 or first + second > 1.0:
        return False
    return 0.0 < (wx * qx + wy * qy + wz * qz) / determinant < 1.0 - 1e-6


@kernel
def _aim(n, triangles, positions, holes, directions, centre, frame, diameter, weight, jet, along):
    jets = len(holes)
    pitch = 2.0 * np.pi / jets
    blockers = np.empty((jets, n), dtype=np.int32)
    blocker_count = np.zeros(jets, dtype=np.int64)
    sphere = np.empty((n, 4))  # centroid seen from the hole, squared radius: most pairs are ruled out by it
    for i in range(n):
        ax, ay, az, bx, by, bz, cx, cy, cz = _corner_vectors(triangles, positions, i, centre[0], centre[1], centre[2])
        gx, gy, gz = (ax + bx + cx) / 3.0, (ay + by + cy) / 3.0, (az + bz + cz) / 3.0
        # The nearest jet by azimuth is the only one that matters: neighbours' footprints do not overlap.
        azimuth = np.arctan2(
            gx * frame[2, 0] + gy * frame[2, 1] + gz * frame[2, 2],
            gx * frame[1, 0] + gy * frame[1, 1] + gz * frame[1, 2],
        )
        k = int(np.floor(azimuth / pitch + 0.5)) % jets
        jet[i] = k
        rx, ry, rz = gx + centre[0] - holes[k, 0], gy + centre[1] - holes[k, 1], gz + centre[2] - holes[k, 2]
        s = rx * directions[k, 0] + ry * directions[k, 1] + rz * directions[k, 2]
        if s <= 0.0:
            continue
        ux, uy, uz, wx, wy, wz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
        double_area = np.sqrt(nx * nx + ny * ny + nz * nz)
        if double_area == 0.0:
            continue
        distance2 = rx * rx + ry * ry + rz * rz
        spread2 = (0.11 * s) ** 2 + 0.25 * diameter * diameter + 0.25 * double_area
        across2 = max(0.0, distance2 - s * s)
        facing = (nx * rx + ny * ry + nz * rz) / (double_area * np.sqrt(distance2))
        if facing < 0.0 and across2 <= REACH * REACH * spread2 + 2.0 * double_area:
            blockers[k, blocker_count[k]] = i
            blocker_count[k] += 1
            dx, dy, dz, ex, ey, ez = ax - gx, ay - gy, az - gz, bx - gx, by - gy, bz - gz
            hx, hy, hz = cx - gx, cy - gy, cz - gz
            sphere[i, 0], sphere[i, 1], sphere[i, 2] = rx, ry, rz
            sphere[i, 3] = max(dx * dx + dy * dy + dz * dz, ex * ex + ey * ey + ez * ez, hx * hx + hy * hy + hz * hz)
        elif facing > 1e-6 and across2 <= REACH * REACH * spread2:
            cosine = (nx * directions[k, 0] + ny * directions[k, 1] + nz * directions[k, 2]) / double_area
            speed = min(1.0, 6.0 * diameter / s)
            if cosine > 0.0:
                weight[i] = speed * speed * cosine * cosine * np.exp(-2.0 * across2 / spread2)
    # A ray that starts inside leaves through a wall it sees from inside; it can only come back in through a wall seen
    # from outside. So fabric is hidden only if such a wall crosses the line of sight.
    for i in range(n):
        if weight[i] == 0.0:
            continue
        k = jet[i]
        ox, oy, oz = holes[k, 0], holes[k, 1], holes[k, 2]
        ax, ay, az, bx, by, bz, cx, cy, cz = _corner_vectors(triangles, positions, i, ox, oy, oz)
        gx, gy, gz = (ax + bx + cx) / 3.0, (ay + by + cy) / 3.0, (az + bz + cz) / 3.0
        length2 = gx * gx + gy * gy + gz * gz
        for m in range(blocker_count[k]):
            j = blockers[k, m]
            dx, dy, dz = sphere[j, 0], sphere[j, 1], sphere[j, 2]
            ex, ey, ez = dy * gz - dz * gy, dz * gx - dx * gz, dx * gy - dy * gx
            if ex * ex + ey * ey + ez * ez > sphere[j, 3] * length2:
                continue
            px, py, pz, qx, qy, qz, vx, vy, vz = _corner_vectors(triangles, positions, j, ox, oy, oz)
            if _blocks(px, py, pz, qx, qy, qz, vx, vy, vz, gx, gy, gz):
                weight[i] = 0.0
                break
        if weight[i] > 0.0:
            ux, uy, uz, wx, wy, wz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
            nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
            along[k] += 0.5 * weight[i] * (nx * directions[k, 0] + ny * directions[k, 1] + nz * directions[k, 2])


@kernel
def _add_jet_force(n, lit, share, thrust, triangles, positions, velocities, mouth_velocity, corner_force):
    power = 0.0
    for m in range(n):
        i = lit[m]
        ia, ib, ic = triangles[i, 0], triangles[i, 1], triangles[i, 2]
        ax, ay, az, bx, by, bz, cx, cy, cz = _corner_vectors(triangles, positions, i, 0.0, 0.0, 0.0)
        ux, uy, uz, wx, wy, wz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        third = thrust * share[m] / 6.0
        fx, fy, fz = third * (uy * wz - uz * wy), third * (uz * wx - ux * wz), third * (ux * wy - uy * wx)
        for k in range(3):
            corner_force[i, k, 0] += fx
            corner_force[i, k, 1] += fy
            corner_force[i, k, 2] += fz
        power += fx * (velocities[ia, 0] + velocities[ib, 0] + velocities[ic, 0] - 3.0 * mouth_velocity[0])
        power += fy * (velocities[ia, 1] + velocities[ib, 1] + velocities[ic, 1] - 3.0 * mouth_velocity[1])
        power += fz * (velocities[ia, 2] + velocities[ib, 2] + velocities[ic, 2] - 3.0 * mouth_velocity[2])
    return power
