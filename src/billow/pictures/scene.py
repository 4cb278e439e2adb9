"""What a picture shows: bodies made of triangles, each with its colours, and how they come together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

TUBE_SIDES = 8


@dataclass(frozen=True)
class Body:
    """Triangles with their colours.

    points: [m], (nodes, 3). triangles: (n, 3), counter-clockwise seen from outside. colours: red, green, blue from 0
    to 1 of each corner, (n, 3, 3). patch: (n,) int, which smooth piece of the body a triangle belongs to: the edges
    between them are drawn. cut_colour: of its inside where a plane cuts it, (3,), for a solid; None for a shell, whose
    inside is seen. cut: whether a plane that cuts the picture cuts it.
    """

    points: np.ndarray
    triangles: np.ndarray
    colours: np.ndarray
    patch: np.ndarray
    cut_colour: tuple[float, float, float] | None = None
    cut: bool = True


@dataclass(frozen=True)
class Plane:
    """A plane that cuts a picture: what lies on the positive side of normal . x = offset is left away. normal: (3,),
    of length one; offset: [m]."""

    normal: np.ndarray
    offset: float

    def kept(self, points: np.ndarray) -> np.ndarray:
        """Distance of points [m] (n, 3) behind the plane, [m], (n,)."""
        return self.offset - np.asarray(points, float) @ self.normal

    def facing(self, towards: np.ndarray) -> Plane:
        """The same plane, with the side left away that lies towards a viewer, (3,)."""
        return self if self.normal @ towards > 0.0 else Plane(-self.normal, -self.offset)


def tubes(
    starts: np.ndarray, ends: np.ndarray, radius: float, colour: tuple[float, float, float], cut: bool = True
) -> Body:
    """Lines from starts to ends [m], (n, 3) each, as tubes of a radius [m]; those without length are left out."""
    along = np.asarray(ends, float) - starts
    length = np.linalg.norm(along, axis=1)
    seen = length > 1e-12
    starts, ends, along = (
        np.asarray(starts, float)[seen],
        np.asarray(ends, float)[seen],
        along[seen] / length[seen, None],
    )
    # Any direction that is not along the line gives the first of two across it.
    helper = np.eye(3)[np.abs(along).argmin(axis=1)]
    first = np.cross(along, helper)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-12)
    second = np.cross(along, first)
    angle = 2.0 * np.pi * np.arange(TUBE_SIDES) / TUBE_SIDES
    ring = radius * (np.cos(angle)[:, None, None] * first + np.sin(angle)[:, None, None] * second)
    points = np.concatenate([starts + ring, ends + ring]).transpose(1, 0, 2).reshape(-1, 3)
    k = np.arange(TUBE_SIDES)
    after = (k + 1) % TUBE_SIDES
    one = np.concatenate([
        np.stack([k, after, after + TUBE_SIDES], axis=1), np.stack([k, after + TUBE_SIDES, k + TUBE_SIDES], axis=1)
    ])  # fmt: skip
    triangles = (one[None] + 2 * TUBE_SIDES * np.arange(len(starts))[:, None, None]).reshape(-1, 3)
    colours = np.tile(np.asarray(colour, float), (len(triangles), 3, 1))
    return Body(points, triangles, colours, np.zeros(len(triangles), int), colour, cut)


@dataclass(frozen=True)
class Scene:
    """All bodies of a picture as one mesh.

    points: [m], (nodes, 3). triangles: (n, 3). normals and colours: of each corner, (n, 3, 3). surface: (n,) int32,
    which piece of which body. cut_colour: (n, 3), nan for shells. kept: distance of each node behind the plane that
    cuts [m], (nodes,); inf where nothing is cut. solid: (n,) int32, number of the solid that a triangle belongs to, -1
    for shells and what is not cut. plane: the plane that cuts.
    """

    points: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    colours: np.ndarray
    surface: np.ndarray
    cut_colour: np.ndarray
    kept: np.ndarray
    solid: np.ndarray
    plane: Plane | None = None

    @classmethod
    def of(cls, bodies: Sequence[Body], plane: Plane | None = None) -> Scene:
        nodes = np.cumsum([0, *(len(body.points) for body in bodies)])
        pieces = np.cumsum([0, *(int(body.patch.max(initial=-1)) + 1 for body in bodies)])
        kept = [
            np.full(len(body.points), np.inf) if plane is None or not body.cut else plane.kept(body.points)
            for body in bodies
        ]
        return cls(
            np.concatenate([np.asarray(body.points, float) for body in bodies]),
            np.concatenate([body.triangles + k for body, k in zip(bodies, nodes, strict=False)]).astype(np.int64),
            np.concatenate([corner_normals(body.points, body.triangles, body.patch) for body in bodies]),
            np.concatenate([body.colours for body in bodies]),
            np.concatenate([body.patch + first for body, first in zip(bodies, pieces, strict=False)]).astype(np.int32),
            np.concatenate([
                np.tile(np.full(3, np.nan) if body.cut_colour is None else body.cut_colour, (len(body.triangles), 1))
                for body in bodies
            ]),
            np.concatenate(kept),
            np.concatenate([
                np.full(len(body.triangles), k if body.cut and body.cut_colour is not None else -1, np.int32)
                for k, body in enumerate(bodies)
            ]),
            plane,
        )  # fmt: skip


def corner_normals(points: np.ndarray, triangles: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """Normal at each corner, (n, 3, 3): the mean over the triangles of its patch that meet there, by their areas."""
    corners = np.asarray(points, float)[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    key = triangles + len(points) * patch[:, None].astype(np.int64)
    found, where = np.unique(key.ravel(), return_inverse=True)
    sums = np.stack([np.bincount(where, np.repeat(normals[:, k], 3), len(found)) for k in range(3)], axis=1)
    sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)
    return sums[where].reshape(-1, 3, 3)
