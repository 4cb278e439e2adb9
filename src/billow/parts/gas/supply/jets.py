"""Momentum of the inflator's jets, for gas models that do not resolve the flow (docs/theory.md, Jets)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from billow.base.compiled import kernel, scalar
from billow.geometry.triangle import cross, double_area_vector
from billow.parts.gas.supply.inflator import JetRing

UPDATE_INTERVAL = 1e-4
"""Time [s] between two searches for what the jets hit."""

REACH = 1.5
"""Radius of the footprint in radii of the Gaussian; 99 % of the momentum flux lies within (1 - e^-4.5)."""

STRIPS, WIDEST = 32, 0.4
"""Number of strips into which directions from -WIDEST to WIDEST (lateral over axial distance) are sorted."""


@dataclass(frozen=True)
class Jets:
    """A jet ring mounted in a mouth, which carries it along and turns it.

    mouth_nodes: (n,) int64, nodes that carry the inflator. axis: unit vector into the bag at the start, (3,). zero:
    direction across the axis from which azimuths count at the start, (3,); its part along the axis does not count.
    walls: (n,) int64, triangles around the chamber that the jets blow into, and reversed: (n,) bool, those whose
    normals point into it; None for a bag of one chamber, all of whose triangles are walls with normals outwards.
    mouth_start: where the mouth nodes are at the start [m], (n, 3); None for a mouth that never turns.
    """

    ring: JetRing
    mouth_nodes: np.ndarray
    axis: np.ndarray
    zero: np.ndarray
    walls: np.ndarray | None = None
    reversed: np.ndarray | None = None
    mouth_start: np.ndarray | None = None

    def mouth_velocity(self, velocities: np.ndarray) -> np.ndarray:
        """Mean velocity of the mouth [m/s], (3,); velocities: (nodes, 3)."""
        mean = np.empty(3)
        _mean(self.mouth_nodes, velocities, mean)
        return mean

    def turn(self, positions: np.ndarray) -> np.ndarray:
        """Rotation of the mouth since the start, (3, 3): the one that fits its nodes best to their present positions
        (Kabsch, Acta Crystallographica A32, 922, 1976). positions: [m], (nodes, 3)."""
        if self.mouth_start is None:
            return np.eye(3)
        before, after = (nodes - nodes.mean(axis=0) for nodes in (self.mouth_start, positions[self.mouth_nodes]))
        if np.array_equal(before, after):  # most mouths are fixed; their digits must not change
            return np.eye(3)
        left, _, right = np.linalg.svd(after.T @ before)
        return (left * [1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right

    def nozzles(self, positions: np.ndarray, time: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions and directions of the jets at a time [s].

        Returns hole positions [m] (jets, 3); frames (jets, 3, 3), rows: jet direction, tangent to the ring, and the
        vector perpendicular to both; (3, 3) rows: axis, radial vector and tangent of the first jet.
        """
        first = self.zero - self.zero.dot(self.axis) * self.axis
        first /= np.linalg.norm(first)
        second = np.cross(self.axis, first)
        azimuth = 2.0 * np.pi * np.arange(self.ring.count)[:, None] / self.ring.count
        azimuth += self.ring.azimuth + self.ring.spin * time
        radial = np.cos(azimuth) * first + np.sin(azimuth) * second
        tangent = np.cos(azimuth) * second - np.sin(azimuth) * first
        lean, rise = np.sin(self.ring.angle), np.cos(self.ring.angle)
        frames = np.stack([lean * radial + rise * self.axis, tangent, rise * radial - lean * self.axis], axis=1)
        centre = positions[self.mouth_nodes].mean(axis=0)
        turned = self.turn(positions).T  # of rows
        holes = centre + self.ring.ring_radius * radial @ turned
        return holes, frames @ turned, np.array([self.axis, radial[0], tangent[0]]) @ turned


@dataclass
class JetPattern:
    """What the jets fall on.

    triangles: (n,) int64. share: pressure per thrust of one jet [1/m^2], (n,), negative where the triangle's normal
    points into the chamber. seen: number of jets that see fabric. force: last force [N] on each corner, (n, 3).
    """

    triangles: np.ndarray
    share: np.ndarray
    seen: int
    force: np.ndarray

    @classmethod
    def nothing(cls) -> JetPattern:
        """No jet blows."""
        return cls(np.empty(0, np.int64), np.empty(0), 0, np.empty((0, 3)))


