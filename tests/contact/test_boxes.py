"""Boxes and housings: exact distance, closed-form volume, and nothing leaves a housing but through its opening."""

from __future__ import annotations

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.build import build_model, require_start_clear
from billow.case.obstacles.obstacles import OBSTACLES, build_body
from billow.case.schema import Case
from billow.geometry.shapes.box import Box, near_box
from billow.geometry.shapes.cylinder import Cylinder, near_cylinder
from billow.parts.bodies.bodies import Bodies
from billow.parts.bodies.contact import Nodes
from billow.results.obstacles import placed

NOT_TURNED = tuple(np.eye(3).ravel())
TURNED = {"place": [0.02, -0.01, 0.03], "normal": [1.0, 2.0, 2.0], "turn": 35.0}


def body_of(**table):
    return build_body(OBSTACLES[table["shape"]].model_validate(table))


def test_kernel_and_arrays_agree_on_distance_and_normal():
    box = Box(np.array([0.1, 0.06, 0.03]), 0.01)
    points = np.random.default_rng(2).uniform(-0.13, 0.13, (500, 3))
    distance, normal = box.distance(points)
    for point, d, n in zip(points, distance, normal, strict=True):
        near, depth, *found = near_box(tuple(box.numbers), NOT_TURNED, *point, 0.1, 0.1, 0.1)
        assert near
        assert depth == pytest.approx(-d, abs=1e-15)
        np.testing.assert_allclose(found, n, atol=1e-12)


def test_volume_is_that_of_a_ball_a_box_and_what_lies_between():
    assert Box(np.full(3, 0.1), 0.1).volume() == pytest.approx(4.0 / 3.0 * np.pi * 1e-3)
    assert Box(np.array([0.1, 0.2, 0.3]), 1e-9).volume() == pytest.approx(8.0 * 0.006)
    box = Box(np.array([0.1, 0.05, 0.08]), 0.03)
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (200_000, 3)) * box.half
    share = float((box.level(points) < 0.0).mean())
    assert box.volume() == pytest.approx(8.0 * np.prod(box.half) * share, rel=3e-3)


def fly(body, positions, velocities, steps, dt=2e-6):
    """Nodes that fly among the shapes of a body without a drag: where they end, and energy at start and end [J]."""
    nodes = len(positions)
    part = Bodies((body,), np.full(nodes, 1e-4), np.zeros(3))
    state, inverse = part.start(), np.full(nodes, 1.0 / 3e-5)
    before = 0.5 * 3e-5 * np.sum(velocities**2)
    for _ in range(steps):
        room = Nodes(inverse, np.zeros_like(positions), positions, velocities, np.empty_like(positions))
        part.kick_touch_drift(state, room, dt)
        velocities += (0.5 * dt * inverse)[:, None] * state.contact.force.sum(axis=0)
    return positions, before, 0.5 * 3e-5 * np.sum(velocities**2) + float(state.contact.stored.sum())


@pytest.mark.parametrize("floor", [True, False], ids=["housing", "frame"])
def test_nodes_leave_a_housing_through_its_opening_only_and_keep_their_energy(floor):
    body = body_of(
        shape="housing", inner=[0.08, 0.05], depth=0.04, floor=floor, friction=0.0, damping=0.0, slope=1e5, **TURNED
    )
    rng = np.random.default_rng(4)
    own = rng.uniform([-0.038, -0.023, 0.002], [0.038, 0.023, 0.038], (300, 3))
    speeds = rng.normal(scale=20.0, size=(300, 3))
    rotation = body.start.rotation
    start = body.start.centre + own @ rotation.T
    errors = []
    for steps, dt in ((2000, 4e-6), (4000, 2e-6)):
        ends, before, after = fly(body, start.copy(), speeds @ rotation.T, steps, dt)
        errors.append(abs(after / before - 1.0))
    assert errors[0] < 5e-3  # around the edges normals turn within a step
    assert errors[1] < 0.6 * errors[0]
    there = (ends - body.start.centre) @ rotation
    inside = (np.abs(there[:, 0]) < 0.0415) & (
        np.abs(there[:, 1]) < 0.0265
    )  # a node goes in by v sqrt(m/k), 1 mm at 60 m/s
    held = (there[:, 2] > -1.5e-3) & (there[:, 2] < 0.04)
    above, under = there[:, 2] >= 0.04, there[:, 2] <= -1.5e-3
    assert (inside[held]).all()  # no one went through a wall
    assert np.count_nonzero(above) > 50
    assert np.count_nonzero(under) == 0 if floor else np.count_nonzero(under) > 50
    straight = own[:, 2] + 4000 * 2e-6 * speeds[:, 2]
    assert np.count_nonzero(straight < 0.0) > 50  # who would be under a floor that is not there


def test_a_box_presses_as_a_plate_does():
    """The flat of a box, and a plate, against the same nodes."""
    rng = np.random.default_rng(3)
    nodes = np.column_stack([rng.uniform(-0.04, 0.04, (40, 2)), rng.uniform(-0.001, 0.0, 40)])
    speeds = rng.normal(scale=1.0, size=(40, 3))
    ends = []
    tables = {"shape": "plate"}, {"shape": "box", "size": [0.2, 0.2, 0.05], "place": [0.0, 0.0, -0.05]}
    for table in tables:
        ends.append(fly(body_of(friction=0.3, **table), nodes.copy(), speeds.copy(), 50)[0])
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)


