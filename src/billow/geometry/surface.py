"""A triangulated surface: connectivity, node-to-corner lists, volume, areas, closedness.

A *corner* is one vertex of one triangle; corner `3*t + c` is vertex `c` of triangle `t`. Loads are written per corner
and gathered per node, in the fixed order of the corner list, so that the result does not depend on threads.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import prange

from billow.base.compiled import kernel
from billow.base.errors import InputError
from billow.geometry.chambers import Chambers
from billow.geometry.components import components
from billow.geometry.triangle import double_area_vector

NOT_CLOSED = InputError.declare(
    "E-GEO-001",
    "the bag is not closed: {free} free edges, {crowded} edges shared by more than two triangles",
    why="gas would escape through the gap; every edge of a chamber must join exactly two of its triangles",
    cause="a seam whose nodes are not merged, a hole, or a wall that divides the bag",
    remedy="merge the nodes along the seam, close the hole with a vent, mouth or opening, or correct which chambers "
    "lie behind and ahead of that part",
)
MIXED_ORIENTATION = InputError.declare(
    "E-GEO-002",
    "neighbouring triangles are oriented in opposite senses",
    why="inside and outside cannot be told apart, so pressure would push both ways",
    remedy="reverse the node order of the flipped triangles",
)
NORMALS_POINT_INWARDS = InputError.declare(
    "E-GEO-003",
    "all normals {of}point inwards (the enclosed volume is negative)",
    why="pressure would crush the bag instead of inflating it",
    remedy="reverse the node order of every triangle{there}",
)

PART_KINDS = ("fabric", "mouth", "vent", "opening")
"""What a triangle is: fabric, the inflator's mouth, a vent hole, or an opening between two chambers."""

SOLID = ("fabric", "mouth")
"""Kinds of parts that can be touched; the others are holes."""


@dataclass(frozen=True)
class Surface:
    """Connectivity of a surface; positions live elsewhere.

    triangles: (triangles, 3) uint32, counter-clockwise seen from outside, so that normals point outwards.
    part: (triangles,) int32, index into part_names. part_names: for example ("front", "rear", "mouth", "vent_1").
    part_kinds: one of PART_KINDS for each part; all but fabric are virtual triangles that close a hole.
    chambers: which chamber lies on either side of each triangle.
    corner_start: (nodes + 1,) int64 and corners: (3 * triangles,) int64, the corners of each node in ascending order.
    """

    triangles: np.ndarray
    part: np.ndarray
    part_names: tuple[str, ...]
    part_kinds: tuple[str, ...]
    chambers: Chambers
    node_count: int
    corner_start: np.ndarray
    corners: np.ndarray

    @classmethod
    def build(
        cls, triangles: np.ndarray, part: np.ndarray, part_names: tuple[str, ...], node_count: int,
        part_kinds: tuple[str, ...] | None = None, chambers: Chambers | None = None,
    ) -> Surface:  # fmt: skip
        """Surface from (triangles, 3) node indices and (triangles,) part indices.

        part_kinds: by default what each name begins with, else fabric. chambers: a single one by default.
        """
        if part_kinds is None:
            part_kinds = tuple(next((k for k in PART_KINDS if name.startswith(k)), "fabric") for name in part_names)
        chambers = chambers or Chambers.single(len(triangles))
        triangles = np.ascontiguousarray(triangles, dtype=np.uint32)
        flat = triangles.ravel().astype(np.int64)
        corners = np.argsort(flat, kind="stable").astype(np.int64)
        start = np.zeros(node_count + 1, dtype=np.int64)
        np.cumsum(np.bincount(flat, minlength=node_count), out=start[1:])
        return cls(
            triangles, np.ascontiguousarray(part, dtype=np.int32), part_names, part_kinds, chambers, node_count, start,
            corners,
        )  # fmt: skip

    @property
    def triangle_count(self) -> int:
        return len(self.triangles)

    def triangles_of(self, part_name: str) -> np.ndarray:
        """Indices (n,) int64 of the triangles of a part; empty if there is no such part."""
        if part_name not in self.part_names:
            return np.empty(0, dtype=np.int64)
        return np.flatnonzero(self.part == self.part_names.index(part_name))

    def triangles_of_kind(self, kind: str) -> np.ndarray:
        """Indices (n,) int64 of the triangles of all parts of a kind."""
        return np.flatnonzero(np.array([k == kind for k in self.part_kinds])[self.part])

    @cached_property
    def solid(self) -> np.ndarray:
        """Indices (n,) int64 of the triangles that can be touched."""
        return np.flatnonzero(np.isin(self.part, [k for k, kind in enumerate(self.part_kinds) if kind in SOLID]))

    def parts_at(self, node: int) -> str:
        """Names of the parts around a node, for messages."""
        around = (self.triangles == node).any(axis=1)
        return ", ".join(sorted({self.part_names[p] for p in self.part[around]}))

    def volume(self, positions: np.ndarray) -> float:
        """Enclosed volume of all chambers [m^3] by Gauss' theorem; positions: [m], (nodes, 3)."""
        return float(self.chambers.volumes(self.triangles, positions).sum())


