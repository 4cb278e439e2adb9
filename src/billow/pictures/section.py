"""Where a plane cuts a mesh."""

from __future__ import annotations

import math
import re

import numpy as np

from billow.base.errors import InputError
from billow.base.units import in_unit
from billow.pictures.scene import Plane

NO_PLANE = InputError.declare(
    "E-PIC-001",
    "{text!r} is no plane",
    where="--section",
    why="a section is named by an axis and the place on it",
    remedy="write for example --section y=0 or --section 'z=120 mm'",
)

AXES = "xyz"


def parse_plane(text: str) -> Plane:
    """The plane of a text such as "y=0" or "z = 120 mm". InputError E-PIC-001."""
    match = re.fullmatch(r"\s*([xyz])\s*=\s*(.+)", text)
    try:
        if match is None:
            raise ValueError
        offset = in_unit(match[2], "m")
        if not math.isfinite(offset):
            raise ValueError("the place is not a finite number")
    except ValueError as error:
        raise NO_PLANE(text=text[:40], why=str(error) or None) from None
    return Plane(np.eye(3)[AXES.index(match[1])], offset)


def across(plane: Plane) -> tuple[int, int]:
    """The axes, 0 to 2, that go right and up in a picture of a section: x and z for a plane of y."""
    normal = int(np.abs(plane.normal).argmax())
    return ((1, 2), (0, 2), (0, 1))[normal]


def cut(
    points: np.ndarray, triangles: np.ndarray, plane: Plane, moved: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Where a plane cuts a triangle mesh: segments [m], (segments, 2 ends, 3), and the triangle of each, (segments,).

    points: [m], (nodes, 3); triangles: (triangles, 3) int; moved: where the nodes are of which the same line of fabric
    is wanted, [m], (nodes, 3), by default the same.
    A node exactly on the plane counts as behind it, so every cut triangle gives one segment, none is given twice, and
    a closed surface gives closed loops.
    """
    points = np.asarray(points, float)
    distance = plane.kept(points)
    behind = distance >= 0.0
    side = behind[triangles]
    which = np.flatnonzero(side.any(axis=1) & ~side.all(axis=1))
    crossed = triangles[which]
    edges = np.stack([crossed, np.roll(crossed, -1, axis=1)], axis=2)  # (triangles, 3 edges, 2 ends)
    ends = edges[behind[edges[..., 0]] != behind[edges[..., 1]]]  # two edges of each triangle, in order
    start, stop = ends[:, 0], ends[:, 1]
    part = (distance[start] / (distance[start] - distance[stop]))[:, None]
    there = points if moved is None else moved
    return (there[start] + part * (there[stop] - there[start])).reshape(-1, 2, 3), which
