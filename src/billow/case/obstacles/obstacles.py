"""The tables of obstacles that a case chooses among with `shape`; a new one is a class and an entry of OBSTACLES."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, field_validator, model_validator

from billow.case.obstacles.motion import AtRest, Component, Motion, points_somewhere, unit_vector
from billow.case.obstacles.surface_file import read_surface, solid_of
from billow.case.quantity import Name, Strict, Text, chosen_by, quantity, refused, unit_of_length
from billow.geometry.shapes import super_ellipsoid as shapes
from billow.geometry.shapes.box import Box
from billow.geometry.shapes.cylinder import Cylinder
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.pose import Pose, above_bag, of_plane, quaternion_of
from billow.parts.bodies.body import Body, Carried
from billow.parts.bodies.contact import SurfaceLaw
from billow.parts.bodies.drive import Guided
from billow.parts.bodies.rigid_body import RigidBody, RigidState, moving

Radius = quantity("m", 5e-3, 5.0)
Speed = quantity("m/s", -100.0, 100.0)
Spin = quantity("rad/s", -1e3, 1e3)
Coordinate = quantity("m", -10.0, 10.0)
Side = quantity("m", 1e-3, 10.0)
Moment = quantity("kg m^2", -1e4, 1e4)
FIXED = RigidBody(1.0, np.ones(3), locked=True)
"""What neither turns nor yields to forces."""


Parts = tuple[tuple[Carried, ...], RigidBody, RigidState]


def require_thick(edge: float, least: float) -> None:
    """Refuses edges of a radius [m] for which the least thickness [m] has no room."""
    if edge > 0.5 * least:
        raise refused(
            f"its edges have a radius of {edge:g} m, and its least thickness is {least:g} m",
            "make edge at most half of the thickness",
        )


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
    def build(self) -> Parts:
        """Shapes with their places, mass properties and motion at the start."""


class Plate(ObstacleTable):
    """Rigid plate: everything below a plane."""

    shape: Literal["plate"]
    """plate"""
    name: Name = "plate"
    """Name in results."""
    height: Coordinate = 0.0
    """Height at which its surface crosses the z axis, or the vertical through `offset`."""
    offset: tuple[Coordinate, Coordinate] = (0.0, 0.0)
    """Where it has that height (x, y); for planes that are steep."""
    normal: tuple[Component, Component, Component] = (0.0, 0.0, 1.0)
    """Direction its surface faces; its length does not count."""

    _points_somewhere = field_validator("normal")(points_somewhere)

    def build(self) -> Parts:
        pose = of_plane(self.height, unit_vector(self.normal), self.offset)
        return (Carried(HalfSpace()),), FIXED, RigidState(pose.centre, pose.quaternion)


class Movable(ObstacleTable):
    """What may also be free to move with six degrees of freedom."""

    locked: bool = True
    """Locked in place, or free to move with six degrees of freedom."""
    mass: quantity("kg", 1e-3, 1000.0) = 4.5
    """Mass; inertia is that of uniform density."""
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


class SuperEllipsoid(Movable):
    """Rigid super-ellipsoid |x/a|^n + |y/b|^n + |z/c|^n = 1 above the bag: locked, free or moved."""

    shape: Literal["super-ellipsoid"]
    """super-ellipsoid"""
    name: Name = "impactor"
    """Name in results."""
    radii: Radius | tuple[Radius, Radius, Radius] = 0.15
    """Radii a, b, c along its own axes; one number for all three."""
    degree: quantity("-", 2.0, 10.0) = 2.0
    """Degree n: 2 is an ellipsoid, larger is boxier."""
    clearance: quantity("m", -5.0, 5.0) = 0.15
    """Height of its centre minus its third radius above the plane z = 0: the gap to the flat bag."""
    offset: tuple[quantity("m", -5.0, 5.0), quantity("m", -5.0, 5.0)] = (0.0, 0.0)
    """Position of its centre across the bag's axis (x, y)."""
    angle_about_x: quantity("deg", -180.0, 180.0) = 0.0
    """Orientation: rotation about the x axis."""

    def build(self) -> Parts:
        radii = np.array([self.radii] * 3 if isinstance(self.radii, float) else self.radii)
        shape = shapes.SuperEllipsoid(radii, self.degree)
        rigid = RigidBody(self.mass, shape.inertia(self.mass), self.locked)
        pose = above_bag(radii[2], self.clearance, np.array(self.offset), float(np.radians(self.angle_about_x)))
        return (Carried(shape),), rigid, moving(rigid, pose, np.array(self.velocity), np.array(self.spin))


