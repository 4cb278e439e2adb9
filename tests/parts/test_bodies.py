"""Bodies: several shapes, tilted planes, spin at the start; contact knows nothing but shapes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.case.obstacles.obstacles import Plate, build_body
from billow.case.obstacles.obstacles import SuperEllipsoid as ImpactorTable
from billow.geometry.shapes.box import Box
from billow.geometry.shapes.cylinder import Cylinder
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.kinds import SHAPES, from_description
from billow.geometry.shapes.mesh import Mesh
from billow.geometry.shapes.pose import Pose, of_plane, quaternion_about
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid
from billow.geometry.shapes.triangulated import sphere
from billow.parts.bodies import rigid_body
from billow.parts.bodies.bodies import Bodies
from billow.parts.bodies.body import Body, Carried
from billow.parts.bodies.contact import Nodes, SurfaceLaw
from billow.parts.bodies.rigid_body import RigidBody, RigidState, moving

LAW = SurfaceLaw(1e5, 0.3, 0.1)
BALL = SuperEllipsoid(np.full(3, 0.05), 2.0)
NODES = 60
directions = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda d: np.dot(d, d) > 0.1)


def pushed(bodies, seed=0):
    """One step of contact of random nodes with some bodies: their state, and the velocities of the nodes after it."""
    rng = np.random.default_rng(seed)
    part = Bodies(tuple(bodies), np.full(NODES, 1e-4), np.zeros(3))
    state, velocities = part.start(), rng.normal(scale=5.0, size=(NODES, 3))
    positions = rng.uniform(-0.12, 0.12, (NODES, 3))
    still = np.zeros((NODES, 3))
    part.kick_touch_drift(state, Nodes(np.full(NODES, 1e4), still, positions, velocities, still.copy()), 1e-6)
    return state, velocities


def test_two_shapes_on_one_body_push_as_two_bodies_do_and_the_body_gets_both_forces():
    places = np.array([[0.06, 0.01, 0.0], [-0.05, 0.0, 0.02]])
    rigid, start = RigidBody(2.0, np.full(3, 1e-3), locked=False), RigidState(np.zeros(3))
    carrying = Body("pair", tuple(Carried(BALL, place) for place in places), LAW, rigid, start)
    apart = [Body.of(f"ball {k}", BALL, LAW, rigid, RigidState(place)) for k, place in enumerate(places)]
    one, velocities = pushed([carrying])
    two, same = pushed(apart)
    assert one.contact.touching.any(axis=1).all()
    np.testing.assert_allclose(velocities, same, atol=1e-12)
    np.testing.assert_allclose(one.contact.force, two.contact.force, atol=1e-9)
    forces = [motion.force for motion in two.motion]
    np.testing.assert_allclose(one.motion[0].force, sum(forces), atol=1e-9)
    turned = sum(m.torque + np.cross(place, m.force) for m, place in zip(two.motion, places, strict=True))
    np.testing.assert_allclose(one.motion[0].torque, turned, atol=1e-9)


def test_a_shape_turned_on_its_body_is_the_body_turned():
    shape, turn = SuperEllipsoid(np.array([0.1, 0.05, 0.07]), 3.0), quaternion_about(np.array([0.6, 0.0, 0.8]), 0.9)
    rigid = RigidBody(2.0, np.full(3, 1e-3), locked=True)
    rotation = Pose(np.zeros(3), turn).rotation
    on_body = Body("a", (Carried(shape, rotation=rotation),), LAW, rigid, RigidState(np.zeros(3)))
    whole = Body.of("b", shape, LAW, rigid, RigidState(np.zeros(3), turn))
    (one, first), (two, second) = pushed([on_body]), pushed([whole])
    assert one.contact.force.any()
    np.testing.assert_allclose(first, second, atol=1e-12)
    np.testing.assert_allclose(one.motion[0].force, two.motion[0].force, atol=1e-9)


@given(normal=directions, height=st.floats(-1.0, 1.0))
def test_a_tilted_plate_passes_through_its_height_and_faces_its_normal(normal, height):
    unit = np.array(normal) / np.linalg.norm(normal)
    pose = of_plane(height, unit)
    np.testing.assert_allclose(pose.rotation[:, 2], unit, atol=1e-12)
    np.testing.assert_allclose(pose.rotation @ pose.rotation.T, np.eye(3), atol=1e-12)
    plate = build_body(Plate(shape="plate", height=height, normal=tuple(unit)))
    above, below = np.array([0.0, 0.0, height]) + 0.1 * unit, np.array([0.0, 0.0, height]) - 0.2 * unit
    assert plate.distance(np.array([above, below]))[0] == pytest.approx([0.1, -0.2], abs=1e-12)


def test_a_body_starts_with_the_spin_the_case_gives_it():
    table = ImpactorTable(
        shape="super-ellipsoid", radii=(0.1, 0.15, 0.2), angle_about_x=40.0, locked=False, spin=(3.0, -2.0, 1.0)
    )
    body = build_body(table)
    assert rigid_body.spin(body.rigid, body.start) == pytest.approx([3.0, -2.0, 1.0], rel=1e-12)
    locked = build_body(table.model_copy(update={"locked": True}))
    assert not locked.start.angular_momentum.any()


def test_energy_of_a_spinning_body_is_that_of_its_inertia():
    rigid = RigidBody(2.0, np.array([1e-3, 2e-3, 3e-3]), locked=False)
    pose = Pose(np.zeros(3), quaternion_about(np.array([0.0, 1.0, 0.0]), 1.1))
    state = moving(rigid, pose, np.array([1.0, 2.0, 2.0]), pose.rotation @ np.array([10.0, 20.0, 30.0]))
    expected = 0.5 * 2.0 * 9.0 + 0.5 * (1e-3 * 100.0 + 2e-3 * 400.0 + 3e-3 * 900.0)
    assert rigid_body.kinetic_energy(rigid, state) == pytest.approx(expected, rel=1e-12)


EACH_SHAPE = [
    HalfSpace(),
    SuperEllipsoid(np.array([0.1, 0.08, 0.09]), 3.0),
    Box(np.array([0.1, 0.06, 0.08]), 0.01),
    Mesh(*sphere(1)),
    Cylinder(0.1, 0.06, 0.01),
]


@pytest.mark.parametrize("shape", EACH_SHAPE, ids=lambda s: s.kind)
def test_every_shape_answers_alike(shape):
    """Distance, level and description agree with each other; every kind of shape has an entry here."""
    points = np.random.default_rng(3).uniform(-0.3, 0.3, (200, 3))
    distance, normal = shape.distance(points)
    assert ((distance < 0.0) == (shape.level(points) < 0.0)).all()
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-9)
    again = from_description(shape.describe())
    np.testing.assert_array_equal(again.distance(points)[0], distance)
    assert again.numbers.tolist() == shape.numbers.tolist()
    assert {type(each) for each in EACH_SHAPE} == set(SHAPES)
