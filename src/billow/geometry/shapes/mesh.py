"""A rigid surface of triangles. A closed one is a solid: points inside it are deep by their distance from the surface.
An open one is a sheet: all points within half its thickness of the surface, so that both its sides can be touched.

The closest point is found through a tree of boxes. Which side of a solid a point is on is what the pseudonormal of the
closest face, edge or corner says: the sum of the normals around it, weighted by their angles there (Baerentzen and
Aanaes, "Signed distance computation using the angle weighted pseudonormal", IEEE TVCG 11(3), 2005).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar
from billow.geometry.closest_points import on_triangle
from billow.geometry.shapes.shape import NUMBERS

KIND = "mesh"
LEAF = 4
"""Most triangles of a box that is not divided."""
DEEP = 64
"""Most boxes that wait while a tree is searched: more than a tree of any mesh is deep."""
SLACK = 1.0 + 1e-12
"""Factor by which a box may be farther than the best triangle so far: rounding must not hide a triangle as near."""
TOUCHING = 1e-12
"""Distance [m] below which the way to the closest point has no direction."""
SEEN = 5
"""Columns of what is remembered of each node: its place in the axes of the mesh [m], how far it is outside [m], and the
closest triangle. It only saves searching; what is found does not depend on it."""


@dataclass(frozen=True)
class Mesh:
    """points: [m], (nodes, 3), about the middle of their box; triangles: (n, 3), outwards if they are closed;
    thickness: of the sheet [m], 0 for a solid."""

    points: np.ndarray
    triangles: np.ndarray
    thickness: float = 0.0
    kind: ClassVar[str] = KIND

    @cached_property
    def _half(self) -> np.ndarray:
        """Of its extents along its axes [m], (3,)."""
        return np.abs(self.points).max(axis=0) + 0.5 * self.thickness

    @cached_property
    def numbers(self) -> np.ndarray:
        """As which super-ellipsoid it meets other bodies: radii, degree, flatness. The degree is that of its volume in
        the box around it, from 2 (pi/6 of the box) to 10."""
        filled = self.volume() / float(8.0 * np.prod(self._half))
        degrees = np.linspace(2.0, 10.0, 81)
        share = [math.gamma(1.0 + 1.0 / n) ** 3 / math.gamma(1.0 + 3.0 / n) for n in degrees]
        degree = float(np.interp(filled, share, degrees))
        own = np.array([*self._half, degree, 3.0 ** (1.0 / degree - 0.5)])
        return np.pad(own, (0, NUMBERS - len(own)))

    @cached_property
    def bound(self) -> float:
        return float(np.linalg.norm(self.points, axis=1).max()) + 0.5 * self.thickness

    @property
    def size(self) -> float:
        """Of a solid its volume over its area: half the thickness of a plate. Half the thickness of a sheet."""
        return 0.5 * self.thickness or self.volume() / self.area

    @cached_property
    def edge(self) -> float:
        """Mean length of its edges [m]."""
        corners = self.points[self.triangles]
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())

    @cached_property
    def area(self) -> float:
        return float(0.5 * np.linalg.norm(self._double_areas, axis=1).sum())

    @cached_property
    def _double_areas(self) -> np.ndarray:
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        return np.cross(b - a, c - a)

    def volume(self) -> float:
        if self.thickness:
            return self.area * self.thickness
        return float(np.sum(self.points[self.triangles[:, 0]] * self._double_areas) / 6.0)

    def inertia(self, mass: float) -> np.ndarray:
        """About its axes through the centre of mass, which must be principal ones."""
        return np.diag(mass_properties(self.points, self.triangles, bool(self.thickness))[2]) * mass

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        met = np.empty((len(points), 4))
        still, pose = np.zeros(9), np.eye(3).ravel()
        self.look(
            np.ascontiguousarray(points, float), still, still[:3], pose, np.inf, self.nothing_seen(len(points)), met
        )
        return -met[:, 0], met[:, 1:]

    def level(self, points: np.ndarray) -> np.ndarray:
        return self.distance(points.reshape(-1, 3))[0].reshape(points.shape[:-1])

    def describe(self) -> dict:
        return {
            "kind": self.kind, "points": self.points.tolist(), "triangles": self.triangles.tolist(),
            "thickness": float(self.thickness),
        }  # fmt: skip

    @classmethod
    def from_description(cls, described: dict) -> Mesh:
        triangles = np.array(described["triangles"], np.int64)
        return cls(np.array(described["points"], float), triangles, float(described["thickness"]))

    # --- closest points --------------------------------------------------------------------------------------------

    def nothing_seen(self, nodes: int) -> np.ndarray:
        """What is remembered of nodes that were never looked for, (nodes, SEEN)."""
        seen = np.zeros((nodes, SEEN))
        seen[:, 3] = -np.inf
        return seen

    def look(
        self, positions: np.ndarray, body: np.ndarray, centre: np.ndarray, pose: np.ndarray, within: float,
        seen: np.ndarray, met: np.ndarray,
    ) -> None:  # fmt: skip
        """How deep points are in the mesh, negative outside [m], and outward normals in space: met, (n, 4); -inf for
        points that are more than `within` [m] outside. positions: [m], (n, 3); body, centre, pose: rows of
        `ShapeMotion`; seen: (n, SEEN), brought up to date."""
        half = 0.5 * self.thickness
        _look(len(positions), positions, body, centre, pose, self.bound, within, half, *self._tree, seen, met)

    @cached_property
    def _tree(self) -> tuple[np.ndarray, ...]:
        """boxes: low and high corner of each box [m], (boxes, 6). ways: of a box that is divided, those of its halves;
        of another, minus one minus its first triangle, and how many it has; (boxes, 2). which: triangles in the order
        of the boxes. corners: of those, (n, 9). normals: of each the pseudonormals of its face, its edges ab, bc, ca
        and its corners, (n, 7, 3)."""
        corners = self.points[self.triangles]
        low, high, middle = corners.min(axis=1), corners.max(axis=1), corners.mean(axis=1)
        boxes, ways, which = [], [], []

        def divide(mine: np.ndarray) -> int:
            number = len(boxes)
            boxes.append([*low[mine].min(axis=0), *high[mine].max(axis=0)])
            ways.append([0, 0])
            if len(mine) <= LEAF:
                ways[number] = [-1 - len(which), len(mine)]
                which.extend(mine.tolist())
                return number
            axis = int(np.argmax(np.ptp(middle[mine], axis=0)))
            order = mine[np.argsort(middle[mine, axis], kind="stable")]
            ways[number] = [divide(np.sort(order[: len(order) // 2])), divide(np.sort(order[len(order) // 2 :]))]
            return number

        divide(np.arange(len(self.triangles)))
        order = np.array(which)
        return (
            np.array(boxes), np.array(ways, np.int64), order, corners[order].reshape(-1, 9).copy(),
            self._pseudonormals()[order],
        )  # fmt: skip

    def _pseudonormals(self) -> np.ndarray:
        face = self._double_areas / np.maximum(np.linalg.norm(self._double_areas, axis=1), 1e-300)[:, None]
        corners = self.points[self.triangles]
        at_corner = np.zeros_like(self.points)
        for k in range(3):
            u, v = (corners[:, (k + j) % 3] - corners[:, k] for j in (1, 2))
            angle = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.sum(u * v, axis=1))
            np.add.at(at_corner, self.triangles[:, k], angle[:, None] * face)
        ends = np.sort(np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
        _, edge = np.unique(ends, axis=0, return_inverse=True)
        at_edge = np.zeros((int(edge.max()) + 1, 3))
        np.add.at(at_edge, edge.ravel(), np.repeat(face, 3, axis=0))
        of_edges = at_edge[edge.ravel()].reshape(-1, 3, 3)
        return np.concatenate([face[:, None], of_edges, at_corner[self.triangles]], axis=1)


def mass_properties(points: np.ndarray, triangles: np.ndarray, is_sheet: bool) -> tuple[float, np.ndarray, np.ndarray]:
    """Volume [m^3] of a solid, or area [m^2] of a sheet; centre of mass [m], (3,); and the inertia about it per mass
    [m^2], (3, 3), of uniform density. Exact: of tetrahedra from one point, or of triangles."""
    origin = points.mean(axis=0)
    a, b, c = (points[triangles[:, k]] - origin for k in range(3))
    normal = np.cross(b - a, c - a)
    weight = 0.5 * np.linalg.norm(normal, axis=1) if is_sheet else np.sum(a * normal, axis=1) / 6.0
    total, s = float(weight.sum()), a + b + c
    parts = 3.0 if is_sheet else 4.0
    centre = weight @ s / (parts * total)
    squares = sum(np.einsum("n,ni,nj->ij", weight, v, v) for v in (a, b, c, s)) / (parts * (parts + 1.0) * total)
    squares -= np.outer(centre, centre)
    return total, centre + origin, np.trace(squares) * np.eye(3) - squares


@kernel
def _look(
    n, positions, body, centre, pose, radius, within, half, boxes, ways, which, corners, normals, seen, met_out
):  # fmt: skip
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        waiting = np.empty(DEEP, np.int64)
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            met_out[i, 0] = -math.inf
            rx = positions[i, 0] - body[0] - centre[0]
            ry = positions[i, 1] - body[1] - centre[1]
            rz = positions[i, 2] - body[2] - centre[2]
            if rx * rx + ry * ry + rz * rz > (radius + within) ** 2:
                continue
            x = pose[0] * rx + pose[3] * ry + pose[6] * rz
            y = pose[1] * rx + pose[4] * ry + pose[7] * rz
            z = pose[2] * rx + pose[5] * ry + pose[8] * rz
            moved = math.sqrt((x - seen[i, 0]) ** 2 + (y - seen[i, 1]) ** 2 + (z - seen[i, 2]) ** 2)
            if seen[i, 3] - moved > within:  # it cannot have come near since
                continue
            best, nearest = math.inf, -1
            sx, sy, sz, share, other = 0.0, 0.0, 0.0, 0.0, 0.0
            hint, left = int(seen[i, 4]), 1
            waiting[0] = 0
            while left > 0 or hint >= 0:
                if hint >= 0:  # the triangle that was closest last time, before all others
                    first, count = hint, 1
                    hint = -1
                else:
                    left -= 1
                    k = waiting[left]
                    if from_box(boxes, k, x, y, z) > best * SLACK:
                        continue
                    first, count = -1 - ways[k, 0], ways[k, 1]
                    if first < 0:
                        p, q = ways[k, 0], ways[k, 1]
                        if from_box(boxes, p, x, y, z) < from_box(boxes, q, x, y, z):
                            p, q = q, p
                        waiting[left], waiting[left + 1] = p, q  # the nearer one is the next
                        left += 2
                        continue
                for t in range(first, first + count):
                    u, v, dx, dy, dz = on_triangle(
                        x, y, z, corners[t, 0], corners[t, 1], corners[t, 2], corners[t, 3], corners[t, 4],
                        corners[t, 5], corners[t, 6], corners[t, 7], corners[t, 8],
                    )  # fmt: skip
                    square = dx * dx + dy * dy + dz * dz
                    if square < best or (square == best and which[t] < which[nearest]):
                        best, nearest, share, other, sx, sy, sz = square, t, u, v, dx, dy, dz
            away = math.sqrt(best)
            part = feature(share, other)
            mx, my, mz = normals[nearest, part, 0], normals[nearest, part, 1], normals[nearest, part, 2]
            side = 1.0 if half > 0.0 or sx * mx + sy * my + sz * mz >= 0.0 else -1.0
            if part > 0 or half > 0.0:  # on a face of a solid its normal is exact
                if away > TOUCHING:
                    mx, my, mz = side * sx / away, side * sy / away, side * sz / away
                else:
                    size = math.sqrt(mx * mx + my * my + mz * mz)
                    mx, my, mz = mx / size, my / size, mz / size
            depth = half - side * away
            seen[i, 0], seen[i, 1], seen[i, 2], seen[i, 3], seen[i, 4] = x, y, z, -depth, nearest
            if depth >= -within:
                met_out[i, 0] = depth
                met_out[i, 1] = pose[0] * mx + pose[1] * my + pose[2] * mz
                met_out[i, 2] = pose[3] * mx + pose[4] * my + pose[5] * mz
                met_out[i, 3] = pose[6] * mx + pose[7] * my + pose[8] * mz


@scalar
def from_box(boxes, k, x, y, z):
    """Square of the distance of a point from box k [m^2]."""
    dx = max(boxes[k, 0] - x, 0.0, x - boxes[k, 3])
    dy = max(boxes[k, 1] - y, 0.0, y - boxes[k, 4])
    dz = max(boxes[k, 2] - z, 0.0, z - boxes[k, 5])
    return dx * dx + dy * dy + dz * dz


@scalar
def feature(second, third):
    """On which part of a triangle a point of area coordinates lies: 0 face, 1 to 3 edges ab, bc, ca, 4 to 6 corners."""
    if second == 0.0 and third == 0.0:
        return 4
    if second == 1.0:
        return 5
    if third == 1.0:
        return 6
    if third == 0.0:
        return 1
    if second == 0.0:
        return 3
    return 2 if second == 1.0 - third else 0