def aim(jets: Jets, triangles: np.ndarray, positions: np.ndarray, time: float = 0.0) -> JetPattern:
    """Find the fabric in line of sight of each jet at a time [s]. triangles (n, 3), positions [m] (nodes, 3)."""
    if jets.walls is None:
        return _aim_inside(jets, triangles, positions, time)
    walls = triangles[jets.walls]
    walls[jets.reversed] = walls[jets.reversed][:, ::-1]
    seen = _aim_inside(jets, walls, positions, time)
    seen.share[jets.reversed[seen.triangles]] *= -1.0
    seen.triangles = jets.walls[seen.triangles]
    return seen


def _aim_inside(jets: Jets, triangles: np.ndarray, positions: np.ndarray, time: float) -> JetPattern:
    """As `aim`, for triangles that close one chamber with normals outwards."""
    holes, frames, ring = jets.nozzles(positions, time)
    centre = holes.mean(axis=0)
    n = len(triangles)
    weight, jet = np.zeros(n), np.zeros(n, dtype=np.int64)
    along = np.zeros(len(holes))
    _aim(n, triangles, positions, holes, frames, centre, ring, jets.ring.hole_diameter, weight, jet, along)
    lit = np.flatnonzero(weight > 0.0)
    share = weight[lit] / along[jet[lit]]
    return JetPattern(lit, share, int(np.count_nonzero(along > 0.0)), np.zeros((len(lit), 3)))


def add_jet_force(
    pattern: JetPattern, thrust: float, triangles: np.ndarray, positions: np.ndarray, velocities: np.ndarray,
    mouth_velocity: np.ndarray, node_force: np.ndarray,
) -> tuple[float, float]:  # fmt: skip
    """Add the force of jets of `thrust` [N] each to node_force [N] (nodes, 3); returns the power [W] of the
    last force on this pattern, zero at first, and of the new one.

    Power refers to the motion of the fabric relative to the mouth, so it does not depend on the observer.
    """
    return _add_jet_force.serial(
        len(pattern.triangles), pattern.triangles, pattern.share, thrust, triangles, positions, velocities,
        mouth_velocity, pattern.force, node_force,
    )  # fmt: skip


def power_of_last_force(
    pattern: JetPattern, triangles: np.ndarray, velocities: np.ndarray, mouth_velocity: np.ndarray
) -> float:
    """Power [W] of the last force with the present velocities [m/s] (nodes, 3)."""
    return _power.serial(
        len(pattern.triangles), pattern.triangles, pattern.force, triangles, velocities, mouth_velocity
    )


@scalar
def _mean(nodes, vectors, mean_out):
    mean_out[:] = 0.0
    for node in nodes:
        for k in range(3):
            mean_out[k] += vectors[node, k]
    for k in range(3):
        mean_out[k] /= len(nodes)


@scalar
def _corners(triangles, positions, i, ox, oy, oz):
    """The three corners of triangle i relative to a point: nine numbers."""
    a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
    return (
        positions[a, 0] - ox, positions[a, 1] - oy, positions[a, 2] - oz,
        positions[b, 0] - ox, positions[b, 1] - oy, positions[b, 2] - oz,
        positions[c, 0] - ox, positions[c, 1] - oy, positions[c, 2] - oz,
    )  # fmt: skip


@scalar
def _covers(outline, i, u, v, nearness):
    """Whether triangle i hides what is seen in direction (u, v) at 1/distance `nearness`.

    outline: projected corners and their nearness, (triangles, 9). Nearness is linear over a projected triangle.
    """
    au, av, an = outline[i, 0], outline[i, 1], outline[i, 2]
    bu, bv, bn = outline[i, 3], outline[i, 4], outline[i, 5]
    cu, cv, cn = outline[i, 6], outline[i, 7], outline[i, 8]
    whole = (bu - au) * (cv - av) - (bv - av) * (cu - au)
    if whole == 0.0:
        return False
    if (u < au and u < bu and u < cu) or (v < av and v < bv and v < cv) or (v > av and v > bv and v > cv):
        return False
    second = ((u - au) * (cv - av) - (v - av) * (cu - au)) / whole
    third = ((bu - au) * (v - av) - (bv - av) * (u - au)) / whole
    if second < 0.0 or third < 0.0 or second + third > 1.0:
        return False
    return an + second * (bn - an) + third * (cn - an) > nearness * (1.0 + 1e-6)