def test_a_steep_plate_passes_through_its_offset():
    wall = body_of(shape="plate", normal=[1.0, 0.0, 0.0], offset=[0.3, 0.1], height=0.2)
    assert wall.distance(np.array([[0.35, 7.0, 9.0], [0.1, 0.0, 0.0]]))[0] == pytest.approx([0.05, -0.2])


def test_bag_in_a_housing_starts_clear_and_one_that_is_too_wide_is_refused():
    bag = {"shape": "square", "side": 0.2, "element_size": 0.02, "mouth_radius": 0.03}
    housing = {"shape": "housing", "inner": [0.21, 0.21], "depth": 0.05}
    require_start_clear(build_model(Case.from_dict({"bag": bag, "obstacles": [housing]})))
    tight = build_model(Case.from_dict({"bag": bag, "obstacles": [housing | {"inner": [0.19, 0.21]}]}))
    with pytest.raises(InputError, match="penetrates the bag"):
        require_start_clear(tight)


@pytest.mark.parametrize(
    "table",
    [
        {"shape": "box", "size": [0.1, 0.1, 0.003]},
        {"shape": "housing", "inner": [0.1, 0.1], "depth": 0.1, "edge": 0.02},
    ],
)
def test_edges_that_do_not_fit_are_refused(table):
    with pytest.raises(InputError, match="edges have a radius"):
        Case.from_dict({"obstacles": [table]})


def test_walls_of_a_moved_housing_keep_their_places_on_it():
    motion = {"kind": "speed", "speed": 2.0, "direction": [0.0, 0.0, 1.0]}
    body = body_of(shape="housing", inner=[0.1, 0.1], depth=0.05, motion=motion)
    described = body.describe()

    class Histories:
        time = np.array([0.0, 0.01])

        @staticmethod
        def of(name):
            class Curves(dict):
                quaternion = np.tile(body.start.quaternion, (2, 1))
                centre = body.start.centre + np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.02]])

            return Curves(quaternion=1)

    for before, after in zip(described, placed(described, Histories, 0.01), strict=True):
        assert np.subtract(after["center"], before["center"]) == pytest.approx([0.0, 0.0, 0.02])


def test_cylinders_are_as_exact_as_boxes():
    shape, rng = Cylinder(0.05, 0.08, 0.01), np.random.default_rng(7)
    points = rng.uniform(-0.12, 0.12, (500, 3))
    points[0] = 0.0
    distance, normal = shape.distance(points)
    for point, d, n in zip(points, distance, normal, strict=True):
        near, depth, *found = near_cylinder(tuple(shape.numbers), NOT_TURNED, *point, 0.1, 0.1, 0.1)
        assert near
        assert depth == pytest.approx(-d, abs=1e-15)
        np.testing.assert_allclose(found, n, atol=1e-12)
    outside = distance > 0.0  # the closest point lies on the surface
    assert np.abs(shape.distance(points[outside] - distance[outside, None] * normal[outside])[0]).max() < 1e-12
    inner = np.array([[0.03, 0.0, 0.01], [0.0, 0.001, 0.07], [0.06, 0.0, 0.0]])
    np.testing.assert_allclose(shape.distance(inner)[0], [-0.02, -0.01, 0.01], atol=1e-12)
    many = rng.uniform(-1.0, 1.0, (200_000, 3)) * [0.05, 0.05, 0.08]
    assert shape.volume() == pytest.approx(8 * 0.05**2 * 0.08 * float((shape.level(many) < 0.0).mean()), rel=3e-3)
    assert Cylinder(0.1, 0.1, 0.1).volume() == pytest.approx(4.0 / 3.0 * np.pi * 1e-3)


def test_a_cylinder_stands_where_it_is_put_and_meets_what_it_falls_on():
    body = body_of(shape="cylinder", radius=0.05, length=0.2, place=[0.0, 0.0, 0.3], normal=[1, 0, 0], locked=False)
    np.testing.assert_allclose(body.distance(np.array([[0.0, 0.0, 0.2], [0.2, 0.0, 0.3]])), [[0.05, 0.1]], atol=1e-12)
    across = 0.05**2 / 4.0 + 0.2**2 / 12.0
    assert np.sort(body.rigid.inertia) == pytest.approx(4.5 * np.array([0.5 * 0.05**2, across, across]))
    plate, table = body_of(shape="plate", height=0.0), {"radius": 0.05, "length": 0.2, "normal": [1, 0, 0]}
    for height, overlap in ((0.06, -0.01), (0.049, 0.001)):
        lying = body_of(shape="cylinder", place=[0.0, 0.0, height], locked=False, **table)
        meetings = Bodies((lying, plate), np.empty(0), np.zeros(3)).meetings
        ((_, _, found),) = meetings.overlaps([lying.start, plate.start])
        assert found == pytest.approx(overlap, abs=1e-12)
