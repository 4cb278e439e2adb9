"""Obstacles that meet: they bounce, slide and rest as rigid bodies do, and never pass through each other unseen."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.base.errors import InputError, NumericalStop
from billow.case.build import build_model, require_start_clear
from billow.case.schema import Case
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.kinds import farthest, number_of
from billow.geometry.shapes.pose import of_plane, quaternion_about, rotation_matrix
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid
from billow.geometry.shapes.touching import touch
from billow.parts.bodies import rigid_body
from billow.parts.bodies.bodies import BODY_KINETIC, CONTACT, FRICTION, Bodies
from billow.parts.bodies.body import Body
from billow.parts.bodies.contact import Nodes, SurfaceLaw
from billow.parts.bodies.rigid_body import RigidBody, RigidState
from billow.parts.part import Moment
from billow.solver.run import Schedule, run

ELASTIC, ROUGH = SurfaceLaw(1e5, 0.0, 0.0), SurfaceLaw(1e5, 0.3, 0.1)
UP = np.array([0.0, 0.0, 1.0])
DT = 1e-5


def body(name, centre, velocity=(0.0, 0.0, 0.0), *, radii=0.1, degree=2.0, mass=4.0, law=ELASTIC, turn=(0.0, 0.0)):
    shape = SuperEllipsoid(np.full(3, radii) if np.ndim(radii) == 0 else np.array(radii), degree)
    rigid = RigidBody(mass, shape.inertia(mass), locked=False)
    start = RigidState(np.array(centre, float), velocity=np.array(velocity, float))
    start.quaternion = quaternion_about(np.array([0.6, 0.0, 0.8]), turn[0])
    start.angular_momentum = turn[1] * rigid.inertia
    return Body.of(name, shape, law, rigid, start)


def plate(law=ELASTIC, normal=UP):
    pose = of_plane(0.0, np.array(normal))
    rigid = RigidBody(1.0, np.ones(3), locked=True)
    return Body.of("plate", HalfSpace(), law, rigid, RigidState(pose.centre, pose.quaternion))


class Scene:
    """Bodies alone, step by step, with their books."""

    def __init__(self, *bodies, gravity=(0.0, 0.0, 0.0), dt=DT):
        self.part, self.dt = Bodies(bodies, np.zeros(0), np.array(gravity, float)), dt
        self.state, self.lost, self.stored, self.time = self.part.start(), 0.0, 0.0, 0.0

    def step(self):
        nothing = [np.zeros((0, 3)) for _ in range(4)]
        self.part.kick_touch_drift(self.state, Nodes(np.zeros(0), *nothing), self.dt)
        for account, energy in self.part.meet(self.state, self.dt):
            self.stored = energy if account is CONTACT else self.stored
            self.lost += energy if account is FRICTION else 0.0
        self.part.move(self.state, self.dt)
        self.time += self.dt
        self.part.guard(self.state, Moment(self.time, 1, self.dt, nothing, nothing))

    def run(self, steps):
        for _ in range(steps):
            self.step()
        return self

    @property
    def kinetic(self):
        return dict(self.part.kinetic_energy(self.state))[BODY_KINETIC]

    @property
    def momentum(self):
        pairs = list(zip(self.part.bodies, self.state.motion, strict=True))
        free = [(b.rigid.mass, m) for b, m in pairs if not b.rigid.locked]
        linear = sum(mass * m.velocity for mass, m in free)
        return linear, sum(mass * np.cross(m.centre, m.velocity) + m.angular_momentum for mass, m in free)


def test_a_ball_bounces_off_a_plate_with_its_whole_energy_and_at_the_depth_of_the_closed_form():
    normal = np.array([0.48, -0.36, 0.8])
    centre, velocity = 0.102 * normal, -3.0 * normal
    scene, deepest = Scene(plate(normal=normal), body("ball", centre, velocity), dt=5e-5), 0.0
    start = scene.kinetic
    for _ in range(200):
        scene.step()
        deepest = max(deepest, float(scene.state.meeting.deepest[0]))
    assert scene.state.motion[1].velocity == pytest.approx(-velocity, rel=1e-9)
    assert scene.kinetic == pytest.approx(start, rel=1e-9)
    assert abs(scene.lost) < 1e-9 * start
    foundation = 0.5 * ELASTIC.slope / 1e-4  # two equal springs in series
    assert deepest == pytest.approx((3.0 * start / (np.pi * 0.1 * foundation)) ** (1.0 / 3.0), rel=1e-3)


@pytest.mark.parametrize("second", [4.0, 1.0, 100.0])
def test_two_balls_exchange_momentum_as_elastic_bodies_do(second):
    way = np.array([0.6, 0.0, 0.8])
    scene = Scene(body("a", -0.101 * way, 4.0 * way), body("b", 0.101 * way, -1.0 * way, mass=second), dt=2e-5).run(
        1000
    )
    a, b = (float(motion.velocity @ way) for motion in scene.state.motion)
    total = 4.0 + second
    assert a == pytest.approx((4.0 * (4.0 - second) - 2.0 * second) / total, rel=1e-9)
    assert b == pytest.approx((32.0 - (second - 4.0)) / total, rel=1e-9)
    linear, _ = scene.momentum
    assert linear == pytest.approx((16.0 - second) * way, abs=1e-12)


def test_damping_takes_energy_and_the_books_know_it():
    laws = SurfaceLaw(1e5, 0.0, 0.2)
    scene = Scene(plate(laws), body("ball", [0.0, 0.0, 0.101], [0.0, 0.0, -3.0], law=laws))
    start = scene.kinetic
    scene.run(600)
    assert 0.2 * start < scene.kinetic < 0.7 * start
    assert scene.kinetic + scene.stored + scene.lost == pytest.approx(start, rel=1e-9)


def test_a_body_at_rest_on_a_plate_stays_and_under_gravity_the_plate_carries_it():
    resting = Scene(plate(ROUGH), body("ball", [0.0, 0.0, 0.1], law=ROUGH)).run(50)
    assert not resting.state.motion[1].force.any()
    assert resting.state.motion[1].centre.tolist() == [0.0, 0.0, 0.1]
    weight = Scene(plate(ROUGH), body("ball", [0.0, 0.0, 0.1], law=ROUGH), gravity=[0.0, 0.0, -9.81], dt=1e-3).run(800)
    assert weight.state.meeting.force[1, 2] == pytest.approx(4.0 * 9.81, rel=1e-3)
    assert weight.state.meeting.force[0] == pytest.approx(-weight.state.meeting.force[1])


def test_a_ball_thrown_flat_onto_a_rough_plate_slides_until_it_rolls():
    """Coulomb: 2/7 of a sliding ball's speed are lost when it rolls."""
    scene = Scene(
        plate(ROUGH), body("ball", [0.0, 0.0, 0.1], [1.0, 0.0, 0.0], law=ROUGH), gravity=[0.0, 0.0, -9.81], dt=5e-4
    )
    scene.run(600)
    motion = scene.state.motion[1]
    turning = rigid_body.spin(scene.part.bodies[1].rigid, motion)
    assert motion.velocity[0] == pytest.approx(5.0 / 7.0, rel=1e-3)
    assert turning[1] == pytest.approx(motion.velocity[0] / 0.1, rel=1e-2)