@scalar
def _strip(u):
    """Strip of the lateral direction u; the outermost strips take everything beyond."""
    return int(min(max(0.5 * STRIPS * (1.0 + u / WIDEST), 0.0), STRIPS - 1.0))


@scalar
def _aim(n, triangles, positions, holes, frames, centre, ring, diameter, weight, jet, along):
    jets = len(holes)
    pitch = 2.0 * math.pi / jets
    ox, oy, oz = holes[0, 0] - centre[0], holes[0, 1] - centre[1], holes[0, 2] - centre[2]
    radius_of_ring = math.sqrt(ox * ox + oy * oy + oz * oz)
    rise = frames[0, 0, 0] * ring[0, 0] + frames[0, 0, 1] * ring[0, 1] + frames[0, 0, 2] * ring[0, 2]
    lean = math.sqrt(max(0.0, 1.0 - rise * rise))
    # Seen from its hole, a point has lateral over axial coordinates (u, v) and nearness 1/axial. A line of sight is one
    # point (u, v), so hiding is a test of plane triangles, listed by strips of u.
    sight = np.empty((n, 3))
    outline = np.empty((n, 9))
    first = np.full((jets, STRIPS), -1, dtype=np.int64)
    entry_triangle, entry_next = np.empty(4 * n, dtype=np.int64), np.empty(4 * n, dtype=np.int64)
    entries = 0
    for i in range(n):
        ax, ay, az, bx, by, bz, cx, cy, cz = _corners(triangles, positions, i, centre[0], centre[1], centre[2])
        gx, gy, gz = (ax + bx + cx) / 3.0, (ay + by + cy) / 3.0, (az + bz + cz) / 3.0
        nx, ny, nz = cross(bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az)
        double_area = math.sqrt(nx * nx + ny * ny + nz * nz)
        if double_area == 0.0:
            continue
        # All jets lie on one cone; most fabric is too far from it for the nearest jet to matter.
        height = gx * ring[0, 0] + gy * ring[0, 1] + gz * ring[0, 2]
        beyond = math.sqrt(max(0.0, gx * gx + gy * gy + gz * gz - height * height)) - radius_of_ring
        axial = beyond * lean + height * rise
        widest2 = (0.11 * axial) ** 2 + 0.25 * diameter * diameter + 0.25 * double_area
        if axial <= 0.0 or (beyond * rise - height * lean) ** 2 > REACH * REACH * widest2 + 2.0 * double_area:
            continue
        azimuth = math.atan2(
            gx * ring[2, 0] + gy * ring[2, 1] + gz * ring[2, 2], gx * ring[1, 0] + gy * ring[1, 1] + gz * ring[1, 2]
        )
        k = math.floor(azimuth / pitch + 0.5) % jets
        jet[i] = k  # the footprints of neighbouring jets hardly overlap
        rx, ry, rz = gx + centre[0] - holes[k, 0], gy + centre[1] - holes[k, 1], gz + centre[2] - holes[k, 2]
        s = rx * frames[k, 0, 0] + ry * frames[k, 0, 1] + rz * frames[k, 0, 2]
        if s <= 0.0:
            continue
        u = (rx * frames[k, 1, 0] + ry * frames[k, 1, 1] + rz * frames[k, 1, 2]) / s
        v = (rx * frames[k, 2, 0] + ry * frames[k, 2, 1] + rz * frames[k, 2, 2]) / s
        sight[i, 0], sight[i, 1], sight[i, 2] = u, v, 1.0 / s
        distance2 = rx * rx + ry * ry + rz * rz
        spread2 = (0.11 * s) ** 2 + 0.25 * diameter * diameter + 0.25 * double_area
        across2 = max(0.0, distance2 - s * s)
        facing = (nx * rx + ny * ry + nz * rz) / (double_area * math.sqrt(distance2))
        if facing < 0.0 and across2 <= REACH * REACH * spread2 + 2.0 * double_area:
            behind = False
            for c, (px, py, pz) in enumerate(((ax, ay, az), (bx, by, bz), (cx, cy, cz))):
                px, py, pz = px + centre[0] - holes[k, 0], py + centre[1] - holes[k, 1], pz + centre[2] - holes[k, 2]
                along_axis = px * frames[k, 0, 0] + py * frames[k, 0, 1] + pz * frames[k, 0, 2]
                behind = behind or along_axis <= 0.0
                near = 1.0 / along_axis
                outline[i, 3 * c] = near * (px * frames[k, 1, 0] + py * frames[k, 1, 1] + pz * frames[k, 1, 2])
                outline[i, 3 * c + 1] = near * (px * frames[k, 2, 0] + py * frames[k, 2, 1] + pz * frames[k, 2, 2])
                outline[i, 3 * c + 2] = near
            if behind:
                continue
            lowest = min(outline[i, 0], outline[i, 3], outline[i, 6])
            highest = max(outline[i, 0], outline[i, 3], outline[i, 6])
            for strip in range(_strip(lowest), _strip(highest) + 1):
                if entries == len(entry_next):
                    entry_triangle = np.concatenate((entry_triangle, np.empty_like(entry_triangle)))
                    entry_next = np.concatenate((entry_next, np.empty_like(entry_next)))
                entry_triangle[entries], entry_next[entries] = i, first[k, strip]
                first[k, strip] = entries
                entries += 1
        elif facing > 1e-6 and across2 <= REACH * REACH * spread2:
            cosine = (nx * frames[k, 0, 0] + ny * frames[k, 0, 1] + nz * frames[k, 0, 2]) / double_area
            speed = min(1.0, 6.0 * diameter / s)
            if cosine > 0.0:
                weight[i] = speed * speed * cosine * cosine * math.exp(-2.0 * across2 / spread2)
    # A ray that starts inside leaves through a wall seen from inside, and only comes back through a wall seen from
    # outside. So fabric is hidden only if a wall seen from outside crosses the line of sight.
    for i in range(n):
        if weight[i] == 0.0:
            continue
        k = jet[i]
        entry = first[k, _strip(sight[i, 0])]
        while entry >= 0:
            if _covers(outline, entry_triangle[entry], sight[i, 0], sight[i, 1], sight[i, 2]):
                weight[i] = 0.0
                break
            entry = entry_next[entry]
        if weight[i] > 0.0:
            nx, ny, nz = double_area_vector(positions, triangles[i, 0], triangles[i, 1], triangles[i, 2])
            along[k] += 0.5 * weight[i] * (nx * frames[k, 0, 0] + ny * frames[k, 0, 1] + nz * frames[k, 0, 2])


