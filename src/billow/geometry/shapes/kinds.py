"""All kinds of shapes: a new one adds its class to SHAPES and its compiled functions to `near_other_shape` and
`farthest`, in one order. Meshes need arrays, which would be counted at each call: `Mesh.look` finds them before a step,
MESH."""

from __future__ import annotations

from billow.base.compiled import scalar, spliced
from billow.geometry.shapes.box import MEETS_AS, Box, near_box
from billow.geometry.shapes.cylinder import Cylinder, farthest_of_cylinder, near_cylinder
from billow.geometry.shapes.half_space import HalfSpace, near_half_space
from billow.geometry.shapes.mesh import Mesh
from billow.geometry.shapes.shape import Shape
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid, farthest_of_super_ellipsoid, near_super_ellipsoid

SHAPES = (HalfSpace, SuperEllipsoid, Box, Mesh, Cylinder)
HALF_SPACE, SUPER_ELLIPSOID, MESH = (SHAPES.index(cls) for cls in (HalfSpace, SuperEllipsoid, Mesh))


def number_of(shape: Shape) -> int:
    """Number by which `near_shape` knows a shape's kind."""
    return [cls.kind for cls in SHAPES].index(shape.kind)


def from_description(described: dict) -> Shape:
    """The shape that `Shape.describe` described. Raises KeyError if there is no such kind."""
    return {cls.kind: cls for cls in SHAPES}[described["kind"]].from_description(described)


@spliced
def near_shape(number, numbers, pose, rx, ry, rz, tx, ty, tz):
    """Whether and how a point touches a shape of kind `number`, as `Shape` says."""
    if number == HALF_SPACE:
        return near_half_space(numbers, pose, rx, ry, rz, tx, ty, tz)
    if number == SUPER_ELLIPSOID:
        return near_super_ellipsoid(numbers, pose, rx, ry, rz, tx, ty, tz)
    return near_other_shape(number, numbers, pose, rx, ry, rz, tx, ty, tz)


@spliced
def near_other_shape(number, numbers, pose, rx, ry, rz, tx, ty, tz):
    """The same for kinds that have no function for many points at once."""
    if number == 2:
        return near_box(numbers, pose, rx, ry, rz, tx, ty, tz)
    return near_cylinder(numbers, pose, rx, ry, rz, tx, ty, tz)


@scalar
def farthest(number, numbers, dx, dy, dz):
    """The farthest point in a direction of a shape of kind `number` that has an end, as `Shape` says."""
    if number == 4:
        return farthest_of_cylinder(numbers, dx, dy, dz)
    a, b, c, degree, _ = numbers
    return farthest_of_super_ellipsoid((a, b, c, MEETS_AS if number == 2 else degree, 0.0), dx, dy, dz)
