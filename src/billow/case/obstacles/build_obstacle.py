"""From the `[[obstacles]]` tables to obstacles, and whether they leave the bag its room at the start."""

from __future__ import annotations

import numpy as np

from billow.base.errors import InputError
from billow.case.obstacles import schema_obstacle
from billow.geometry.shapes import super_ellipsoid
from billow.parts.bodies.rigid_body import RigidBody, RigidState, quaternion_about
from billow.parts.bodies.rigid_contact import Plate, SuperEllipsoid, SurfaceLaw
from billow.solver.forces import push_apart
from billow.solver.model import Model, Obstacle, start_state


def build_obstacle(obstacle: schema_obstacle.Plate | schema_obstacle.SuperEllipsoid) -> Obstacle:
    law = SurfaceLaw(obstacle.slope, obstacle.friction, obstacle.damping)
    if isinstance(obstacle, schema_obstacle.Plate):
        body = RigidBody(1.0, np.ones(3), locked=True)
        start = RigidState(np.array([0.0, 0.0, obstacle.height]))
        return Obstacle(obstacle.name, Plate(np.array([0.0, 0.0, 1.0])), law, body, start)
    radii = np.array([obstacle.radii] * 3 if isinstance(obstacle.radii, float) else obstacle.radii)
    inertia = super_ellipsoid.principal_inertia(obstacle.mass, radii, obstacle.degree)
    start = RigidState(
        centre=np.array([*obstacle.offset, obstacle.clearance + radii[2]]),
        quaternion=quaternion_about(np.array([1.0, 0.0, 0.0]), np.radians(obstacle.angle_about_x)),
        velocity=np.array(obstacle.velocity) * (not obstacle.locked),
    )
    body = RigidBody(obstacle.mass, inertia, obstacle.locked)
    return Obstacle(obstacle.name, SuperEllipsoid(radii, obstacle.degree), law, body, start)


def require_start_clear(model: Model) -> None:
    """Raises InputError if an obstacle touches the bag at the start, E-GEO-020, or lies inside it, E-GEO-021."""
    state = start_state(model)
    push_apart(model, state, 0.0)
    for obstacle, deepest in zip(model.obstacles, state.contact.deepest.tolist(), strict=True):
        if deepest > 1e-6:
            raise InputError(
                "E-GEO-020",
                f"{obstacle.name} penetrates the bag at the start by {1e3 * deepest:.3g} mm",
                where=f"obstacles.{obstacle.name}",
                why="the penalty force would shoot the fabric away",
                remedy="raise its clearance, or lower the plate's height",
            )
        if isinstance(obstacle.shape, SuperEllipsoid) and _encloses(model, obstacle.start.centre):
            raise InputError(
                "E-GEO-021",
                f"{obstacle.name} lies inside the bag at the start",
                where=f"obstacles.{obstacle.name}",
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
