"""The `[[obstacles]]` table of a super-ellipsoid."""

from __future__ import annotations

from typing import Literal

import numpy as np

from billow.case.obstacles.table import ObstacleTable
from billow.case.quantity import quantity
from billow.case.text import Name
from billow.geometry.shapes import super_ellipsoid
from billow.geometry.shapes.pose import above_bag
from billow.parts.bodies.rigid_body import RigidBody, RigidState, moving

Radius = quantity("m", 5e-3, 5.0)
Speed = quantity("m/s", -100.0, 100.0)
Spin = quantity("rad/s", -1e3, 1e3)


class SuperEllipsoid(ObstacleTable):
    """Rigid super-ellipsoid |x/a|^n + |y/b|^n + |z/c|^n = 1 above the bag, locked or free."""

    shape: Literal["super-ellipsoid"]
    """super-ellipsoid"""
    name: Name = "impactor"
    """Name in results."""
    radii: Radius | tuple[Radius, Radius, Radius] = 0.15
    """Radii a, b, c along its own axes; one number for all three."""
    degree: quantity("-", 2.0, 10.0) = 2.0
    """Degree n: 2 is an ellipsoid, larger is boxier."""
    clearance: quantity("m", 0.0, 5.0) = 0.15
    """Height of its centre minus its third radius above the plane z = 0: the gap to the flat bag."""
    offset: tuple[quantity("m", -5.0, 5.0), quantity("m", -5.0, 5.0)] = (0.0, 0.0)
    """Position of its centre across the bag's axis (x, y)."""
    angle_about_x: quantity("deg", -180.0, 180.0) = 0.0
    """Orientation: rotation about the x axis."""
    locked: bool = True
    """Locked in place, or free to move with six degrees of freedom."""
    mass: quantity("kg", 1e-3, 1000.0) = 4.5
    """Mass; inertia is that of a solid of uniform density."""
    velocity: tuple[Speed, Speed, Speed] = (0.0, 0.0, 0.0)
    """Velocity at the start, if free."""
    spin: tuple[Spin, Spin, Spin] = (0.0, 0.0, 0.0)
    """Angular velocity at the start about the axes of space, if free."""

    def build(self) -> tuple[super_ellipsoid.SuperEllipsoid, RigidBody, RigidState]:
        radii = np.array([self.radii] * 3 if isinstance(self.radii, float) else self.radii)
        shape = super_ellipsoid.SuperEllipsoid(radii, self.degree)
        rigid = RigidBody(self.mass, shape.inertia(self.mass), self.locked)
        pose = above_bag(radii[2], self.clearance, np.array(self.offset), float(np.radians(self.angle_about_x)))
        return shape, rigid, moving(rigid, pose, np.array(self.velocity), np.array(self.spin))
