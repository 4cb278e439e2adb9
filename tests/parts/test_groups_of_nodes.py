"""Groups of nodes that fly off, are held or are moved: closed forms of their energy, momentum and work, and the books
of whole runs."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.build import build_model
from billow.case.schema import Case
from billow.geometry.bag_shapes import square_bag
from billow.geometry.mesh_file import CellMesh
from billow.geometry.mesh_writing import write_mesh
from billow.run.simulate import simulate
from billow.solver.run import Schedule, begin, run

VELOCITY, SPIN, ABOUT = np.array([3.0, -2.0, 5.0]), np.array([20.0, -30.0, 40.0]), np.array([0.1, 0.05, -0.2])
FABRIC = {"young_warp": 1e7, "young_weft": 1e7, "shear": 2e6, "damping": 0.0, "compression": True}


@pytest.fixture(scope="module")
def pillow(tmp_path_factory):
    """Tables of a closed pillow of 20 cm that nothing holds and nothing fills."""
    shape = square_bag(0.2, 8, 0.02)
    triangles = shape.surface.triangles.astype(np.int64)
    cells = np.column_stack([triangles, np.full(len(triangles), -1)])
    file = tmp_path_factory.mktemp("pillow") / "start.vtkhdf"
    write_mesh(file, CellMesh(shape.positions, cells, shape.surface.part.astype(np.int64) + 1, {}))
    parts = [{"name": "front", "number": 1}, {"name": "rear", "number": 2}]
    return {
        "bag": {"shape": "mesh", "start": str(file), "parts": parts}, "gas": {"model": "none"}, "fabric": FABRIC,
        "obstacles": [], "run": {"end_time": 2e-3},
    }  # fmt: skip


def model_of(pillow, *groups, **more):
    return build_model(Case.from_dict({**copy.deepcopy(pillow), "nodes": list(groups), **more}))


def test_a_bag_that_is_thrown_has_the_energy_of_a_rigid_body_and_keeps_its_momentum(pillow):
    thrown = {"name": "all", "velocity": list(VELOCITY), "spin": list(SPIN), "about": list(ABOUT)}
    model = model_of(pillow, thrown)
    schedule = Schedule(2e-3, 1, 10, 0.5)
    state = begin(model, schedule)
    mass = model.mass.sum()
    centre = model.mass @ model.start / mass
    arm = model.start - centre
    inertia = np.sum(model.mass[:, None, None] * (np.sum(arm**2, axis=1)[:, None, None] * np.eye(3)
                     - arm[:, :, None] * arm[:, None, :]), axis=0)  # fmt: skip
    of_centre = VELOCITY + np.cross(SPIN, centre - ABOUT)
    energy = 0.5 * mass * of_centre @ of_centre + 0.5 * SPIN @ inertia @ SPIN
    assert state.ledger["kinetic"] == pytest.approx(energy, rel=1e-12)
    assert state.ledger.start == pytest.approx(energy + state.ledger["strain"], rel=1e-12)
    assert state.velocities @ SPIN == pytest.approx(np.full(len(arm), VELOCITY @ SPIN), rel=1e-12)

    end = run(model, schedule)
    momentum = model.mass @ end.velocities
    np.testing.assert_allclose(momentum, mass * of_centre, rtol=1e-12)
    about = model.mass @ np.cross(end.positions - model.mass @ end.positions / mass, end.velocities)
    np.testing.assert_allclose(about, inertia @ SPIN, rtol=1e-4)
    np.testing.assert_allclose(model.mass @ end.positions / mass, centre + 2e-3 * of_centre, rtol=1e-12)
    assert end.ledger.relative_error < 1e-3


def test_what_is_held_does_not_fly_off(pillow):
    thrown = {"name": "front", "parts": ["front"], "velocity": [0.0, 0.0, 5.0], "spin": [0.0, 0.0, 10.0]}
    rail = {"name": "rail", "low": [0.0, -1.0, -1.0], "motion": {"kind": "fixed", "directions": ["z"]}}
    state = begin(model_of(pillow, thrown, rail), Schedule(1e-3, 1, 1))
    right, front = state.positions[:, 0] >= 0.0, state.velocities[:, 0] != 0.0
    assert not state.velocities[right, 2].any()
    assert (state.velocities[front & ~right, 2] == 5.0).all()
    np.testing.assert_allclose(state.velocities[front & right, 0], -10.0 * state.positions[front & right, 1])


def test_a_bag_that_is_carried_takes_the_work_of_its_kinetic_energy(pillow):
    speed = {"time": [0.0, 1e-3, 2e-3], "value": [0.0, 4.0, 4.0]}
    carried = {"name": "all", "motion": {"kind": "speed", "direction": [0.0, 3.0, 4.0], "speed": speed}}
    gravity = np.array([0.0, 0.0, -50.0])
    model = model_of(pillow, carried, run={"gravity": gravity.tolist()})
    state = run(model, Schedule(2e-3, 1, 10))
    way = 6e-3 * np.array([0.0, 0.6, 0.8])
    np.testing.assert_allclose(state.positions, model.start + way, atol=1e-14)
    mass = model.mass.sum()
    assert state.ledger["kinetic"] == pytest.approx(0.5 * mass * 16.0, rel=1e-12)
    assert state.ledger["gravity_work"] == pytest.approx(mass * gravity @ way, rel=1e-9)
    assert state.ledger["drive_work"] == pytest.approx(0.5 * mass * 16.0 - mass * gravity @ way, rel=1e-6)
    assert state.ledger.relative_error < 1e-9
    found = {q.name: q.value for q in model.driven.quantities(state.driven, state.moment)}
    np.testing.assert_allclose(found["displacement"], way, atol=1e-14)
    np.testing.assert_allclose(found["reaction"], -mass * gravity, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("directions", [["x", "y"], ["z"], ["x", "y", "z"]])
def test_nodes_yield_only_where_they_are_not_held(pillow, directions):
    """Free fall along a rail is exact, and books nothing but the work of gravity."""
    rail = {"name": "rail", "motion": {"kind": "fixed", "directions": directions}}
    gravity = np.array([20.0, -30.0, -90.0])
    model = model_of(pillow, rail, run={"gravity": gravity.tolist()})
    state = run(model, Schedule(2e-3, 1, 4))
    free = np.array([axis not in directions for axis in "xyz"])
    fall = np.where(free, gravity, 0.0)
    np.testing.assert_allclose(state.positions, model.start + 0.5 * 4e-6 * fall, atol=1e-13)
    np.testing.assert_allclose(state.velocities, np.tile(2e-3 * fall, (len(model.start), 1)), atol=1e-10)
    mass = model.mass.sum()
    assert state.ledger["kinetic"] == pytest.approx(0.5 * mass * 4e-6 * fall @ fall, rel=1e-9)
    assert state.ledger["drive_work"] == 0.0
    assert state.ledger.relative_error < 1e-9


def test_the_work_of_a_pull_is_what_the_fabric_stores_and_turns_to_heat(pillow):
    """One edge is held, the opposite one is pulled, free across: books close, the better the smaller the step."""
    pull = {"time": [0.0, 1e-3, 2e-3], "value": [0.0, 1.5e-3, 4e-3]}
    left = {"name": "left", "high": [-0.0999, 1.0, 1.0], "motion": {"kind": "fixed"}}
    right = {"name": "right", "low": [0.0999, -1.0, -1.0],
             "motion": {"kind": "travel", "direction": [1, 0, 0], "travel": pull, "across": "free"}}  # fmt: skip
    errors = []
    for scale in (1.0, 0.5):
        model = model_of(pillow, left, right)
        state = run(model, Schedule(2e-3, 1, 10, scale))
        ledger = state.ledger
        assert ledger["drive_work"] > 0.9 * ledger["strain"] > 0.0
        errors.append(ledger.relative_error)
        at = np.isclose(model.start[:, 0], 0.1)
        np.testing.assert_allclose(state.positions[at, 0], 0.104, atol=1e-14)
        assert np.abs(state.positions[at, 1] - model.start[at, 1]).max() > 1e-5  # it contracts across
    assert errors[0] < 5e-3
    assert errors[1] < 0.6 * errors[0]
    found = {(q.of, q.name): q.value for q in model.driven.quantities(state.driven, state.moment)}
    assert found["right", "reaction"][0] > 0.0 > found["left", "reaction"][0]


def test_work_against_an_obstacle_is_the_energy_of_its_springs(pillow):
    """A plate lies 1 mm below a bag that is carried 3 mm down."""
    plate = {"shape": "plate", "height": -0.011, "slope": 1e4, "damping": 0.0, "friction": 0.0}
    travel = {"time": [0.0, 2e-3], "value": [0.0, 3e-3]}
    carried = {"name": "all", "motion": {"kind": "travel", "direction": [0, 0, -1], "travel": travel}}
    model = model_of(pillow, carried, obstacles=[plate])
    state = run(model, Schedule(2e-3, 1, 10))
    depth = np.maximum(0.0, -0.011 - state.positions[:, 2])
    stored = float(0.5e8 * model.bodies.area @ depth**2)
    assert state.ledger["contact"] == pytest.approx(stored, rel=1e-9)
    kinetic = 0.5 * model.mass.sum() * 1.5**2
    assert state.ledger["drive_work"] == pytest.approx(stored + kinetic, rel=1e-6)
    assert state.ledger.relative_error < 1e-6


def test_groups_are_found_by_part_seam_box_and_number(pillow):
    shape = square_bag(0.2, 8, 0.02)

    def count(**conditions):
        model = model_of(pillow, {"name": "some", "motion": {"kind": "fixed"}, **conditions})
        return len(model.driven.nodes)

    assert count() == shape.surface.node_count == 81 + 49
    assert count(parts=["front"]) == 81
    assert count(between=["front", "rear"]) == 32
    assert count(parts=["rear"], low=[-1.0, -1.0, -1.0], high=[1.0, 1.0, -1e-4]) == 49
    assert count(numbers=[3, 4, 5]) == 3


@pytest.mark.parametrize(
    ("groups", "code"),
    [
        ([{"name": "a", "velocity": [1, 0, 0]}, {"name": "b", "parts": ["front"], "spin": [1, 0, 0]}], "E-CASE-214"),
        (
            [
                {"name": "a", "motion": {"kind": "fixed", "directions": ["x", "z"]}},
                {"name": "b", "motion": {"kind": "speed", "direction": [0, 1, 1], "speed": 1.0, "across": "free"}},
            ],
            "E-CASE-214",
        ),
        ([{"name": "a", "parts": ["side"], "velocity": [1, 0, 0]}], "E-CASE-213"),
        ([{"name": "a"}], "E-CASE-005"),
        ([{"name": "a", "velocity": [1, 0, 0], "motion": {"kind": "speed", "speed": 1.0}}], "E-CASE-005"),
    ],
)
def test_what_cannot_be_is_refused(pillow, groups, code):
    with pytest.raises(InputError) as refused:
        model_of(pillow, *groups)
    assert refused.value.code == code


def test_a_mouth_that_moves_with_its_bag_keeps_the_books(small_case, in_two, tmp_path):
    """The bag is pushed up by its mouth while it fills; a run that was stopped and resumed has the same bytes."""
    speed = {"time": [0.0, 3e-3], "value": [0.0, 5.0]}
    module = {"name": "module", "parts": ["mouth"], "motion": {"kind": "speed", "direction": [0, 0, 1], "speed": speed}}
    plane = {"name": "plane", "parts": ["front"], "high": [1.0, 0.0, 1.0]}
    plane["motion"] = {"kind": "fixed", "directions": ["y"]}
    case = small_case.vary({"run.end_time": 3e-3, "inflator.jets.count": 0, "obstacles": []})
    case = Case.from_dict({**case.to_dict(), "nodes": [module, plane]})
    result, resumed = simulate(case, tmp_path / "run"), in_two(case, tmp_path / "other")
    assert (result.folder / "histories.csv").read_bytes() == (resumed.folder / "histories.csv").read_bytes()
    histories = result.histories
    assert histories.of("module").displacement[-1] == pytest.approx([0.0, 0.0, 7.5e-3], abs=1e-12)
    assert histories.energy("drive_work")[-1] > 0.0
    assert np.abs(histories.energy("energy_residual")).max() < 1e-3 * histories.energy("gas_work")[-1]


def test_two_directions_of_two_groups_add(pillow):
    groups = [
        {"name": "a", "motion": {"kind": "fixed", "directions": ["x", "z"]}},
        {"name": "b", "motion": {"kind": "speed", "direction": [0, -1, 0], "speed": 1.0, "across": "free"}},
    ]
    model = model_of(pillow, *groups)
    state = run(model, Schedule(1e-3, 1, 2))
    np.testing.assert_allclose(state.positions, model.start - [0.0, 1e-3, 0.0], atol=1e-14)


def test_the_example_of_the_page_is_a_case(small_case):
    page = (Path(__file__).parents[2] / "docs" / "packing.md").read_text(encoding="utf-8")
    section = page[page.index("## Nodes that are held") :]
    tables = tomllib.loads(section.split("```")[1].removeprefix("toml"))
    case = Case.from_dict({**small_case.to_dict(), "obstacles": [], **tables})
    model = build_model(case)
    assert len(model.driven.nodes) > 3
    assert (model.start[model.driven.nodes, 0] >= 0.3).all()
    assert model.start_velocity.any()
