"""Fabric nodes against obstacles: shape, momentum, action and reaction."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.geometry.shapes.box import Box
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.pose import of_plane, quaternion_about, rotation_matrix
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid, _power_after, closest_point
from billow.parts.bodies.contact import (
    ContactState,
    Nodes,
    ShapeMotion,
    ShapeTable,
    SurfaceLaw,
    kick_touch_drift,
)
from billow.parts.bodies.penalty import A_REFERENCE

NODES = 200
points = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)).filter(lambda p: np.dot(p, p) > 1e-3)
radii = st.tuples(*[st.floats(0.05, 0.5)] * 3).filter(lambda r: max(r) < 4.0 * min(r))


def radial_measure(x, y, z, a, b, c, degree):
    """Below 1 inside, 1 on the surface, homogeneous of degree one."""
    return (abs(x / a) ** degree + abs(y / b) ** degree + abs(z / c) ** degree) ** (1.0 / degree)


@given(point=points, radius=st.floats(0.05, 0.5))
def test_degree_two_with_equal_radii_is_a_ball(point, radius):
    p = np.array(point)
    answer = closest_point(*p, radius, radius, radius, 2.0)
    outward = p / np.linalg.norm(p)
    assert np.array(answer[:3]) == pytest.approx(radius * outward, abs=1e-9)
    assert np.array(answer[3:]) == pytest.approx(outward, abs=1e-8)


@given(point=points, radii=radii, degree=st.floats(2.0, 10.0), height=st.floats(1e-6, 1.0))
def test_from_outside_the_way_to_the_closest_point_is_along_its_normal(point, radii, degree, height):
    direction = np.array(point)
    p = direction / radial_measure(*direction, *radii, degree) * (1.0 + height)
    answer = closest_point(*p, *radii, degree)
    q, n = np.array(answer[:3]), np.array(answer[3:])
    assert radial_measure(*q, *radii, degree) == pytest.approx(1.0, abs=1e-9)
    assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-12)
    gap = p - q
    assert gap @ n > 0.0  # the depth is negative outside
    assert np.linalg.norm(gap - (gap @ n) * n) <= 2e-7 * max(radii)


@given(point=points, radii=radii, degree=st.floats(2.0, 4.5), depth=st.floats(1e-6, 0.02))
def test_from_inside_the_depth_is_positive_and_no_more_than_along_any_other_way(point, radii, degree, depth):
    direction = np.array(point)
    on = direction / radial_measure(*direction, *radii, degree)
    p = on * (1.0 - depth)
    answer = closest_point(*p, *radii, degree)
    gap = np.array(answer[:3]) - p
    assert 0.0 < gap @ np.array(answer[3:]) <= np.linalg.norm(on - p) * (1.0 + 1e-9)


def crowd(seed, spread=0.12):
    """Nodes in and around a ball of 0.1 m: positions, velocities, areas, inverse masses (the last ten are fixed)."""
    rng = np.random.default_rng(seed)
    inverse_mass = 1.0 / rng.uniform(1e-5, 1e-4, NODES)
    inverse_mass[-10:] = 0.0
    return (
        rng.uniform(-spread, spread, (NODES, 3)), rng.normal(scale=10.0, size=(NODES, 3)),
        rng.uniform(0.5e-4, 2e-4, NODES), inverse_mass,
    )  # fmt: skip


def push(table, motion, area, inverse_mass, positions, velocities, dt, contact):
    """Contact without a kick before it; positions stay."""
    nodes = Nodes(inverse_mass, np.zeros_like(positions), positions.copy(), velocities, np.empty_like(positions))
    reaction = kick_touch_drift(table, motion, area, nodes, dt, contact)
    np.testing.assert_array_equal(nodes.before, positions)
    np.testing.assert_array_equal(nodes.positions, positions + dt * velocities)
    return reaction


def press(shape, law, area, inverse_mass, body, positions, velocities, dt, contact=None):
    """One step of contact with one obstacle. body: centre, velocity, spin, rotation. Returns contact, force, torque."""
    contact = contact or ContactState.none(1, len(positions))
    motion = ShapeMotion.room(1)
    motion.body[0], motion.pose[0] = np.concatenate(body[:3]), body[3].ravel()
    reaction = push(ShapeTable.build([shape], [law]), motion, area, inverse_mass, positions, velocities, dt, contact)
    return contact, reaction[0, :3], reaction[0, 3:]


STILL = (np.zeros(3), np.zeros(3), np.zeros(3), np.eye(3))
SHAPES = [HalfSpace(), SuperEllipsoid(np.array([0.1, 0.08, 0.09]), 3.0), Box(np.array([0.1, 0.07, 0.09]), 0.02)]
ROTATION = rotation_matrix(quaternion_about(np.array([0.6, 0.8, 0.0]), 0.7))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_what_the_nodes_get_the_body_loses(shape):
    for seed in range(5):
        positions, velocities, area, inverse_mass = crowd(seed)
        before, centre, dt = velocities.copy(), np.array([0.01, -0.02, 0.005]), 2e-6
        body = (centre, np.array([1.0, 2.0, -3.0]), np.array([3.0, -2.0, 5.0]), ROTATION)
        law = SurfaceLaw(1e5, 0.3, 0.1)
        contact, force, torque = press(shape, law, area, inverse_mass, body, positions, velocities, dt)
        pushed = contact.force[0]
        assert np.count_nonzero(pushed.any(axis=1)) > 40
        scale = np.abs(pushed).sum()
        assert np.abs(pushed.sum(axis=0) + force).max() <= 1e-13 * scale
        moment = np.cross(positions - centre, pushed).sum(axis=0)
        assert np.abs(moment + torque).max() <= 1e-13 * scale
        assert velocities - before == pytest.approx(0.5 * dt * inverse_mass[:, None] * pushed, abs=1e-12)
        assert contact.dissipated[0] >= 0.0
        assert contact.stored[0] >= 0.0


def test_force_follows_from_depth_slope_and_area():
    """At rest, an undamped node at depth d is pushed outwards with slope d A / A_ref, up to the step's own motion."""
    shape, law = SuperEllipsoid(np.array([0.1, 0.1, 0.1]), 2.0), SurfaceLaw(1e5, 0.2, 0.0)
    way = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, -1.0]])
    depth = np.array([1e-3, 2e-3, 0.0, -1e-3])
    area = np.array([1e-4, 3e-4, 1e-4, 1e-4])
    contact, _, _ = press(
        shape, law, area, np.full(4, 1e4), STILL, way * (0.1 - depth)[:, None], np.zeros((4, 3)), 1e-9
    )
    expected = (1e5 * area / A_REFERENCE * np.maximum(depth, 0.0))[:, None] * way
    assert contact.force[0] == pytest.approx(expected, abs=1e-6)
    assert contact.deepest[0] == pytest.approx(2e-3, rel=1e-6)
    assert contact.stored[0] == pytest.approx(0.5 * 1e5 * (1e-6 + 3.0 * 4e-6), rel=1e-6)


