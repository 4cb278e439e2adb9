"""Moved obstacles: the work of what moves them is the integral of force over way, and the books close with it."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.build import build_model, build_schedule
from billow.case.obstacles.obstacles import OBSTACLES, build_body
from billow.case.schema import Case
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.pose import of_plane
from billow.geometry.surface import area_vectors
from billow.parts.bodies.bodies import Bodies
from billow.parts.bodies.body import Body
from billow.parts.bodies.contact import Nodes, SurfaceLaw
from billow.parts.bodies.drive import Course, Guided, Prescribed
from billow.parts.bodies.penalty import A_REFERENCE
from billow.parts.bodies.rigid_body import RigidBody, RigidState
from billow.parts.part import DRIVE_WORK
from billow.solver.ledger import Ledger
from billow.solver.model import start_state
from billow.solver.run import Recorder, run

DOWN = np.array([0.0, 0.0, -1.0])
SLOPE, NODES = 1e4, 50
AREA = np.full(NODES, 2e-4)
STIFFNESS = SLOPE * AREA.sum() / A_REFERENCE
DT = 1e-5


def bed_and_plate(drive, normal=DOWN):
    """Nodes that are held fast in a plane, and a plate that faces them and touches."""
    pose = of_plane(0.0, normal)
    start = RigidState(pose.centre, pose.quaternion)
    if isinstance(drive, Guided):
        start.velocity = drive.speed * drive.direction
    law = SurfaceLaw(SLOPE, friction=0.0, damping=0.0)
    plate = Body.of("press", HalfSpace(), law, RigidBody(1.0, np.ones(3), locked=True), start, drive)
    across = np.random.default_rng(1).uniform(-0.1, 0.1, (NODES, 3))
    return plate, across - np.outer(across @ normal, normal)


def press(drive, until, gravity=(0.0, 0.0, 0.0), normal=DOWN):
    """Steps up to a time [s]: force on the plate along its direction [N], its way [m], and the ledger after each."""
    plate, positions = bed_and_plate(drive, normal)
    part = Bodies((plate,), AREA, np.array(gravity))
    state, ledger, rows = part.start(), Ledger.of(part.accounts), []
    ledger.book(part.kinetic_energy(state))
    ledger.close()
    still = np.zeros((NODES, 3))
    for step in range(round(until / DT)):
        ledger.open()
        part.drive(state, step * DT, DT)
        nodes = Nodes(np.zeros(NODES), still, positions, still.copy(), still.copy())
        ledger.book(part.kick_touch_drift(state, nodes, DT))
        ledger.book(part.meet(state, DT))
        ledger.book(part.move(state, DT))
        ledger.close()
        motion = state.motion[0]
        rows.append((motion.force @ drive.direction, motion.centre @ drive.direction))
    return np.array(rows), ledger, state


TILTED = np.array([0.6, 0.0, 0.8])


@pytest.mark.parametrize("normal", [DOWN, TILTED], ids=["down", "tilted"])
def test_a_plate_that_presses_springs_meets_their_force_and_does_their_work(normal):
    depth = 2e-3
    travel = Prescribed(normal, Course(np.array([0.0, 0.01]), np.array([0.0, depth])), is_speed=False)
    rows, ledger, state = press(travel, 0.012, normal=normal)
    force, way = rows.T
    assert way[-1] == pytest.approx(depth, rel=1e-12)
    assert force[-1] == pytest.approx(-STIFFNESS * depth, rel=1e-9)
    assert ledger["drive_work"] == pytest.approx(0.5 * STIFFNESS * depth**2, rel=1e-9)
    assert ledger["contact"] == pytest.approx(0.5 * STIFFNESS * depth**2, rel=1e-9)
    assert state.work[0] == ledger["drive_work"]
    assert ledger.relative_error < 1e-12


def test_speed_is_integrated_to_travel_exactly():
    course = Course(np.array([1e-3, 3e-3, 4e-3]), np.array([1.0, 3.0, 0.0]))
    drive = Prescribed(DOWN, course, is_speed=True)
    assert drive.way(1e-3) == pytest.approx(1e-3)
    assert drive.way(2e-3) == pytest.approx(1e-3 + 1.5e-3)
    assert drive.way(9e-3) == pytest.approx(1e-3 + 4e-3 + 1.5e-3)
    rows, ledger, _ = press(drive, 5e-3)
    assert rows[-1, 1] == pytest.approx(6.5e-3, rel=1e-12)
    assert ledger["drive_work"] == pytest.approx(0.5 * STIFFNESS * 6.5e-3**2, rel=1e-9)


def test_a_guided_plate_swings_on_springs_as_a_mass_does():
    mass, speed = 2.0, 1.5
    rate = np.sqrt(STIFFNESS / mass)
    half = np.pi / rate
    rows, ledger, state = press(Guided(DOWN, Course(np.zeros(1), np.zeros(1)), mass, speed), half)
    assert rows[:, 1].max() == pytest.approx(speed / rate, rel=1e-4)
    assert state.motion[0].velocity == pytest.approx(-speed * DOWN, abs=2e-3 * speed)
    assert ledger["drive_work"] == 0.0
    assert ledger.relative_error < 2e-3


def test_a_force_and_gravity_press_a_guided_plate_to_twice_its_rest():
    mass, force, g = 2.0, 40.0, 9.81
    drive = Guided(DOWN, Course(np.zeros(1), np.full(1, force)), mass, 0.0)
    rows, ledger, _ = press(drive, np.pi * np.sqrt(mass / STIFFNESS), gravity=(3.0, 0.0, -g))
    deepest = 2.0 * (force + mass * g) / STIFFNESS
    assert rows[-1, 1] == pytest.approx(deepest, rel=1e-3)
    assert ledger["drive_work"] == pytest.approx(force * deepest, rel=1e-3)
    assert ledger["gravity_work"] == pytest.approx(mass * g * deepest, rel=1e-3)
    assert ledger.relative_error < 2e-3


def test_a_force_against_time_gives_its_impulse():
    plate, positions = bed_and_plate(Guided(TILTED, Course(np.array([0.0, 1e-3]), np.array([0.0, 90.0])), 3.0, 0.5))
    part = Bodies((plate,), np.zeros(NODES), np.zeros(3))  # nothing to touch
    state, still = part.start(), np.zeros((NODES, 3))
    for step in range(100):
        part.drive(state, step * DT, DT)
        part.kick_touch_drift(state, Nodes(np.zeros(NODES), still, positions, still.copy(), still.copy()), DT)
        part.move(state, DT)
    assert state.motion[0].velocity == pytest.approx((0.5 + 0.045 / 3.0) * TILTED, rel=1e-12)


def test_a_free_ball_between_a_guided_plate_and_the_floor_closes_the_books():
    """Bodies that meet: a rail lets a body yield in one direction only, and the work of the force is booked."""
    ball = {"shape": "super-ellipsoid", "radii": 0.05, "locked": False, "mass": 1.0, "clearance": 0.01, "friction": 0.3}
    press_ = {
        "shape": "plate", "name": "press", "height": 0.12, "normal": [0.1, 0.0, -1.0],
        "motion": {"kind": "guided", "mass": 0.5, "force": 800.0, "speed": 3.0},
    }  # fmt: skip
    tables = [{"shape": "plate", "name": "floor"}, ball, press_]
    bodies = tuple(build_body(OBSTACLES[t["shape"]].model_validate(t)) for t in tables)
    part = Bodies(bodies, np.zeros(1), np.array([0.0, 0.0, -9.81]))
    errors = []
    for dt in (2e-5, 1e-5):
        state, ledger = part.start(), Ledger.of(part.accounts)
        ledger.book(part.kinetic_energy(state))
        ledger.close()
        still = np.zeros((1, 3))
        for step in range(round(0.02 / dt)):
            ledger.open()
            part.drive(state, step * dt, dt)
            ledger.book(part.kick_touch_drift(state, Nodes(np.zeros(1), still, still, still, still.copy()), dt))
            ledger.book(part.meet(state, dt))
            ledger.book(part.move(state, dt))
            ledger.close()
        errors.append(ledger.relative_error)
        assert ledger["drive_work"] > 1.0
        assert ledger["friction"] > 0.0
    assert state.meeting.force[1].any() or state.motion[1].velocity.any()
    assert not state.motion[2].velocity[:2].any()  # on its rail
    assert errors[0] < 2e-3
    assert errors[1] < 0.7 * errors[0]


PILLOW = {
    "bag": {"shape": "square", "side": 0.2, "element_size": 0.0167, "mouth_radius": 0.02, "initial_gap": 0.004},
    "inflator": {"mass_flow": {"time": [0.0, 0.004, 0.008], "value": [0.0, 0.25, 0.0]}},
    "obstacles": [
        {"shape": "plate", "name": "floor", "slope": 1e6},
        {
            "shape": "plate", "name": "press", "height": 0.11, "normal": [0.0, 0.0, -1.0], "slope": 1e6,
            "friction": 0.0,
            "motion": {"kind": "speed", "speed": {"time": [0.008, 0.009, 0.015, 0.016], "value": [0.0, 7.0, 7.0, 0.0]}},
        },
    ],
    # A row at every step, so that force over way can be summed from them.
    "run": {"end_time": 0.02, "frames": 4, "histories_per_frame": 800},
}  # fmt: skip


class Rows(Recorder):
    def __init__(self):
        self.rows, self.kept = [], None

    def history(self, model, state):
        motion = state.bodies.motion[1]
        self.rows.append((motion.force[2], motion.centre[2], state.ledger["drive_work"]))

    def step(self, model, state):
        if state.step == 1500:
            self.kept = copy.deepcopy(state)


def test_a_press_on_a_pillow_feels_pressure_times_area_and_its_work_is_force_over_way():
    model = build_model(case := Case.from_dict(PILLOW))
    rows = Rows()
    state = run(model, build_schedule(case.run), rows)
    force, height, work = np.array(rows.rows).T
    gauge = state.gas.vitals.pressure - 101325.0
    assert gauge > 5e3
    touching = state.bodies.contact.touching[1][model.surface.triangles]  # the edge of the patch lies within triangles
    area = np.linalg.norm(area_vectors(model.surface.triangles, state.positions), axis=1)
    assert gauge * area[touching.all(axis=1)].sum() < np.mean(force[-80:]) < gauge * area[touching.any(axis=1)].sum()
    assert len(force) == state.step + 1  # each is the mean force over the step that led to it
    assert work[-1] == pytest.approx(float(np.sum(force[1:] * -np.diff(height))), rel=1e-12)
    assert work[-1] > 5.0
    assert state.ledger.relative_error < 0.01
    again = run(model, build_schedule(case.run), state=rows.kept)
    for one, other in zip((state, again), (again, state), strict=True):
        assert np.array_equal(one.positions, other.positions)
        assert one.bodies.work.tolist() == other.bodies.work.tolist()
        assert one.ledger.energies == other.ledger.energies


def test_histories_of_a_moved_obstacle_say_where_it_is_and_what_moved_it():
    model = build_model(Case.from_dict(PILLOW))
    owners = {owner.name: owner for owner in model.bodies.owners()}
    assert "drive_work" not in owners["floor"].quantities
    state = start_state(model)
    named = {(q.of, q.name) for q in model.bodies.quantities(state.bodies, state.moment)}
    for quantity in ("centre", "velocity", "quaternion", "drive_work"):
        assert quantity in owners["press"].quantities
        assert ("press", quantity) in named
    assert DRIVE_WORK in model.accounts
    fixed = copy.deepcopy(PILLOW)
    del fixed["obstacles"][1]["motion"]
    assert DRIVE_WORK not in build_model(Case.from_dict(fixed)).accounts


@pytest.mark.parametrize(
    "motion",
    [
        {"kind": "travel", "travel": {"time": [0.0, 1.0], "value": [0.1, 0.2]}},
        {"kind": "travel", "travel": {"time": [0.0, 1e-6], "value": [0.0, 0.2]}},
        {"kind": "speed", "speed": 1.0, "direction": [0.0, 0.0, 0.0]},
        {"kind": "guided", "force": 1.0},
        {"kind": "travel", "speed": 1.0},
    ],
)
def test_a_motion_that_means_nothing_is_refused(motion):
    with pytest.raises(InputError):
        Case.from_dict({"obstacles": [{"shape": "plate", "motion": motion}]})
