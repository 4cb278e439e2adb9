"""Fabric against fabric: nodes and triangles of one surface keep a gap between them (docs/theory.md, Self-contact)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar, spliced
from billow.base.quality import Criterion, criterion
from billow.geometry.near_pairs import near_pairs
from billow.geometry.neighbours import by_halves
from billow.geometry.surface import Surface
from billow.geometry.triangle import cross, double_area_vector, sides
from billow.parts.part import FRICTION, STORED, Account, Booking, Loads, Moment, Part

SELF_CONTACT = Account("self_contact", STORED, renewed=True)
"""Energy in the springs between layers of fabric."""

SECONDS_PER_NODE = 80e-9
"""Rough cost of a node in a step, searches included."""

GAP_IN_EDGES = 0.2
"""Gap in mean edges of the mesh."""

STIFFNESS = 0.4
"""Of a pair, in node masses over the square of the time a membrane wave takes across the smallest altitude."""

DAMPING = 0.4
"""Of a pair whose gap has closed, in critical damping of its node: layers of fabric hardly bounce off each other."""

THROUGH = 2.0
"""Compression in gaps at which a node has been forced through: it belongs to the other side from then on."""

MOTION_IN_GAPS = 1.5
"""Motion of a node, in gaps, after which pairs are looked for anew; they are made that much further off, twice."""

AWAKE = 1.5
"""Height of a node over a triangle, in gaps, below which it is looked at: so much more than the gap that this happens
before they touch."""

BESIDE = 1e-6
"""Of the altitude of a triangle: a node that is not further beside it is looked at, as it may count as over it."""

ON_EDGE = -1e-9
"""Smallest area coordinate of a node that is over a triangle. Panels cut from one mesh lie edge on edge: rounding must
not decide whether a node on an edge is over both of its triangles, one, or none."""

FARTHEST = 1e3
"""Distance of a node from the origin [m] from which on there is no bag any more."""


@dataclass
class Pairs:
    """Pairs in the order of their nodes.

    start: (nodes + 1,) int64, the pairs of each node. triangle: (pairs,) int64. side: (pairs,), +1 or -1, or 0 while
    the node is not over the triangle. gap and near, the compression of the spring: [m], (pairs,). push: force on each
    node along s n [N], the area coordinates of the triangle's second and third corner, and the height of the node
    [m], (pairs, 4). drag: the part of that force which is damping [N], and s n, (pairs, 4). rest: motion of its node
    and its triangle together [m] up to which a pair need not be looked at, (pairs,); first_rest: the least of each
    node, (nodes,), inf where there is none. searched_at: node positions when they were found [m], (nodes, 3).
    """

    start: np.ndarray
    triangle: np.ndarray
    side: np.ndarray
    gap: np.ndarray
    near: np.ndarray
    push: np.ndarray
    drag: np.ndarray
    rest: np.ndarray
    first_rest: np.ndarray
    searched_at: np.ndarray

    @classmethod
    def none(cls, nodes: int) -> Pairs:
        """No pairs yet; the first use looks for them."""
        return cls(
            np.zeros(nodes + 1, np.int64), np.zeros(0, np.int64), np.zeros(0), np.zeros(0), np.zeros(0),
            np.zeros((0, 4)), np.zeros((0, 4)), np.zeros(0), np.full(nodes, np.inf), np.full((nodes, 3), np.inf),
        )  # fmt: skip


@dataclass(frozen=True)
class SelfContact(Part):
    """What never changes.

    triangles: all of the surface, (triangles, 3) uint32. solid: indices of those that can be touched, (solid,) int64,
    neighbours beside each other, for the search.
    touchable: (n,) int64, nodes of solid triangles. stiffness [N/m], damping [N s/m]: (nodes,). gap: [m].
    """

    triangles: np.ndarray
    solid: np.ndarray
    touchable: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    gap: float

    @classmethod
    def build(cls, surface: Surface, start: np.ndarray, mass: np.ndarray, crossing_time: float) -> SelfContact:
        """start: positions at time zero [m], (nodes, 3), which say how long edges are. mass: [kg], (nodes,).
        crossing_time: of the fastest membrane wave, over the smallest altitude [s]."""
        solid = surface.solid
        corners = start[surface.triangles[solid]]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        gap = GAP_IN_EDGES * float(edges.mean())
        touchable = np.unique(surface.triangles[solid]).astype(np.int64)
        stiffness = STIFFNESS * mass / crossing_time**2
        turned = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        turned *= np.ptp(start) / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-300)
        solid = solid[by_halves(np.hstack([corners.mean(axis=1), turned]))]  # layers that lie on each other stay apart
        return cls(surface.triangles, solid, touchable, stiffness, 2.0 * DAMPING * np.sqrt(stiffness * mass), gap)

    accounts = (SELF_CONTACT, FRICTION)

    def start(self, bag) -> Pairs:
        return Pairs.none(len(self.stiffness))

    def add_forces(
        self, pairs: Pairs, positions: np.ndarray, velocities: np.ndarray, dt: float, loads: Loads
    ) -> list[Booking]:
        """Add the forces of all pairs to the nodes; books the energy in the springs and what
        damping took in this step of dt [s]: nodes move by the mean of the forces at both its ends.

        positions [m], velocities [m/s]: (nodes, 3). Looks for new pairs when nodes have moved far enough.
        """
        n = len(positions)
        moved = np.empty(n)
        largest, awake = _measure_motion(n, pairs.searched_at, positions, pairs.first_rest, moved)
        if not largest <= MOTION_IN_GAPS * self.gap:
            if not np.abs(positions).max() < FARTHEST:
                return [Booking(SELF_CONTACT, math.nan)]  # the guards say what became of the bag
            self.search(pairs, positions)
            moved[...], largest, awake = 0.0, 0.0, bool(pairs.first_rest.min() <= 0.0)
        if not awake:
            return []
        carried, pushing = np.empty(len(self.triangles)), np.empty(len(pairs.triangle), np.int64)
        _measure_carried(len(carried), self.triangles, moved, carried)
        stored, heat, pushes = _push(
            n, moved, carried, largest, pairs.first_rest, pairs.rest, pairs.start, pairs.triangle, pairs.side,
            pairs.gap, pairs.near, self.triangles, self.gap, self.stiffness, self.damping, positions, velocities, dt,
            loads.node_force, pairs.push, pairs.drag, pushing,
        )  # fmt: skip
        if pushes:
            _push_back(
                pushing[:pushes], pairs.triangle, pairs.side, pairs.push, self.triangles, positions, loads.node_force
            )
        return [Booking(SELF_CONTACT, stored), Booking(FRICTION, heat)]

    def books(self, pairs: Pairs, moment: Moment, history) -> dict[str, float]:
        return {"self_contact_energy_joule": float(history.energy("self_contact").max())}

    def verdicts(self, books: Mapping[str, float], history) -> Iterator[Criterion]:
        share = books["self_contact_energy_joule"] / max(books["penalty_scale_joule"], 1e-300)
        finer = "a smaller bag.element_size or run.dt_scale"
        yield criterion("penalty energy of self-contact, of peak internal", 100.0 * share, 5, 20, "%", finer)

    def seconds_per_step(self, pairs: Pairs, dt: float, end: float) -> float:
        return SECONDS_PER_NODE * len(self.stiffness)

    def search(self, pairs: Pairs, positions: np.ndarray) -> None:
        """Pairs within reach; those whose nodes are over their triangles go on."""
        outward, altitude = np.empty_like(positions), np.empty(len(self.triangles))
        _outward(self.triangles, positions, outward, altitude)
        node, old = _in_touch(pairs.start, pairs.side)
        over = pairs.triangle[old]
        reach = (AWAKE + 2.0 * MOTION_IN_GAPS) * self.gap
        found = near_pairs(positions, self.touchable, self.triangles, self.solid, reach, outward, node, over)
        count = len(found.triangle)
        side, gap, near = np.zeros(count), np.zeros(count), np.zeros(count)
        push, drag = np.zeros((count, 4)), np.zeros((count, 4))
        rest, first_rest = np.empty(count), np.empty_like(pairs.first_rest)
        _carry_on(
            node, over, old, pairs.side, pairs.gap, pairs.near, pairs.push, pairs.drag,
            found.start, found.triangle, side, gap, near, push, drag,
        )  # fmt: skip
        find_rest(AWAKE * self.gap, found.start, found.triangle, found.apart, altitude, rest, first_rest)
        pairs.start, pairs.triangle, pairs.rest, pairs.first_rest = found.start, found.triangle, rest, first_rest
        pairs.side, pairs.gap, pairs.near, pairs.push, pairs.drag = side, gap, near, push, drag
        pairs.searched_at = positions.copy()


@kernel
def _measure_motion(n, before, after, first_rest, moved_out):
    """Motion of each node [m], (nodes,); returns the largest, and whether a pair of some node may be awake."""
    largest_of = np.empty((n + CHUNK - 1) // CHUNK)
    for chunk in prange(len(largest_of)):
        largest = 0.0
        for p in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            dx, dy, dz = after[p, 0] - before[p, 0], after[p, 1] - before[p, 1], after[p, 2] - before[p, 2]
            moved_out[p] = math.sqrt(dx * dx + dy * dy + dz * dz)
            largest = max(largest, moved_out[p])
        largest_of[chunk] = largest
    largest = 0.0
    for chunk in range(len(largest_of)):
        largest = max(largest, largest_of[chunk])
    awake = 0
    for p in range(n):
        awake += first_rest[p] <= moved_out[p] + largest
    return largest, awake > 0


@kernel
def _measure_carried(n, triangles, moved, carried_out):
    """The largest motion of a corner of each triangle [m], (triangles,)."""
    for t in prange(n):
        carried_out[t] = max(moved[triangles[t, 0]], moved[triangles[t, 1]], moved[triangles[t, 2]])


@scalar
def _outward(triangles, positions, outward, altitude):
    """Sum of the area vectors about each node [m^2], twice, (nodes, 3), and the smallest altitude of each triangle [m],
    (triangles,)."""
    outward[...] = 0.0
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ux, uy, uz, vx, vy, vz = sides(positions, a, b, c)
        nx, ny, nz = cross(ux, uy, uz, vx, vy, vz)
        wx, wy, wz = vx - ux, vy - uy, vz - uz
        longest = max(ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, wx * wx + wy * wy + wz * wz)
        altitude[t] = math.sqrt((nx * nx + ny * ny + nz * nz) / longest)
        for p in (a, b, c):
            outward[p, 0] += nx
            outward[p, 1] += ny
            outward[p, 2] += nz


@scalar
def _in_touch(start, side):
    """Pairs whose node is over its triangle, (k,) int64, after their nodes."""
    count = 0
    for k in range(len(side)):
        count += side[k] != 0.0
    node, pair = np.empty(count, np.int64), np.empty(count, np.int64)
    count = 0
    for p in range(len(start) - 1):
        for k in range(start[p], start[p + 1]):
            if side[k] != 0.0:
                node[count], pair[count] = p, k
                count += 1
    return node, pair


@scalar
def _carry_on(
    node, over, old, old_side, old_gap, old_near, old_push, old_drag,
    start, triangle, side, gap, near, push, drag,
):  # fmt: skip
    """Springs of old pairs go on in new ones; node, over: their nodes and triangles."""
    for m in range(len(old)):
        j = old[m]
        for k in range(start[node[m]], start[node[m] + 1]):
            if triangle[k] == over[m]:
                side[k], gap[k], near[k] = old_side[j], old_gap[j], old_near[j]
                push[k, 1], push[k, 2] = old_push[j, 1], old_push[j, 2]  # where the drag acted
                for i in range(4):
                    drag[k, i] = old_drag[j, i]
                break


@scalar
def find_rest(awake, start, triangle, apart, altitude, rest, first_rest):
    """rest and first_rest of `Pairs`.

    A node gets within `awake` [m] of its triangle only if both move by what is between. It gets over the triangle, no
    higher than that, only if they move by its distance from all places there: these move with the corners, and more,
    where the triangle turns, by their height over its altitude, four times at most.
    """
    for k in range(len(triangle)):
        distance, lateral, across = math.sqrt(apart[k, 0]), math.sqrt(apart[k, 1]), altitude[triangle[k]]
        away, height_squared = max(0.0, lateral - BESIDE * across), apart[k, 0] - apart[k, 1]
        if height_squared > awake * awake:
            away = math.sqrt(away * away + (math.sqrt(height_squared) - awake) ** 2)
        rest[k] = max(distance - awake, away * across / (across + 4.0 * awake))
    for p in range(len(start) - 1):
        least = math.inf
        for k in range(start[p], start[p + 1]):
            least = min(least, rest[k])
        first_rest[p] = least


@spliced
def _above(positions, p, a, b, c):
    """A node above a triangle of nodes a, b, c, by its normal n, which is as long as its area doubled: height times |n|
    [m^3], area coordinates of b and c times n^2 [m^4], n^2 [m^4], and n [m^2]: seven numbers."""
    px, py, pz = positions[p, 0] - positions[a, 0], positions[p, 1] - positions[a, 1], positions[p, 2] - positions[a, 2]
    ux, uy, uz = positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1], positions[b, 2] - positions[a, 2]
    vx, vy, vz = positions[c, 0] - positions[a, 0], positions[c, 1] - positions[a, 1], positions[c, 2] - positions[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    # (p x v) . n and (u x p) . n
    wb = (py * vz - pz * vy) * nx + (pz * vx - px * vz) * ny + (px * vy - py * vx) * nz
    wc = (uy * pz - uz * py) * nx + (uz * px - ux * pz) * ny + (ux * py - uy * px) * nz
    return px * nx + py * ny + pz * nz, wb, wc, nx * nx + ny * ny + nz * nz, nx, ny, nz


@scalar
def _unit_normal(positions, a, b, c):
    nx, ny, nz = double_area_vector(positions, a, b, c)
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    return nx / size, ny / size, nz / size


@scalar
def _adjacent(triangles, one, other):
    """Whether two triangles share a node."""
    for i in range(3):
        for j in range(3):
            if triangles[one, i] == triangles[other, j]:
                return True
    return False


@scalar
def _come_over(k, looked_at, triangle, side, near, push, triangles):
    """A node comes over the triangle of pair k: (side, compression) of the spring it takes along from a neighbour it
    leaves, (0, 0) if there is none. looked_at: pairs of the node."""
    for j in looked_at:
        if side[j] != 0.0 and push[j, 0] == 0.0 and _adjacent(triangles, triangle[j], triangle[k]):
            taken = near[j]
            near[j] = 0.0
            return side[j], taken
    return 0.0, 0.0


@scalar
def _closing(velocities, p, triangles, t, push, drag, k):
    """Speed at which a node and its place on its triangle come together, along the s n of `drag` [m/s]."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    wb, wc = push[k, 1], push[k, 2]
    wa, closing = 1.0 - wb - wc, 0.0
    for i in range(3):
        apart = velocities[p, i] - wa * velocities[a, i] - wb * velocities[b, i] - wc * velocities[c, i]
        closing -= drag[k, 1 + i] * apart
    return closing