def area_vectors(triangles: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Area vector (normal times area) of each triangle: [m^2], (triangles, 3)."""
    vectors = np.empty((len(triangles), 3))
    # One type each, so that one kernel serves all.
    triangles, positions = np.ascontiguousarray(triangles, np.uint32), np.ascontiguousarray(positions, np.float64)
    _area_vectors(len(triangles), triangles, positions, vectors)
    return vectors


@kernel
def _area_vectors(n, triangles, positions, vectors_out):
    for t in prange(n):
        nx, ny, nz = double_area_vector(positions, triangles[t, 0], triangles[t, 1], triangles[t, 2])
        vectors_out[t, 0], vectors_out[t, 1], vectors_out[t, 2] = 0.5 * nx, 0.5 * ny, 0.5 * nz


def nodal_share(triangles: np.ndarray, per_triangle: np.ndarray, node_count: int) -> np.ndarray:
    """A third of each triangle's value on each of its nodes: (nodes,)."""
    return np.bincount(triangles.ravel(), weights=np.repeat(per_triangle / 3.0, 3), minlength=node_count)


def check_closed(surface: Surface, positions: np.ndarray, where: str) -> None:
    """Require of every chamber: each edge of its boundary is used exactly twice, in opposite directions, and the volume
    of each of its closed pieces is not negative, but for a piece that lies within another.

    Raises InputError E-GEO-001 (open or not manifold), E-GEO-002 (mixed orientation), E-GEO-003 (normals point
    inwards).
    """
    for chamber, name in enumerate(surface.chambers.names):
        place = where if surface.chambers.count == 1 else f"{where}, chamber {name}"
        _check_edges(surface, chamber, positions, place)
        _check_pieces(surface, chamber, positions, place)


def _check_pieces(surface: Surface, chamber: int, positions: np.ndarray, where: str) -> None:
    boundary = surface.chambers.boundary(chamber, surface.triangles).astype(np.int64)
    piece = components(len(positions), np.concatenate([boundary[:, :2], boundary[:, 1:]]))[boundary[:, 0]]
    corners = positions[boundary] - positions[boundary[0, 0]]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    pieces = np.unique(piece)
    for one in pieces:
        mine = piece == one
        size = np.abs(volume[mine]).sum()
        if volume[mine].sum() >= -1e-12 * size or encloses(boundary[~mine], positions, positions[boundary[mine][0, 0]]):
            continue
        names = surface.chambers.boundary(chamber, surface.part)[mine]
        listed = ", ".join(surface.part_names[p] for p in np.unique(names))
        centre = ", ".join(f"{v:.4g}" for v in positions[np.unique(boundary[mine])].mean(axis=0))
        of, there = (f"of a closed piece of {mine.sum()} triangles ", " of that piece") if len(pieces) > 1 else ("", "")
        at = f"{where}, part {listed}, around ({centre}) m" if len(pieces) > 1 else where
        raise NORMALS_POINT_INWARDS(where=at, of=of, there=there)


def encloses(triangles: np.ndarray, positions: np.ndarray, point: np.ndarray) -> bool:
    """Whether closed triangles (n, 3) surround a point [m]: they then fill the whole view, 4 pi (van Oosterom and
    Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125)."""
    corners = positions[triangles] - point
    a, b, c = (corners[:, k] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    box = np.einsum("ij,ij->i", a, np.cross(b, c))
    half_angle = np.arctan2(box, la * lb * lc + ab * lc + bc * la + ca * lb)
    return bool(abs(half_angle.sum()) > np.pi)


def _check_edges(surface: Surface, chamber: int, positions: np.ndarray, where: str) -> None:
    boundary = surface.chambers.boundary(chamber, surface.triangles).astype(np.int64)
    edges = np.concatenate([boundary[:, [0, 1]], boundary[:, [1, 2]], boundary[:, [2, 0]]])

    def place(k):
        point = ", ".join(f"{v:.4g}" for v in positions[edges[k]].mean(axis=0))
        part = surface.part_names[surface.chambers.boundary(chamber, surface.part)[k % len(boundary)]]
        return f"{where}, edge of part {part} between nodes {edges[k, 0]} and {edges[k, 1]} at ({point}) m"

    undirected = np.sort(edges, axis=1)
    nodes = len(positions)
    _, first, count = np.unique(undirected[:, 0] * nodes + undirected[:, 1], return_index=True, return_counts=True)
    if (count != 2).any():
        where = place(first[np.argmax(count != 2)])
        raise NOT_CLOSED(where=where, free=int((count == 1).sum()), crowded=int((count > 2).sum()))
    directed = edges[:, 0] * nodes + edges[:, 1]
    _, first, count = np.unique(directed, return_index=True, return_counts=True)
    if (count > 1).any():
        raise MIXED_ORIENTATION(where=place(first[np.argmax(count > 1)]))