class MeshTable(Movable):
    """Rigid surface of triangles and quads, read from a file (VTKHDF, VTK, STL, OBJ or PLY). If it is closed it is a
    solid; otherwise a sheet, whose both sides can be touched. Free bodies meet it as the super-ellipsoid of its extents
    and volume."""

    shape: Literal["mesh"]
    """mesh"""
    name: Name = "body"
    """Name in results."""
    file: Text
    """File of its surface. Relative to the case file."""
    unit: Annotated[str, AfterValidator(unit_of_length)] = "m"
    """Unit of length in the file."""
    digest: Text = ""
    """SHA-256 of the file, filled in when a case file is read."""
    thickness: quantity("m", 1e-3, 0.5) = 0.005
    """Thickness of an open surface, half of it on either side."""
    place: tuple[Coordinate, Coordinate, Coordinate] = (0.0, 0.0, 0.0)
    """Where the origin of the file lies (x, y, z)."""
    normal: tuple[Component, Component, Component] = (0.0, 0.0, 1.0)
    """Direction to which the z axis of the file is tilted; its length does not count."""
    turn: quantity("deg", -180.0, 180.0) = 0.0
    """Rotation about the z axis of the file, before it is tilted."""
    density: quantity("kg/m^3", 0.0, 20000.0) = 0.0
    """If it is not 0, the mass follows from it, and from the volume of the solid or of the sheet."""
    centre: tuple[Coordinate, Coordinate, Coordinate] | Literal["own"] = "own"
    """Centre of mass in the axes and metres of the file; own: that of uniform density."""
    inertia: tuple[Moment, Moment, Moment, Moment, Moment, Moment] | Literal["own"] = "own"
    """Moments xx, yy, zz and entries xy, yz, zx of the inertia tensor about the centre of mass, in the axes of the
    file; own: that of uniform density."""

    _points_somewhere = field_validator("normal")(points_somewhere)

    def build(self) -> Parts:
        points, triangles, is_closed = read_surface(self.file, self.name, self.unit, self.digest)
        centre = None if self.centre == "own" else np.array(self.centre)
        inertia = None if self.inertia == "own" else self.inertia
        thickness = 0.0 if is_closed else self.thickness
        solid = solid_of(points, triangles, thickness, self.name, self.mass, self.density, centre, inertia)
        rigid = RigidBody(solid.mass, solid.inertia, self.locked)
        file = of_plane(self.place[2], unit_vector(self.normal), self.place[:2], float(np.radians(self.turn)))
        pose = Pose(file.centre + file.rotation @ solid.centre, quaternion_of(file.rotation @ solid.axes))
        start = moving(rigid, pose, np.array(self.velocity), np.array(self.spin))
        return (Carried(solid.mesh, solid.middle),), rigid, start


class CylinderTable(Movable):
    """Rigid cylinder with rounded edges: locked, free or moved."""

    shape: Literal["cylinder"]
    """cylinder"""
    name: Name = "cylinder"
    """Name in results."""
    radius: Radius = 0.05
    """Its radius."""
    length: Side = 0.4
    """Its length."""
    place: tuple[Coordinate, Coordinate, Coordinate] = (0.0, 0.0, 0.0)
    """Where its middle lies (x, y, z)."""
    normal: tuple[Component, Component, Component] = (0.0, 0.0, 1.0)
    """Direction of its axis; its length does not count."""
    edge: quantity("m", 1e-4, 1.0) = 0.002
    """Radius of its edges, at most its radius and half its length."""

    _points_somewhere = field_validator("normal")(points_somewhere)

    @model_validator(mode="after")
    def _has_room_for_edges(self):
        require_thick(self.edge, 2.0 * min(self.radius, 0.5 * self.length))
        return self

    def build(self) -> Parts:
        shape = Cylinder(self.radius, 0.5 * self.length, self.edge)
        rigid = RigidBody(self.mass, shape.inertia(self.mass), self.locked)
        pose = of_plane(self.place[2], unit_vector(self.normal), self.place[:2])
        return (Carried(shape),), rigid, moving(rigid, pose, np.array(self.velocity), np.array(self.spin))


