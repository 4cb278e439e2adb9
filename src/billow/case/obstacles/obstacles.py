"""The tables of obstacles that a case chooses among with `shape`; a new one is a class and an entry of OBSTACLES."""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

import numpy as np
from pydantic import field_validator, model_validator

from billow.case.obstacles.motion import AtRest, Component, Motion, points_somewhere, unit_vector
from billow.case.quantity import Name, Strict, chosen_by, quantity, refused
from billow.geometry.shapes import super_ellipsoid as shapes
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.pose import above_bag, of_plane
from billow.geometry.shapes.shape import Shape
from billow.parts.bodies.body import Body
from billow.parts.bodies.contact import SurfaceLaw
from billow.parts.bodies.drive import Guided
from billow.parts.bodies.rigid_body import RigidBody, RigidState, moving

Radius = quantity("m", 5e-3, 5.0)
Speed = quantity("m/s", -100.0, 100.0)
Spin = quantity("rad/s", -1e3, 1e3)


class ObstacleTable(Strict):
    """Something rigid that fabric can touch."""

    slope: quantity("N/m", 1.0, 1e9) = 1e5
    """Contact characteristic: force per penetration of 1 cm^2 of fabric."""
    friction: quantity("-", 0.0, 2.0) = 0.2
    """Coulomb friction coefficient."""
    damping: quantity("-", 0.0, 1.0) = 0.1
    """Contact damping, fraction of critical."""
    motion: Motion = AtRest()

    @abstractmethod
    def build(self) -> tuple[Shape, RigidBody, RigidState]:
        """Shape, mass properties and motion at the start."""


class Plate(ObstacleTable):
    """Rigid plate: everything below a plane."""

    shape: Literal["plate"]
    """plate"""
    name: Name = "plate"
    """Name in results."""
    height: quantity("m", -10.0, 10.0) = 0.0
    """Height at which its surface crosses the z axis."""
    normal: tuple[Component, Component, Component] = (0.0, 0.0, 1.0)
    """Direction its surface faces; its length does not count."""

    _points_somewhere = field_validator("normal")(points_somewhere)

    def build(self) -> tuple[HalfSpace, RigidBody, RigidState]:
        pose = of_plane(self.height, unit_vector(self.normal))
        return HalfSpace(), RigidBody(1.0, np.ones(3), locked=True), RigidState(pose.centre, pose.quaternion)


class SuperEllipsoid(ObstacleTable):
    """Rigid super-ellipsoid |x/a|^n + |y/b|^n + |z/c|^n = 1 above the bag: locked, free or moved."""

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

    @model_validator(mode="after")
    def _one_or_the_other(self):
        if not self.locked and self.motion.kind != "none":
            reason = f"it is free to move, and motion.kind is {self.motion.kind!r} beside that"
            raise refused(reason, 'remove locked = false, or motion; motion.kind = "guided" has a mass and yields')
        return self

    def build(self) -> tuple[shapes.SuperEllipsoid, RigidBody, RigidState]:
        radii = np.array([self.radii] * 3 if isinstance(self.radii, float) else self.radii)
        shape = shapes.SuperEllipsoid(radii, self.degree)
        rigid = RigidBody(self.mass, shape.inertia(self.mass), self.locked)
        pose = above_bag(radii[2], self.clearance, np.array(self.offset), float(np.radians(self.angle_about_x)))
        return shape, rigid, moving(rigid, pose, np.array(self.velocity), np.array(self.spin))


OBSTACLES: dict[str, type[ObstacleTable]] = {"plate": Plate, "super-ellipsoid": SuperEllipsoid}
"""Table of each shape."""

Obstacle = chosen_by("shape", OBSTACLES)


def build_body(obstacle: ObstacleTable) -> Body:
    """The body of an `[[obstacles]]` table."""
    shape, rigid, start = obstacle.build()
    law, drive = SurfaceLaw(obstacle.slope, obstacle.friction, obstacle.damping), obstacle.motion.build()
    if isinstance(drive, Guided):
        start.velocity = drive.speed * drive.direction
    return Body.of(obstacle.name, shape, law, rigid, start, drive)
