"""Momentum of the inflator's jets, for gas models that do not resolve the flow (docs/theory.md, Jets)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.triangle import double_area_vector
from billow.parts.gas.supply.curve import interpolate
from billow.parts.gas.supply.inflator import JetRing
from billow.parts.gas.supply.line_of_sight import NO_WALLS, lit_triangles
from billow.parts.gas.supply.outflow import jet_speed

UPDATE_INTERVAL = 1e-4
"""Time [s] between two searches for what the jets hit."""


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

    def turn(self, positions: np.ndarray) -> np.ndarray:
        """Rotation of the mouth since the start, (3, 3): the one that fits its nodes best to their present positions
        (Kabsch, Acta Crystallographica A32, 922, 1976). positions: [m], (nodes, 3)."""
        if self.mouth_start is None:
            return np.eye(3)
        nodes = positions[self.mouth_nodes]
        before, after = (places - places.mean(axis=0) for places in (self.mouth_start, nodes))
        if np.array_equal(before, after):  # most mouths are fixed; their digits must not change
            return np.eye(3)
        left, _, right = np.linalg.svd(after.T @ before)
        return (left * [1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right

    def nozzles(self, positions: np.ndarray, time: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions and directions of the jets at a time [s].

        Returns hole positions [m] (jets, 3); frames (jets, 3, 3), rows: jet direction, tangent to the ring, and the
        vector perpendicular to both; (3, 3) rows: axis, radial vector and tangent of the first jet.
        """
        unmoved = self.mouth_start is not None and _unmoved(self.mouth_nodes, self.mouth_start, positions)
        if unmoved and not self.ring.spin:
            return self._nozzles_at_start
        out, frames, ring = self._ring_at(time) if self.ring.spin else self._ring_at_rest
        centre = positions[self.mouth_nodes].mean(axis=0)
        if self.mouth_start is None or unmoved:
            return centre + out, frames, ring
        turned = self.turn(positions).T  # of rows
        return centre + out @ turned, frames @ turned, ring @ turned

    # Arrays that cannot be written are another type to a kernel, which would be compiled twice.

    @cached_property
    def _ring_at_rest(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self._ring_at(0.0)

    @cached_property
    def _nozzles_at_start(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As `nozzles`, of a ring that does not spin in a mouth that has not moved, as most are."""
        out, frames, ring = self._ring_at_rest
        return self.mouth_start.mean(axis=0) + out, frames, ring

    def _ring_at(self, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As `nozzles`, in a mouth about the origin that has not turned."""
        first = self.zero - self.zero.dot(self.axis) * self.axis
        first /= np.linalg.norm(first)
        second = np.cross(self.axis, first)
        azimuth = 2.0 * np.pi * np.arange(self.ring.count)[:, None] / self.ring.count
        azimuth += self.ring.azimuth + self.ring.spin * time
        radial = np.cos(azimuth) * first + np.sin(azimuth) * second
        tangent = np.cos(azimuth) * second - np.sin(azimuth) * first
        lean, rise = np.sin(self.ring.angle), np.cos(self.ring.angle)
        frames = np.stack([lean * radial + rise * self.axis, tangent, rise * radial - lean * self.axis], axis=1)
        return self.ring.ring_radius * radial, frames, np.array([self.axis, radial[0], tangent[0]])


@scalar
def _unmoved(nodes, start, positions):
    """Whether the nodes (n,) are where they were at the start [m], (n, 3)."""
    for i in range(len(nodes)):
        for k in range(3):
            if positions[nodes[i], k] != start[i, k]:
                return False
    return True


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

    @property
    def for_kernels(self) -> tuple[np.ndarray, ...]:
        """What `blow` takes."""
        return self.triangles, self.share, self.force

    @classmethod
    def nothing(cls) -> JetPattern:
        """No jet blows."""
        return cls(np.empty(0, np.int64), np.empty(0), 0, np.empty((0, 3)))


def aim(jets: Jets, triangles: np.ndarray, positions: np.ndarray, time: float = 0.0) -> JetPattern:
    """Find the fabric in line of sight of each jet at a time [s]. triangles (n, 3), positions [m] (nodes, 3)."""
    holes, frames, ring = jets.nozzles(positions, time)
    walls = NO_WALLS if jets.walls is None else (jets.walls, jets.reversed)
    lit, share, seen = lit_triangles(triangles, *walls, positions, holes, frames, ring, jets.ring.hole_diameter)
    return JetPattern(lit, share, seen, np.zeros((len(lit), 3)))


@scalar
def jet_thrust(table, mass_fractions, flow_time, mass_flow, temperature_time, temperature, count, time):
    """Thrust [N] of each of `count` jets of an inflator at a time [s]; zero when it does not blow.

    table: thermo table (species, 16); mass_fractions to temperature: as in `Inflator`.
    """
    if not flow_time[0] < time < flow_time[-1]:
        return 0.0
    flow = interpolate(flow_time, mass_flow, time)
    if flow <= 0.0:
        return 0.0
    return flow / count * jet_speed(table, mass_fractions, interpolate(temperature_time, temperature, time))


@scalar
def blow(inflator, count, time, due, pattern, triangles, positions, velocities, mouth_nodes, node_force):
    """Thrust of each of `count` jets at a time [s], as `jet_thrust`; if there is any and no aim is due, its force as
    `add_jet_force`. Returns thrust [N], and the power [W] of the last force on the pattern and of the new one.

    inflator: what `jet_thrust` takes before `count`. pattern: triangles, share and force of a JetPattern.
    """
    table, mass_fractions, flow_time, mass_flow, temperature_time, temperature = inflator
    lit, share, force = pattern
    thrust = jet_thrust(table, mass_fractions, flow_time, mass_flow, temperature_time, temperature, count, time)
    if thrust > 0.0 and not due:
        last, power = add_jet_force(
            lit, share, thrust, triangles, positions, velocities, mouth_nodes, force, node_force
        )  # fmt: skip
        return thrust, last, power
    return thrust, power_of_last_force(lit, force, triangles, velocities, mouth_nodes), 0.0


@scalar
def add_jet_force(lit, share, thrust, triangles, positions, velocities, mouth_nodes, force_out, node_force):
    """Add the force of jets of `thrust` [N] each on a JetPattern to node_force [N] (nodes, 3); returns the power [W] of
    the last force on this pattern, zero at first, and of the new one.

    Power refers to the motion of the fabric relative to the mouth, so it does not depend on the observer.
    """
    last, power, mouth = 0.0, 0.0, _mean(mouth_nodes, velocities)
    for m in range(len(lit)):
        i = lit[m]
        sx, sy, sz = _corner_speeds(triangles, i, velocities, mouth)
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


@scalar
def power_of_last_force(lit, force, triangles, velocities, mouth_nodes):
    """Power [W] of the last force [N] (n, 3) on the corners of the lit triangles with the present velocities [m/s]."""
    power, mouth = 0.0, _mean(mouth_nodes, velocities)
    for m in range(len(lit)):
        sx, sy, sz = _corner_speeds(triangles, lit[m], velocities, mouth)
        power += force[m, 0] * sx + force[m, 1] * sy + force[m, 2] * sz
    return power


@scalar
def _mean(nodes, vectors):
    """Mean (3) of the vectors (n, 3) at some nodes."""
    x, y, z = 0.0, 0.0, 0.0
    for node in nodes:
        x, y, z = x + vectors[node, 0], y + vectors[node, 1], z + vectors[node, 2]
    return x / len(nodes), y / len(nodes), z / len(nodes)


@scalar
def _corner_speeds(triangles, i, velocities, mouth_velocity):
    """Sum of the velocities [m/s] of the corners of triangle i, relative to the mouth."""
    a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
    return (
        velocities[a, 0] + velocities[b, 0] + velocities[c, 0] - 3.0 * mouth_velocity[0],
        velocities[a, 1] + velocities[b, 1] + velocities[c, 1] - 3.0 * mouth_velocity[1],
        velocities[a, 2] + velocities[b, 2] + velocities[c, 2] - 3.0 * mouth_velocity[2],
    )
