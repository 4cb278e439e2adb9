"""Whether the obstacles leave the bag its room at the start."""

from __future__ import annotations

import numpy as np

from billow.base.errors import InputError
from billow.solver.model import Model


def require_start_clear(model: Model) -> None:
    """Raises InputError if an obstacle touches the bag at the start, E-GEO-020, or lies inside it, E-GEO-021."""
    for body, deepest in model.bodies.touching_at_start(model.start, model.inverse_mass):
        raise InputError(
            "E-GEO-020",
            f"{body.name} penetrates the bag at the start by {1e3 * deepest:.3g} mm",
            where=f"obstacles.{body.name}",
            why="the penalty force would shoot the fabric away",
            remedy="raise its clearance, or lower the plate's height",
        )
    for body in model.bodies.bodies:
        if body.is_bounded and _encloses(model, body.start.centre):
            raise InputError(
                "E-GEO-021",
                f"{body.name} lies inside the bag at the start",
                where=f"obstacles.{body.name}",
                why="the gas does not know that it takes up room there",
                remedy="raise its clearance, or move it aside with offset",
            )


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
