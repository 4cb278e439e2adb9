"""What the tables of all shapes of obstacles share."""

from __future__ import annotations

from abc import abstractmethod

from billow.case.quantity import Strict, quantity
from billow.geometry.shapes.shape import Shape
from billow.parts.bodies.rigid_body import RigidBody, RigidState


class ObstacleTable(Strict):
    """Something rigid that fabric can touch."""

    slope: quantity("N/m", 1.0, 1e9) = 1e5
    """Contact characteristic: force per penetration of 1 cm^2 of fabric."""
    friction: quantity("-", 0.0, 2.0) = 0.2
    """Coulomb friction coefficient."""
    damping: quantity("-", 0.0, 1.0) = 0.1
    """Contact damping, fraction of critical."""

    @abstractmethod
    def build(self) -> tuple[Shape, RigidBody, RigidState]:
        """Shape, mass properties and motion at the start."""