def collision(dt):
    """Two spinning boxes of degree 3 and 4 that hit each other off centre."""
    return Scene(
        body(
            "a", [-0.12, 0.01, 0.0], [4.0, 0.0, 0.5], radii=[0.1, 0.06, 0.08], degree=3.0, law=ROUGH, turn=(0.3, 20.0)
        ),
        body("b", [0.1, -0.02, 0.03], radii=[0.07, 0.09, 0.05], degree=4.0, mass=2.0, law=ROUGH, turn=(1.1, -30.0)),
        dt=dt,
    )


def turned(scene, quaternion):
    rotation = rotation_matrix(quaternion)
    w, v = quaternion[0], quaternion[1:]
    for motion in scene.state.motion:
        motion.centre, motion.velocity = rotation @ motion.centre, rotation @ motion.velocity
        motion.angular_momentum = rotation @ motion.angular_momentum
        p, u = motion.quaternion[0], motion.quaternion[1:]
        motion.quaternion = np.concatenate([[w * p - v @ u], w * u + p * v + np.cross(v, u)])
    return scene


def test_an_oblique_collision_keeps_momentum_and_its_books_close_with_the_step():
    residuals = []
    for dt in (1.6e-4, 8e-5, 4e-5):
        scene = collision(dt)
        linear, angular = scene.momentum
        start = scene.kinetic
        scene.run(round(0.012 / dt))
        now, turning = scene.momentum
        assert np.linalg.norm(scene.state.motion[1].velocity) > 1.0  # they did meet
        assert now == pytest.approx(linear, abs=1e-12)
        assert turning == pytest.approx(angular, abs=2e-3 * np.linalg.norm(angular))
        assert scene.lost > 0.0
        residuals.append(abs(scene.kinetic + scene.stored + scene.lost - start) / start)
    assert residuals[0] < 0.01
    assert residuals[2] < 0.6 * residuals[0]


def test_a_collision_turned_in_space_is_the_same_collision():
    quaternion = np.array([0.8, 0.2, -0.4, 0.4]) / np.linalg.norm([0.8, 0.2, -0.4, 0.4])
    here, there = collision(4e-5), collision(4e-5)
    turned(there, quaternion)
    here.run(300)
    there.run(300)
    turned(here, quaternion)
    for one, other in zip(here.state.motion, there.state.motion, strict=True):
        assert other.centre == pytest.approx(one.centre, abs=1e-8)
        assert other.velocity == pytest.approx(one.velocity, abs=1e-6)


