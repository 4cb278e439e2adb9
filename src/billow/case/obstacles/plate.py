"""The `[[obstacles]]` table of a plate."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import field_validator

from billow.case.obstacles.table import ObstacleTable
from billow.case.quantity import quantity, refused
from billow.case.text import Name
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.pose import of_plane
from billow.parts.bodies.rigid_body import RigidBody, RigidState

Component = quantity("-", -1e3, 1e3)


class Plate(ObstacleTable):
    """Rigid plate at rest: everything below a plane."""

    shape: Literal["plate"]
    """plate"""
    name: Name = "plate"
    """Name in results."""
    height: quantity("m", -10.0, 10.0) = 0.0
    """Height at which its surface crosses the z axis."""
    normal: tuple[Component, Component, Component] = (0.0, 0.0, 1.0)
    """Direction its surface faces, of any length."""

    @field_validator("normal")
    @classmethod
    def _points_somewhere(cls, value):
        if not any(value):
            raise refused("it has no direction", "write [0, 0, 1]")
        return value

    def build(self) -> tuple[HalfSpace, RigidBody, RigidState]:
        normal = np.array(self.normal)
        pose = of_plane(self.height, normal / np.linalg.norm(normal))
        return HalfSpace(), RigidBody(1.0, np.ones(3), locked=True), RigidState(pose.centre, pose.quaternion)