def test_a_node_goes_the_same_way_whoever_is_in_its_block():
    """Blocks of nodes that nothing is close to, blocks of which some nodes are, and nodes one by one."""
    positions, velocities, area, inverse_mass = crowd(3)
    positions[70:] += 5.0
    table = ShapeTable.build([SHAPES[1]], [SurfaceLaw(1e5, 0.3, 0.1)])
    motion, dt, force = ShapeMotion.room(1), 2e-6, np.random.default_rng(4).normal(size=(NODES, 3))
    motion.pose[0] = np.eye(3).ravel()

    def step(which):
        nodes = Nodes(inverse_mass[which], force[which], positions[which], velocities[which], positions[which])
        kick_touch_drift(table, motion, area[which], nodes, dt, ContactState.none(1, len(which)))
        np.testing.assert_array_equal(nodes.before, positions[which])
        return nodes.positions, nodes.velocities

    moved, kicked = step(np.arange(NODES))
    for node in range(NODES):
        alone = step(np.array([node]))
        np.testing.assert_array_equal((moved[node], kicked[node]), (alone[0][0], alone[1][0]))
    far = slice(70, None)
    expected = velocities[far] + (0.5 * dt * inverse_mass[far])[:, None] * force[far]
    np.testing.assert_array_equal(kicked[far], expected)
    np.testing.assert_array_equal(moved[far], positions[far] + dt * expected)


