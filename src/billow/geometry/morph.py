"""A flat bag moved to other sizes: the same nodes and triangles, so that designs of one study have one mesh.

Rims, rings and holes are put where the new sizes want them. The nodes between change scale with the rim and, beyond
that, follow as a thin plate at rest would: their displacement solves the biharmonic equation, the Laplacian applied
twice, with cotangent weights on the mesh as it was (Botsch and Kobbelt, ACM Transactions on Graphics 23 (2004) 630-634,
section 3). Laplace's equation alone leaves all of the change of a small hole to its first ring of elements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.geometry.flat_cut import signed_areas

TOO_FAR = InputError.declare(
    "E-GEO-070",
    "the mesh cannot be moved to these sizes",
    where="bag.mesh_of",
    why="{why}",
    cause="sizes too far from those the mesh is made for, or elements too coarse for the smallest hole",
    remedy="choose sizes nearer to those of bag.mesh_of, make bag.mesh_of the middle of the range, or refine the mesh",
)

LEAST_ANGLE = 15.0
"""[deg] Smallest angle of a triangle that a move may make; one that was smaller before may stay."""
DIGITS = 10
"""Decimals of a coordinate [m] that are kept: other machines may differ in those behind."""


@dataclass(frozen=True)
class Ring:
    """Nodes (n,) about a centre [m] (2,) that move to another centre, factor [-] times as far from it."""

    nodes: np.ndarray
    before: np.ndarray
    after: np.ndarray
    factor: float


def moved(flat: np.ndarray, triangles: np.ndarray, rings: Sequence[Ring]) -> np.ndarray:
    """Flat points [m] (nodes, 2) after the nodes of all rings are where they belong; earlier rings win, the first is
    the rim.

    triangles: (triangles, 3). Raises InputError E-GEO-070 if a triangle turns over or gets too sharp.
    """
    goal = np.full_like(flat, np.nan)
    for ring in reversed(rings):
        goal[ring.nodes] = ring.after + ring.factor * (flat[ring.nodes] - ring.before)
    held = ~np.isnan(goal[:, 0])
    scaled = rings[0].after + rings[0].factor * (flat - rings[0].before)
    change = np.where(held[:, None], goal - scaled, 0.0)
    if change.any():
        change[~held] = _plate(flat, triangles, held, change)
    points = np.round(scaled + change, DIGITS)
    _require_shapely(flat[triangles], points[triangles])
    return points


def _plate(flat: np.ndarray, triangles: np.ndarray, held: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Displacement [m] (free nodes, 2) between the held ones."""
    from scipy.sparse import coo_matrix, diags
    from scipy.sparse.linalg import splu

    corner = flat[triangles]
    weights = []
    for k in range(3):  # of the edge opposite to corner k
        u, v = corner[:, (k + 1) % 3] - corner[:, k], corner[:, (k + 2) % 3] - corner[:, k]
        weights.append(0.5 * (u * v).sum(axis=1) / np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))
    one = np.concatenate([triangles[:, (k + 1) % 3] for k in range(3)])
    two = np.concatenate([triangles[:, (k + 2) % 3] for k in range(3)])
    weight = np.concatenate(weights)
    rows, columns = np.concatenate([one, two, one, two]), np.concatenate([two, one, one, two])
    entries = np.concatenate([-weight, -weight, weight, weight])
    matrix = coo_matrix((entries, (rows, columns)), shape=(len(flat), len(flat))).tocsr()
    area = np.bincount(triangles.ravel(), np.repeat(np.abs(signed_areas(corner)), 3), len(flat)) / 3.0
    matrix = (matrix @ diags(1.0 / area) @ matrix).tocsr()
    free = np.flatnonzero(~held)
    right = -matrix[free][:, held] @ change[held]
    return splu(matrix[free][:, free].tocsc()).solve(right)


def _require_shapely(before: np.ndarray, after: np.ndarray) -> None:
    """Raises InputError E-GEO-070. before, after: corners of triangles, [m], (triangles, 3, 2)."""
    turned = signed_areas(before) * signed_areas(after) <= 0.0
    if turned.any():
        raise TOO_FAR(why=f"{turned.sum()} of {len(turned)} triangles would turn over")
    was, now = smallest_angle(before), smallest_angle(after)
    sharp = now < np.minimum(LEAST_ANGLE, was - 1e-6)
    if sharp.any():
        least = now[sharp].min()
        raise TOO_FAR(
            why=f"{sharp.sum()} of {len(sharp)} triangles would have an angle below {LEAST_ANGLE:g} degrees, the "
            f"sharpest of {least:.3g}"
        )


def smallest_angle(corners: np.ndarray) -> np.ndarray:
    """Smallest angle of flat triangles, [deg], (triangles,); corners: [m], (triangles, 3, 2)."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    a, b, c = np.sort(sides, axis=1).T
    return np.degrees(np.arccos(np.clip((b * b + c * c - a * a) / (2.0 * b * c), -1.0, 1.0)))