@kernel
def _push(
    n, moved, carried, largest, first_rest, rest, start, triangle, side, gap, near, triangles, full_gap, stiffness,
    damping, positions, velocities, dt, node_force, push, drag, pushing_out,
):  # fmt: skip
    """Returns the energy in the springs, what was turned to heat in this step [J], and how many pairs push; these are
    put first into pushing_out, (pairs,), in their order."""
    chunks, most = (n + CHUNK - 1) // CHUNK, 0
    for p in range(n):
        most = max(most, start[p + 1] - start[p])
    sums, pushes = np.empty((chunks, 2)), np.zeros(chunks, np.int64)
    for chunk in prange(chunks):
        stored, heat, pushed = 0.0, 0.0, start[chunk * CHUNK]
        looked_at = np.empty(most + 1, np.int64)
        for p in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            if first_rest[p] > moved[p] + largest:
                continue
            count = 0
            for k in range(start[p], start[p + 1]):  # without branches, which could not be foretold
                looked_at[count] = k
                count += (rest[k] <= moved[p] + carried[triangle[k]]) | (side[k] != 0.0)
            fx, fy, fz = 0.0, 0.0, 0.0
            changes = False
            for k in looked_at[:count]:
                t = triangle[k]
                if drag[k, 0] != 0.0:
                    heat += 0.5 * dt * drag[k, 0] * _closing(velocities, p, triangles, t, push, drag, k)
                    drag[k, 0] = 0.0
                if rest[k] > moved[p] + carried[t] and near[k] == 0.0:
                    side[k], push[k, 0] = 0.0, 0.0
                    continue
                d, wb, wc, square, _, _, _ = _above(positions, p, triangles[t, 0], triangles[t, 1], triangles[t, 2])
                over = square > 0.0 and min(wb, wc, square - wb - wc) >= ON_EDGE * square
                if side[k] == 0.0 and not over:
                    continue
                push[k, 0] = 0.0
                if over:
                    push[k, 0], push[k, 3] = 1.0, d / math.sqrt(square)
                    push[k, 1], push[k, 2] = wb / square, wc / square
                changes = changes or over != (side[k] != 0.0)
            if changes:
                for k in looked_at[:count]:
                    if side[k] == 0.0 and push[k, 0] > 0.0:
                        d = push[k, 3]
                        kept, taken = _come_over(k, looked_at[:count], triangle, side, near, push, triangles)
                        side[k] = kept if kept != 0.0 else (1.0 if d >= 0.0 else -1.0)
                        gap[k] = min(full_gap, side[k] * d + taken)
                        heat += 0.5 * stiffness[p] * (taken * taken - max(0.0, gap[k] - side[k] * d) ** 2)
                for k in looked_at[:count]:
                    if side[k] != 0.0 and push[k, 0] == 0.0:
                        heat += 0.5 * stiffness[p] * near[k] * near[k]
                        side[k], near[k] = 0.0, 0.0
            for k in looked_at[:count]:
                if side[k] == 0.0:
                    continue
                clear = side[k] * push[k, 3]
                if gap[k] - clear > THROUGH * full_gap:
                    heat += 0.5 * stiffness[p] * near[k] * near[k]
                    side[k], clear = -side[k], -clear
                    gap[k] = min(full_gap, clear)
                gap[k] = min(full_gap, max(gap[k], clear))
                near[k] = max(0.0, gap[k] - clear)
                push[k, 0] = 0.0
                if near[k] == 0.0:
                    continue
                t = triangle[k]
                a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
                nx, ny, nz = _unit_normal(positions, a, b, c)
                drag[k, 1], drag[k, 2], drag[k, 3] = side[k] * nx, side[k] * ny, side[k] * nz
                closing = _closing(velocities, p, triangles, t, push, drag, k)
                spring = stiffness[p] * near[k]
                force = max(0.0, spring + damping[p] * min(1.0, near[k] / full_gap) * closing)
                stored += 0.5 * spring * near[k]
                drag[k, 0] = force - spring
                heat += 0.5 * dt * drag[k, 0] * closing
                fx, fy, fz = fx + side[k] * force * nx, fy + side[k] * force * ny, fz + side[k] * force * nz
                push[k, 0], pushing_out[pushed] = force, k
                pushed += 1
            node_force[p, 0] += fx
            node_force[p, 1] += fy
            node_force[p, 2] += fz
        sums[chunk, 0], sums[chunk, 1], pushes[chunk] = stored, heat, pushed - start[chunk * CHUNK]
    stored, heat, all_pushes = 0.0, 0.0, 0
    for chunk in range(chunks):
        stored, heat = stored + sums[chunk, 0], heat + sums[chunk, 1]
        for i in range(start[chunk * CHUNK], start[chunk * CHUNK] + pushes[chunk]):
            pushing_out[all_pushes] = pushing_out[i]
            all_pushes += 1
    return stored, heat, all_pushes


@scalar
def _push_back(pushing, triangle, side, push, triangles, positions, node_force):
    """Add what pairs push their triangles with to the corners [N]. One after the other, as triangles share nodes: few
    of them are struck."""
    struck, shares = np.zeros(len(triangles), np.bool_), np.empty((len(triangles), 3))
    for k in pushing:
        t = triangle[k]
        if not struck[t]:
            struck[t], shares[t, 0], shares[t, 1], shares[t, 2] = True, 0.0, 0.0, 0.0
        force = side[k] * push[k, 0]
        shares[t, 0] += (1.0 - push[k, 1] - push[k, 2]) * force
        shares[t, 1] += push[k, 1] * force
        shares[t, 2] += push[k, 2] * force
    for t in range(len(triangles)):
        if struck[t]:
            nx, ny, nz = _unit_normal(positions, triangles[t, 0], triangles[t, 1], triangles[t, 2])
            for corner in range(3):
                p, share = triangles[t, corner], -shares[t, corner]
                node_force[p, 0] += share * nx
                node_force[p, 1] += share * ny
                node_force[p, 2] += share * nz
