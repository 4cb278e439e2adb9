"""Whether the obstacles leave the bag its room at the start."""

from __future__ import annotations

import numpy as np

from billow.base.errors import InputError
from billow.solver.model import Model

PENETRATES = InputError.declare(
    "E-GEO-020",
    "{body} penetrates the bag at the start by {depth:.3g} mm",
    where="obstacles.{body}",
    why="the penalty force would shoot the fabric away",
    cause="a clearance that is too small for the start shape, or a plate above z = 0",
    remedy="raise its clearance, or lower the height of the plate",
)
INSIDE = InputError.declare(
    "E-GEO-021",
    "{body} lies inside the bag at the start",
    where="obstacles.{body}",
    why="the gas does not know that it takes up room there",
    cause="a small obstacle within a start shape that is high",
    remedy="raise its clearance, or move it aside with offset",
)


def require_start_clear(model: Model) -> None:
    """Raises InputError if an obstacle touches the bag at the start, E-GEO-020, or lies inside it, E-GEO-021."""
    for body, deepest in model.bodies.touching_at_start(model.start, model.inverse_mass):
        raise PENETRATES(body=body.name, depth=1e3 * deepest)
    for body in model.bodies.bodies:
        if body.is_bounded and _encloses(model, body.start.centre):
            raise INSIDE(body=body.name)


def _encloses(model: Model, point: np.ndarray) -> bool:
    """Whether the closed bag surrounds a point [m]: its triangles then fill the whole view, 4 pi (van Oosterom and
    Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125)."""
    corners = model.start[model.surface.triangles] - point
    a, b, c = (corners[:, k] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    box = np.einsum("ij,ij->i", a, np.cross(b, c))
    half_angle = np.arctan2(box, la * lb * lc + ab * lc + bc * la + ca * lb)
    return abs(half_angle.sum()) > np.pi
