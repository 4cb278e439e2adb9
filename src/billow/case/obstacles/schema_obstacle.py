"""The `[[obstacles]]` tables: rigid plates and super-ellipsoids."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from billow.case.quantity import Strict, quantity, refused
from billow.case.text import Name

Fraction = quantity("-", 0.0, 1.0)
Radius = quantity("m", 5e-3, 5.0)
Speed = quantity("m/s", -100.0, 100.0)


class Plate(Strict):
    """Rigid plate at rest: everything below z = height."""

    shape: Literal["plate"]
    """plate"""
    name: Name = "plate"
    """Name in results."""
    height: quantity("m", -10.0, 10.0) = 0.0
    """Height of its surface."""
    slope: quantity("N/m", 1.0, 1e9) = 1e5
    """Force per penetration of 1 cm^2 of fabric."""
    friction: quantity("-", 0.0, 2.0) = 0.2
    """Coulomb friction coefficient."""
    damping: Fraction = 0.1
    """Contact damping, fraction of critical."""


class SuperEllipsoid(Strict):
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
    slope: quantity("N/m", 1.0, 1e9) = 1e5
    """Contact characteristic: force per penetration of 1 cm^2 of fabric."""
    friction: quantity("-", 0.0, 2.0) = 0.2
    """Coulomb friction coefficient."""
    damping: Fraction = 0.1
    """Contact damping, fraction of critical."""


def _known_shape(value: Any) -> Any:
    shapes = ("plate", "super-ellipsoid")
    if isinstance(value, dict) and value.get("shape") not in shapes:
        given = value.get("shape")
        reason = f"there is no shape {given[:40]!r}" if isinstance(given, str) else "it has no shape"
        remedy = f"write {' or '.join(f'shape = {shape!r}' for shape in shapes)}"
        raise refused(reason, remedy)
    return value


Obstacle = Annotated[Plate | SuperEllipsoid, Field(discriminator="shape"), BeforeValidator(_known_shape)]