@settings(max_examples=60)
@given(
    st.tuples(*[st.floats(0.02, 0.2)] * 6), st.tuples(*[st.sampled_from([2.0, 3.0, 6.0, 10.0])] * 2),
    st.tuples(*[st.floats(-0.3, 0.3)] * 3).filter(lambda c: np.linalg.norm(c) > 0.02), st.floats(0.0, 3.0),
)  # fmt: skip
def test_shapes_scaled_alike_touch_where_their_surfaces_face_each_other(radii, degrees, apart, angle):
    a, b = SuperEllipsoid(np.array(radii[:3]), degrees[0]), SuperEllipsoid(np.array(radii[3:]), degrees[1])
    apart, rotation = np.array(apart), rotation_matrix(quaternion_about(np.array([0.6, 0.0, 0.8]), angle))
    poses = [tuple(np.eye(3).ravel()), tuple(rotation.ravel())]
    told = [(number_of(shape), tuple(shape.numbers), pose) for shape, pose in zip((a, b), poses, strict=True)]
    *normal, span, px, py, pz = touch(*told[0], *told[1], *apart)
    normal, place = np.array(normal), np.array([px, py, pz])
    overlap = span - apart @ normal
    own = [place, rotation.T @ (place - apart)]
    scales = [(s.level(p) + 1.0) ** (1.0 / s.degree) for s, p in zip((a, b), own, strict=True)]
    assert scales[0] == pytest.approx(scales[1], rel=5e-4)  # boxes of degree 10 have nearly flat sides
    assert apart @ normal / span == pytest.approx(scales[0], rel=5e-4)
    assert (overlap > 0.0) == (scales[0] < 1.0) or abs(overlap) < 1e-9
    points = [np.array(farthest(*t[:2], *d)) for t, d in zip(told, (normal, rotation.T @ normal), strict=True)]
    reached = points[0] @ normal + points[1] @ (rotation.T @ normal)
    assert span == pytest.approx(reached, abs=1e-9)


def case(*obstacles):
    bag = {"diameter": 0.3, "element_size": 0.05, "vents": {"count": 0}}
    return Case.from_dict({"bag": bag, "gas": {"model": "none"}, "obstacles": list(obstacles)})


HEAD = {"shape": "super-ellipsoid", "name": "head", "radii": 0.1, "clearance": 0.05, "locked": False}
BLOCK = HEAD | {"name": "block", "clearance": 0.06, "offset": [0.15, 0.0], "locked": True}


WALL = {"shape": "plate", "name": "wall", "normal": [0, 0, -1]}


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (BLOCK, "49.7 mm"), (BLOCK | {"locked": False}, "49.7 mm"), (WALL | {"height": 0.3}, None),
        (WALL | {"height": 0.2}, "50 mm"),
    ],
)  # fmt: skip
def test_bodies_that_overlap_at_the_start_are_refused_if_one_can_move(other, words):
    model = build_model(case(HEAD, other))
    if words is None:
        require_start_clear(model)
        return
    with pytest.raises(InputError) as caught:
        require_start_clear(model)
    assert caught.value.code == "E-GEO-022"
    assert all(told in caught.value.what for told in ("head", other["name"], words)), caught.value.what
    if other.get("locked"):
        require_start_clear(build_model(case(HEAD | {"locked": True}, other)))


def test_bodies_that_go_too_deep_stop_the_run():
    soft = SurfaceLaw(200.0, 0.0, 0.0)
    with pytest.raises(NumericalStop, match=r"E-NUM-010 error: ball and plate went 5\d"):
        Scene(plate(soft), body("ball", [0.0, 0.0, 0.1], [0.0, 0.0, -10.0], law=soft)).run(3000)


def test_without_two_bodies_that_can_meet_nothing_is_asked():
    locked = build_model(case(HEAD | {"locked": True}, BLOCK, {"shape": "plate", "height": -0.01}))
    assert locked.bodies.meetings.pairs == ()
    assert locked.bodies.meet(locked.bodies.start(), DT) == []


def test_a_free_head_that_falls_past_the_bag_bounces_off_the_plate():
    """It fell through, without a word."""
    beside = HEAD | {"clearance": 0.02, "offset": [0.5, 0.0], "velocity": [0.0, 0.0, -5.0]}
    model = build_model(case({"shape": "plate"}, beside))
    state = run(model, Schedule(0.012, 1, 1))
    head = state.bodies.motion[1]
    assert 2.0 < head.velocity[2] < 5.0  # damping of 0.1
    assert head.centre[2] > 0.1
    assert state.ledger["friction"] == pytest.approx(0.5 * 4.5 * (25.0 - head.velocity[2] ** 2), rel=1e-3)
    assert state.ledger.relative_error < 1e-3