@kernel
def _add_jet_force(n, lit, share, thrust, triangles, positions, velocities, mouth_velocity, force_out, node_force):
    last, power = 0.0, 0.0
    for m in range(n):
        i = lit[m]
        sx, sy, sz = _corner_speeds(triangles, i, velocities, mouth_velocity)
        last += force_out[m, 0] * sx + force_out[m, 1] * sy + force_out[m, 2] * sz
        nx, ny, nz = double_area_vector(positions, triangles[i, 0], triangles[i, 1], triangles[i, 2])
        third = thrust * share[m] / 6.0
        fx, fy, fz = third * nx, third * ny, third * nz
        power += fx * sx + fy * sy + fz * sz
        force_out[m, 0], force_out[m, 1], force_out[m, 2] = fx, fy, fz
        for k in range(3):
            node = triangles[i, k]
            node_force[node, 0] += fx
            node_force[node, 1] += fy
            node_force[node, 2] += fz
    return last, power


@kernel
def _power(n, lit, force, triangles, velocities, mouth_velocity):
    power = 0.0
    for m in range(n):
        sx, sy, sz = _corner_speeds(triangles, lit[m], velocities, mouth_velocity)
        power += force[m, 0] * sx + force[m, 1] * sy + force[m, 2] * sz
    return power


@scalar
def _corner_speeds(triangles, i, velocities, mouth_velocity):
    """Sum of the velocities [m/s] of the corners of triangle i, relative to the mouth."""
    a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
    return (
        velocities[a, 0] + velocities[b, 0] + velocities[c, 0] - 3.0 * mouth_velocity[0],
        velocities[a, 1] + velocities[b, 1] + velocities[c, 1] - 3.0 * mouth_velocity[1],
        velocities[a, 2] + velocities[b, 2] + velocities[c, 2] - 3.0 * mouth_velocity[2],
    )
