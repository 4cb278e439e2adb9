"""The kinds of obstacles that a case chooses among with `shape`; a new one is an entry of OBSTACLES."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from billow.case.obstacles.plate import Plate
from billow.case.obstacles.super_ellipsoid import SuperEllipsoid
from billow.case.obstacles.table import ObstacleTable
from billow.case.quantity import refused
from billow.parts.bodies.body import Body
from billow.parts.bodies.contact import SurfaceLaw

OBSTACLES: dict[str, type[ObstacleTable]] = {"plate": Plate, "super-ellipsoid": SuperEllipsoid}
"""Table of each shape."""


def _known_shape(value: Any) -> Any:
    if isinstance(value, dict) and value.get("shape") not in tuple(OBSTACLES):
        given = value.get("shape")
        reason = f"there is no shape {given[:40]!r}" if isinstance(given, str) else "it has no shape"
        remedy = f"write {' or '.join(f'shape = {shape!r}' for shape in OBSTACLES)}"
        raise refused(reason, remedy)
    return value


Obstacle = Annotated[reduce(or_, OBSTACLES.values()), Field(discriminator="shape"), BeforeValidator(_known_shape)]


def build_body(obstacle: ObstacleTable) -> Body:
    """The body of an `[[obstacles]]` table."""
    shape, rigid, start = obstacle.build()
    return Body.of(obstacle.name, shape, SurfaceLaw(obstacle.slope, obstacle.friction, obstacle.damping), rigid, start)
