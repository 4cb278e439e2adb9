"""What the flight tests share: boxes, a small scene that flies, and an inside test that owes nothing to the package."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from billow.geometry.chambers import Chambers
from billow.geometry.search_grid import USUAL, SearchGrid
from billow.parts.gas.corpuscular.flight import Flock, Motion, WallResponse, fly
from billow.parts.gas.corpuscular.impact_bank import Hits, ImpactBank
from billow.parts.gas.corpuscular.inside_points import Enclosure
from billow.parts.gas.corpuscular.walls import Walls

MASS = 2e-7  # kg, 50 g in 250,000 particles


def box(divisions=4, rooms=1):
    """Unit cubes side by side along x, faces in `divisions`^2 squares of two triangles, inner walls as single layers.

    Returns triangles, positions, behind, ahead. Corners are exact multiples of 1/divisions.
    """
    number, triangles, behind, ahead = {}, [], [], []

    def square(corners, inside, outside):
        nodes = [number.setdefault(c, len(number)) for c in corners]
        triangles.extend([[nodes[0], nodes[1], nodes[2]], [nodes[0], nodes[2], nodes[3]]])
        behind.extend([inside] * 2)
        ahead.extend([outside] * 2)

    m = divisions
    for room in range(rooms):
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            for high in (0, 1):
                if axis == 0 and high == 0 and room > 0:
                    continue  # the inner wall was made by the room before
                for i in range(m):
                    for j in range(m):
                        corners = []
                        for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                            c = [0, 0, 0]
                            c[axis], c[u], c[v] = high * m, a, b
                            c[0] += room * m
                            corners.append(tuple(c))
                        beyond = room + 1 if axis == 0 and high and room + 1 < rooms else -1
                        square(corners if high else corners[::-1], room, beyond)
    return np.array(triangles), np.array(list(number), dtype=float) / m, np.array(behind), np.array(ahead)


def enclosure(triangles, positions, behind=None, ahead=None, group=None):
    """Of one chamber behind all triangles, or of those given; group: of chambers that openings join."""
    if behind is None:
        return Enclosure(triangles, positions, Chambers.single(len(triangles)))
    return Enclosure(triangles, positions, Chambers(tuple(map(str, range(behind.max() + 1))), behind, ahead), group)


def flock_of(position, velocity, chamber=0):
    n = len(position)
    return Flock(
        np.array(position, dtype=float), np.array(velocity, dtype=float), np.zeros(n, np.int32),
        np.arange(n, dtype=np.int64), np.full(n, chamber, np.int32), np.full(n, -1, np.int32),
        np.zeros(n, np.int32), np.zeros(n, np.int32),
    )  # fmt: skip


class Scene:
    """Particles inside moving walls; `advance` flies one step to the nodes' new places."""

    def __init__(
        self, triangles, positions, flock, behind=None, ahead=None, pass_probability=None, fineness=USUAL, group=None
    ):  # fmt: skip
        n = len(triangles)
        self.triangles, self.positions, self.flock = triangles, np.array(positions, dtype=float), flock
        self.walls = Walls.build(triangles, enclosure(triangles, positions, behind, ahead).chambers, group)
        pass_probability = np.zeros(n) if pass_probability is None else pass_probability
        self.response = WallResponse(pass_probability, np.zeros(n, np.int32), np.empty(0))
        self.bank, self.hits = ImpactBank.empty(n), Hits.empty(len(flock.position))
        self.grid, self.step, self.work = None, 0, 0.0
        self.fineness = fineness

    def advance(self, dt, end=None, born=None):
        end = self.positions.copy() if end is None else end
        if self.grid is None:
            self.grid = SearchGrid.build(self.triangles, self.positions, end, fineness=self.fineness)
        else:
            self.grid = self.grid.follow(self.triangles, self.positions, end, self.fineness)
        tally = fly(
            self.flock, np.array([MASS]), self.walls, self.grid, Motion(self.positions, end, dt), self.response,
            self.hits, self.bank, 11, self.step, born,
        )  # fmt: skip
        self.positions, self.step = end, self.step + 1
        self.work += tally.energy_to_walls
        return tally


def kinetic(flock):
    return 0.5 * MASS * float(np.sum(flock.velocity**2))


@njit(cache=False)
def winding(points, triangles, positions):
    """Solid angle of the closed surface over 4 pi: one inside, zero outside (van Oosterom and Strackee 1983)."""
    out = np.zeros(len(points))
    for p in range(len(points)):
        x, y, z = points[p]
        for t in range(len(triangles)):
            i, j, k = triangles[t]
            ax, ay, az = positions[i, 0] - x, positions[i, 1] - y, positions[i, 2] - z
            bx, by, bz = positions[j, 0] - x, positions[j, 1] - y, positions[j, 2] - z
            cx, cy, cz = positions[k, 0] - x, positions[k, 1] - y, positions[k, 2] - z
            la = math.sqrt(ax * ax + ay * ay + az * az)
            lb = math.sqrt(bx * bx + by * by + bz * bz)
            lc = math.sqrt(cx * cx + cy * cy + cz * cz)
            volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
            flat = (
                la * lb * lc + (ax * bx + ay * by + az * bz) * lc + (bx * cx + by * cy + bz * cz) * la
                + (cx * ax + cy * ay + cz * az) * lb
            )  # fmt: skip
            out[p] += math.atan2(volume, flat) / (2.0 * math.pi)
    return out


def inside_points(triangles, positions, wanted, rng, deepest):
    """Points inside a closed surface, most of them close to it: (n, 3)."""
    n = 6 * wanted
    t, weight = rng.integers(0, len(triangles), n), rng.dirichlet([1.0, 1.0, 1.0], n)
    corners = positions[triangles[t]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    depth = deepest * 10.0 ** rng.uniform(-4.0, 0.0, n)
    points = np.einsum("ij,ijk->ik", weight, corners) - depth[:, None] * normal
    return points[np.abs(winding(points, triangles, positions) - 1.0) < 1e-6][:wanted]
