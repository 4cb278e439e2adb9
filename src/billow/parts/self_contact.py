"""Fabric against fabric: nodes and triangles of one surface keep a gap between them (docs/theory.md, Self-contact)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar
from billow.base.quality import Criterion, criterion
from billow.geometry.search_grid import SearchGrid, largest_move
from billow.geometry.surface import Surface, area_vectors
from billow.parts.part import FRICTION, STORED, Account, Booking, Moment, Part

SELF_CONTACT = Account("self_contact", STORED, renewed=True)
"""Energy in the springs between layers of fabric."""

SECONDS_PER_NODE = 180e-9
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
"""Motion of a node, in gaps, after which pairs are looked for anew."""

BESIDE = -0.7
"""Smallest area coordinate of a node over a triangle with which it makes a pair: it may slide onto it before the next
search."""

ON_EDGE = -1e-9
"""Smallest area coordinate of a node that is over a triangle. Panels cut from one mesh lie edge on edge: rounding must
not decide whether a node on an edge is over both of its triangles, one, or none."""

MOST_PAIRS = 64
"""Triangles that a node can touch, at most; fabric crushed to nothing has more."""

FARTHEST = 1e3
"""Distance of a node from the origin [m] from which on there is no bag any more."""


@dataclass
class Pairs:
    """Pairs in the order of their nodes.

    start: (nodes + 1,) int64, the pairs of each node. triangle: (pairs,) int64. side: (pairs,), +1 or -1, or 0 while
    the node is not over the triangle. gap and near, the compression of the spring: [m], (pairs,). push: force on each
    node along s n [N], and the area coordinates of the triangle's second and third corner, (pairs, 3). by_triangle:
    pairs in the order of their triangles, (pairs,) int64; struck_start: (triangles + 1,) int64, those of each triangle.
    searched_at: node positions [m], (nodes, 3).
    """

    start: np.ndarray
    triangle: np.ndarray
    side: np.ndarray
    gap: np.ndarray
    near: np.ndarray
    push: np.ndarray
    by_triangle: np.ndarray
    struck_start: np.ndarray
    searched_at: np.ndarray

    @classmethod
    def none(cls, nodes: int, triangles: int) -> Pairs:
        """No pairs yet; the first use looks for them."""
        return cls(
            np.zeros(nodes + 1, np.int64), np.zeros(0, np.int64), np.zeros(0), np.zeros(0), np.zeros(0),
            np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros(triangles + 1, np.int64), np.full((nodes, 3), np.inf),
        )  # fmt: skip


@dataclass(frozen=True)
class SelfContact(Part):
    """What never changes.

    triangles: all of the surface, (triangles, 3) uint32. solid: indices of those that can be touched, (solid,) int64.
    own_corner: (nodes,) int64, the corner at which a node's force is booked, -1 for nodes that are on no solid
    triangle. stiffness [N/m], damping [N s/m]: (nodes,). gap: [m].
    """

    triangles: np.ndarray
    solid: np.ndarray
    own_corner: np.ndarray
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
        touchable = np.zeros(surface.node_count, np.bool_)
        touchable[surface.triangles[solid]] = True
        own = np.where(touchable, surface.corners[np.minimum(surface.corner_start[:-1], len(surface.corners) - 1)], -1)
        stiffness = STIFFNESS * mass / crossing_time**2
        return cls(surface.triangles, solid, own, stiffness, 2.0 * DAMPING * np.sqrt(stiffness * mass), gap)

    @property
    def reach(self) -> float:
        """Distance [m] within which pairs are made."""
        return (1.0 + 2.0 * MOTION_IN_GAPS) * self.gap

    accounts = (SELF_CONTACT, FRICTION)

    def start(self, bag) -> Pairs:
        return Pairs.none(len(self.stiffness), len(self.triangles))

    def add_forces(
        self, pairs: Pairs, positions: np.ndarray, velocities: np.ndarray, dt: float, corner_force: np.ndarray
    ) -> list[Booking]:
        """Add the forces of all pairs to corner_force [N] (triangles, 3, 3); books the energy in the springs and what
        damping took in this step of dt [s].

        positions [m], velocities [m/s]: (nodes, 3). Looks for new pairs when nodes have moved far enough.
        """
        n = len(positions)
        if not largest_move(pairs.searched_at, positions) <= MOTION_IN_GAPS * self.gap:
            if not np.abs(positions).max() < FARTHEST:
                return [Booking(SELF_CONTACT, math.nan)]  # the guards say what became of the bag
            self.search(pairs, positions)
        if not len(pairs.triangle):
            return []
        sums = np.empty((-(-n // CHUNK), 2))
        _push(
            n, pairs.start, pairs.triangle, pairs.side, pairs.gap, pairs.near, self.triangles, self.own_corner,
            self.gap, self.stiffness, self.damping, positions, velocities, dt, corner_force.reshape(-1, 3), pairs.push,
            sums,
        )  # fmt: skip
        _push_back(
            len(self.triangles), pairs.struck_start, pairs.by_triangle, pairs.side, pairs.push, self.triangles,
            positions, corner_force,
        )  # fmt: skip
        stored, heat = sums.sum(axis=0)
        return [Booking(SELF_CONTACT, float(stored)), Booking(FRICTION, float(heat))]

    def books(self, pairs: Pairs, moment: Moment, history) -> dict[str, float]:
        return {"self_contact_energy_joule": float(history.energy("self_contact").max())}

    def verdicts(self, books: Mapping[str, float], history) -> Iterator[Criterion]:
        share = books["self_contact_energy_joule"] / max(books["largest_internal_energy_joule"], 1e-300)
        finer = "a smaller bag.element_size or run.dt_scale"
        yield criterion("penalty energy of self-contact, of peak internal", 100.0 * share, 5, 20, "%", finer)

    def seconds_per_step(self, pairs: Pairs, dt: float, end: float) -> float:
        return SECONDS_PER_NODE * len(self.stiffness)

    def search(self, pairs: Pairs, positions: np.ndarray) -> None:
        """Pairs within reach; those whose nodes are over their triangles go on."""
        n = len(positions)
        grid = SearchGrid.build(self.triangles[self.solid], positions, positions, self.reach)
        towards = area_vectors(self.triangles, positions)
        at_corners = np.repeat(towards, 3, axis=0)
        corner_node = self.triangles.ravel()
        normals = np.column_stack([np.bincount(corner_node, at_corners[:, axis], n) for axis in range(3)])
        arguments = (
            n, grid.cells_of(positions), grid.first, grid.listed, self.solid, self.triangles, self.own_corner,
            positions, towards, normals, self.reach, pairs.start, pairs.triangle, pairs.side,
            pairs.gap, pairs.near,
        )  # fmt: skip
        start = np.zeros(n + 1, np.int64)
        _find(*arguments, start, np.zeros(0, np.int64), np.zeros((0, 3)), False)
        np.cumsum(start, out=start)
        triangle, spring = np.empty(start[-1], np.int64), np.empty((start[-1], 3))
        _find(*arguments, start, triangle, spring, True)
        pairs.start, pairs.triangle = start, triangle
        pairs.side, pairs.gap, pairs.near = (np.ascontiguousarray(column) for column in spring.T)
        pairs.push = np.zeros((len(triangle), 3))
        pairs.by_triangle = np.argsort(triangle, kind="stable")
        pairs.struck_start = np.concatenate([[0], np.cumsum(np.bincount(triangle, minlength=len(self.triangles)))])
        pairs.searched_at = positions.copy()


@scalar
def over_triangle(x, y, z, a, b, c, positions):
    """A point above a triangle of nodes a, b, c: (height along its normal [m], area coordinates of b and c, unit normal
    x, y, z). A triangle without area gives a height of inf."""
    px, py, pz = x - positions[a, 0], y - positions[a, 1], z - positions[a, 2]
    ux, uy, uz = (
        positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1], positions[b, 2] - positions[a, 2],
    )  # fmt: skip
    vx, vy, vz = (
        positions[c, 0] - positions[a, 0], positions[c, 1] - positions[a, 1], positions[c, 2] - positions[a, 2],
    )  # fmt: skip
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    square = nx * nx + ny * ny + nz * nz
    if not square > 0.0:
        return np.inf, 0.0, 0.0, 0.0, 0.0, 0.0
    # (p x v) . n and (u x p) . n over n . n
    wb = ((py * vz - pz * vy) * nx + (pz * vx - px * vz) * ny + (px * vy - py * vx) * nz) / square
    wc = ((uy * pz - uz * py) * nx + (uz * px - ux * pz) * ny + (ux * py - uy * px) * nz) / square
    size = math.sqrt(square)
    nx, ny, nz = nx / size, ny / size, nz / size
    return px * nx + py * ny + pz * nz, wb, wc, nx, ny, nz


@scalar
def _adjacent(triangles, one, other):
    """Whether two triangles share a node."""
    for i in range(3):
        for j in range(3):
            if triangles[one, i] == triangles[other, j]:
                return True
    return False


@kernel
def _find(
    n, cells, first, listed, solid, triangles, own_corner, positions, towards, normals, reach, old_start,
    old_triangle, old_side, old_gap, old_near, start_out, triangle_out, spring_out, write,
):  # fmt: skip
    for p in prange(n):
        if own_corner[p] < 0:
            continue
        found = start_out[p]
        count = 0
        for k in range(first[cells[p]], first[cells[p] + 1]):
            t = solid[listed[k]]
            # Layers that can touch face each other; those that turn the same way have fabric in between.
            facing = normals[p, 0] * towards[t, 0] + normals[p, 1] * towards[t, 1] + normals[p, 2] * towards[t, 2] < 0.0
            if not facing and old_start[p] == old_start[p + 1]:
                continue
            height, wb, wc, _, _, _ = over_triangle(
                positions[p, 0], positions[p, 1], positions[p, 2], triangles[t, 0], triangles[t, 1], triangles[t, 2],
                positions,
            )  # fmt: skip
            if not abs(height) <= reach or min(wb, wc, 1.0 - wb - wc) < BESIDE:
                continue
            if triangles[t, 0] == p or triangles[t, 1] == p or triangles[t, 2] == p:
                continue
            side, gap, near = 0.0, 0.0, 0.0
            for j in range(old_start[p], old_start[p + 1]):
                if old_triangle[j] == t:
                    side, gap, near = old_side[j], old_gap[j], old_near[j]
            if not facing and side == 0.0:
                continue
            if write:
                triangle_out[found + count] = t
                spring_out[found + count, 0], spring_out[found + count, 1] = side, gap
                spring_out[found + count, 2] = near
            count += 1
        if not write:
            start_out[p + 1] = count


@scalar
def _come_over(k, first, last, triangle, side, near, push, triangles):
    """A node comes over the triangle of pair k: (side, compression) of the spring it takes along from a neighbour it
    leaves, (0, 0) if there is none."""
    for j in range(first, last):
        if side[j] != 0.0 and push[j, 0] == 0.0 and _adjacent(triangles, triangle[j], triangle[k]):
            taken = near[j]
            near[j] = 0.0
            return side[j], taken
    return 0.0, 0.0


@kernel
def _push(
    n, start, triangle, side, gap, near, triangles, own_corner, full_gap, stiffness, damping, positions, velocities, dt,
    corner_force, push, sums_out,
):  # fmt: skip
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        stored, heat = 0.0, 0.0
        height = np.empty(MOST_PAIRS)
        for p in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            first, last = start[p], min(start[p + 1], start[p] + MOST_PAIRS)
            fx, fy, fz = 0.0, 0.0, 0.0
            changes = False
            for k in range(first, last):
                t = triangle[k]
                d, wb, wc, _, _, _ = over_triangle(
                    positions[p, 0], positions[p, 1], positions[p, 2], triangles[t, 0], triangles[t, 1],
                    triangles[t, 2], positions,
                )  # fmt: skip
                over = abs(d) < np.inf and min(wb, wc, 1.0 - wb - wc) >= ON_EDGE
                height[k - first] = d
                push[k, 0], push[k, 1], push[k, 2] = 1.0 if over else 0.0, wb, wc
                changes = changes or over != (side[k] != 0.0)
            if changes:
                for k in range(first, last):
                    if side[k] == 0.0 and push[k, 0] > 0.0:
                        d = height[k - first]
                        kept, taken = _come_over(k, first, last, triangle, side, near, push, triangles)
                        side[k] = kept if kept != 0.0 else (1.0 if d >= 0.0 else -1.0)
                        gap[k] = min(full_gap, side[k] * d + taken)
                        heat += 0.5 * stiffness[p] * (taken * taken - max(0.0, gap[k] - side[k] * d) ** 2)
                for k in range(first, last):
                    if side[k] != 0.0 and push[k, 0] == 0.0:
                        heat += 0.5 * stiffness[p] * near[k] * near[k]
                        side[k], near[k] = 0.0, 0.0
            for k in range(first, last):
                if side[k] == 0.0:
                    continue
                clear = side[k] * height[k - first]
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
                _, wb, wc, nx, ny, nz = over_triangle(
                    positions[p, 0], positions[p, 1], positions[p, 2], a, b, c, positions
                )
                wa = 1.0 - wb - wc
                closing = -side[k] * (
                    nx * (velocities[p, 0] - wa * velocities[a, 0] - wb * velocities[b, 0] - wc * velocities[c, 0])
                    + ny * (velocities[p, 1] - wa * velocities[a, 1] - wb * velocities[b, 1] - wc * velocities[c, 1])
                    + nz * (velocities[p, 2] - wa * velocities[a, 2] - wb * velocities[b, 2] - wc * velocities[c, 2])
                )
                spring = stiffness[p] * near[k]
                force = max(0.0, spring + damping[p] * min(1.0, near[k] / full_gap) * closing)
                stored += 0.5 * spring * near[k]
                heat += (force - spring) * closing * dt
                fx, fy, fz = fx + side[k] * force * nx, fy + side[k] * force * ny, fz + side[k] * force * nz
                push[k, 0] = force
            corner = own_corner[p]
            if corner >= 0:
                corner_force[corner, 0] += fx
                corner_force[corner, 1] += fy
                corner_force[corner, 2] += fz
        sums_out[chunk, 0], sums_out[chunk, 1] = stored, heat


@kernel
def _push_back(n, struck_start, by_triangle, side, push, triangles, positions, corner_force):
    for t in prange(n):
        sa, sb, sc = 0.0, 0.0, 0.0
        for i in range(struck_start[t], struck_start[t + 1]):
            k = by_triangle[i]
            if push[k, 0] > 0.0:
                force = side[k] * push[k, 0]
                sa += (1.0 - push[k, 1] - push[k, 2]) * force
                sb += push[k, 1] * force
                sc += push[k, 2] * force
        if sa != 0.0 or sb != 0.0 or sc != 0.0:
            a = triangles[t, 0]
            _, _, _, nx, ny, nz = over_triangle(
                positions[a, 0], positions[a, 1], positions[a, 2], a, triangles[t, 1], triangles[t, 2], positions
            )
            for corner, share in enumerate((sa, sb, sc)):
                corner_force[t, corner, 0] -= share * nx
                corner_force[t, corner, 1] -= share * ny
                corner_force[t, corner, 2] -= share * nz