class Placed(ObstacleTable):
    """What is made of boxes: where it stands and how it is turned."""

    place: tuple[Coordinate, Coordinate, Coordinate] = (0.0, 0.0, 0.0)
    """Where the middle of its base lies (x, y, z)."""
    normal: tuple[Component, Component, Component] = (0.0, 0.0, 1.0)
    """Direction from its base to its top; its length does not count."""
    turn: quantity("deg", -180.0, 180.0) = 0.0
    """Rotation about `normal`, before it is tilted from the z axis to it."""
    edge: quantity("m", 1e-4, 1.0) = 0.002
    """Radius of its edges, at most half its least thickness."""

    _points_somewhere = field_validator("normal")(points_somewhere)

    def _stand(self, boxes: list[tuple[np.ndarray, np.ndarray]]) -> Parts:
        """Boxes of (low, high) corners [m], from the middle of the base."""
        pose = of_plane(self.place[2], unit_vector(self.normal), self.place[:2], float(np.radians(self.turn)))
        carried = tuple(Carried(Box(0.5 * (high - low), self.edge), 0.5 * (high + low)) for low, high in boxes)
        return carried, FIXED, RigidState(pose.centre, pose.quaternion)


class BoxTable(Placed):
    """Rigid box: a plate with an end, a flap, a table."""

    shape: Literal["box"]
    """box"""
    name: Name = "box"
    """Name in results."""
    size: tuple[Side, Side, Side]
    """Lengths along its own axes; the third along `normal`."""

    @model_validator(mode="after")
    def _has_room_for_edges(self):
        require_thick(self.edge, min(self.size))
        return self

    def build(self) -> Parts:
        a, b, c = self.size
        return self._stand([(np.array([-0.5 * a, -0.5 * b, 0.0]), np.array([0.5 * a, 0.5 * b, c]))])


class Housing(Placed):
    """Rigid housing: four walls around a rectangle, with or without a floor, without a lid. Without a floor it is a
    plate with a rectangular hole, as wide as its walls are thick."""

    shape: Literal["housing"]
    """housing"""
    name: Name = "housing"
    """Name in results."""
    inner: tuple[Side, Side]
    """Lengths of the rectangle between the walls along its own axes."""
    depth: Side
    """Height of the walls above the base: the upper side of the floor."""
    wall: Side = 0.02
    """Thickness of walls and floor, outwards."""
    floor: bool = True
    """Whether it has a floor."""

    @model_validator(mode="after")
    def _has_room_for_edges(self):
        require_thick(self.edge, min(self.wall, self.depth))
        return self

    def build(self) -> Parts:
        (a, b), t = 0.5 * np.array(self.inner), self.wall
        low = -t if self.floor else 0.0  # walls stand beside the floor, so that no groove lies between their edges
        boxes = [(np.array([-a - t, -b - t, -t]), np.array([a + t, b + t, 0.0]))] if self.floor else []
        for along in (-1.0, 1.0):
            x, y = along * (a + 0.5 * t), along * (b + 0.5 * t)
            boxes.append((np.array([x - 0.5 * t, -b - t, low]), np.array([x + 0.5 * t, b + t, self.depth])))
            boxes.append((np.array([-a - t, y - 0.5 * t, low]), np.array([a + t, y + 0.5 * t, self.depth])))
        return self._stand(boxes)


OBSTACLES: dict[str, type[ObstacleTable]] = {
    "plate": Plate,
    "super-ellipsoid": SuperEllipsoid,
    "box": BoxTable,
    "housing": Housing,
    "cylinder": CylinderTable,
    "mesh": MeshTable,
}
"""Table of each shape."""

Obstacle = chosen_by("shape", OBSTACLES)


def build_body(obstacle: ObstacleTable) -> Body:
    """The body of an `[[obstacles]]` table."""
    carried, rigid, start = obstacle.build()
    law, drive = SurfaceLaw(obstacle.slope, obstacle.friction, obstacle.damping), obstacle.motion.build()
    if isinstance(drive, Guided):
        start.velocity = drive.speed * drive.direction
    return Body(obstacle.name, carried, law, rigid, start, drive)