def test_nodes_without_fabric_are_not_touched():
    positions, velocities, area, inverse_mass = crowd(1)
    area[::2] = 0.0
    for shape in SHAPES:
        contact = ContactState.none(1, NODES)
        for arrays in (contact.force, contact.offset):
            arrays[:] = 1.0  # of a touch before
        contact.touching[:] = True
        press(shape, SurfaceLaw(1e5, 0.3, 0.1), area, inverse_mass, STILL, positions, velocities, 1e-6, contact)
        assert not contact.force[0, ::2].any()
        assert not contact.offset[0, ::2].any()
        assert contact.force[0, 1::2].any()


def test_a_node_pinched_between_two_obstacles_settles_with_both():
    """Both push as if each knew of the other: momentum and energy close, and neither is let through."""
    table, motion = ShapeTable.build([HalfSpace()] * 2, [SurfaceLaw(1e5, 0.2, 0.0)] * 2), ShapeMotion.room(2)
    motion.pose[0], motion.pose[1] = np.eye(3).ravel(), of_plane(0.0, np.array([0.0, 0.28, -0.96])).rotation.ravel()
    motion.body[1, 2], motion.body[1, 5] = 3e-4, -5.0  # the upper plate comes down, 0.3 mm over the lower one
    positions, velocities = np.array([[0.0, 0.0, 1e-4]]), np.array([[0.0, 0.0, -2.0]])
    contact, mass, area = ContactState.none(2, 1), 2e-5, np.array([1e-4])
    both = 0
    for _ in range(100):
        dt, before = 1e-6, velocities.copy()
        stored = contact.stored.sum()
        reaction = push(table, motion, area, np.array([1.0 / mass]), positions, velocities, dt, contact)
        pushed = contact.force[:, 0]
        assert reaction[:, :3] == pytest.approx(-pushed, abs=1e-12)
        middle = before[0] + 0.5 * dt / mass * pushed.sum(axis=0)
        assert velocities[0] == pytest.approx(middle, abs=1e-9)
        after = before[0] + dt / mass * pushed.sum(axis=0)
        gained = 0.5 * mass * (after @ after - before[0] @ before[0]) + contact.stored.sum() - stored
        driven = dt * pushed[1] @ motion.body[1, 3:6]  # by the moving plate
        assert gained + contact.dissipated.sum() == pytest.approx(driven, abs=1e-9 * mass)
        positions += dt * velocities
        velocities[0] = after
        motion.body[1, :3] += dt * motion.body[1, 3:6]
        both += pushed.any(axis=1).all()
    assert both > 30


@given(q=st.floats(1e-6, 0.5), share=st.floats(-0.02, 0.02), radius=st.floats(0.05, 0.5), exponent=st.floats(0.0, 8.0))
def test_a_power_follows_from_the_one_before_to_rounding(q, share, radius, exponent):
    found = _power_after((q / radius) ** exponent, q, share * q, radius, exponent)
    assert found == pytest.approx(((q + share * q) / radius) ** exponent, rel=4e-15, abs=0.0)


@given(seed=st.integers(0, 1000), dt=st.sampled_from([1e-7, 1e-5, 1e-3]))
def test_a_fast_node_is_found_before_it_is_inside(seed, dt):
    """No node of a crowd outside can be pushed past the surface unnoticed: who arrives within the step is slowed."""
    rng = np.random.default_rng(seed)
    radii = np.array([0.1, 0.08, 0.09])
    way = rng.normal(size=(NODES, 3))
    measure = np.array([radial_measure(*w, *radii, 3.0) for w in way])
    positions = way / measure[:, None] * rng.uniform(1.0 + 1e-9, 1.2, NODES)[:, None]
    velocities = -way * rng.uniform(0.0, 300.0, NODES)[:, None]
    start = velocities.copy()
    contact, _, _ = press(
        SuperEllipsoid(radii, 3.0), SurfaceLaw(1e5, 0.0, 0.0), np.full(NODES, 1e-4), np.full(NODES, 1e4), STILL,
        positions, velocities, dt,
    )  # fmt: skip
    for i in range(NODES):
        answer = np.array(closest_point(*positions[i], *radii, 3.0))
        arrives = (answer[:3] - positions[i] - dt * start[i]) @ answer[3:] > 1e-12
        assert arrives == contact.force[0, i].any()
