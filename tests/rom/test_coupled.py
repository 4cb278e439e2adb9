"""The coupled model: its geometry and motion against closed forms, its force against a law it can learn."""

from __future__ import annotations

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest
from free_synthetic import CLEARANCE, MASS, FreeDataset, case, finished

from billow.base.errors import InputError, IntegrityError
from billow.geometry.shapes.super_ellipsoid import closest_point
from billow.results.histories import read_histories
from billow.rom.coupled.answer_files import write_answer
from billow.rom.coupled.coupled_evaluation import (
    COUPLED,
    TRUE_CONTACT,
    TRUE_INPUTS,
    _bag_with_true_forces,
    evaluate_coupled,
)
from billow.rom.coupled.coupled_model import Coupled
from billow.rom.coupled.impactor import (
    EVERY,
    REACHES,
    Impactor,
    ImpactorMotion,
    ImpactorOfDesign,
    area_vectors,
    filtered_force,
    node_area,
    recorded_force,
)
from billow.rom.coupled.motion_errors import MEAN_MOTION
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.force_inputs import previous
from billow.rom.surrogate.surrogate import Surrogate


@pytest.fixture(scope="module")
def coupled(judged):
    return judged.despite_verdict()


def body(degree=2.0, angle=0.0, radii=(0.15, 0.12, 0.2)):
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return Impactor(np.array(radii), degree, np.array([0.1, -0.2, 0.5]), rotation, MASS, np.zeros(3))


def test_distance_to_a_sphere_is_exact():
    sphere = body(radii=(0.15, 0.15, 0.15), angle=0.4)
    nodes = np.random.default_rng(1).normal(scale=0.3, size=(50, 3)) + sphere.centre
    distance, normal = sphere.distance_to(nodes, sphere.centre)
    away = nodes - sphere.centre
    assert distance == pytest.approx(np.linalg.norm(away, axis=1) - 0.15, abs=1e-12)
    assert normal == pytest.approx(away / np.linalg.norm(away, axis=1)[:, None], abs=1e-12)


@pytest.mark.parametrize("degree", [2.0, 3.3, 4.5])
def test_distance_near_any_body_is_that_of_the_closest_point(degree):
    # First order: at 1 mm the error is of the order (1 mm)^2 over the smallest radius of curvature.
    shape = body(degree, angle=0.7)
    random = np.random.default_rng(2).normal(size=(40, 3))
    gauge = (np.abs(random / shape.radii) ** degree).sum(axis=1) ** (1.0 / degree)
    surface = random / gauge[:, None]
    _, normal = shape.distance_to(surface @ shape.rotation.T + shape.centre, shape.centre)
    nodes = surface @ shape.rotation.T + 1e-3 * normal + shape.centre
    distance, _ = shape.distance_to(nodes, shape.centre)
    for node, found in zip((nodes - shape.centre) @ shape.rotation, distance, strict=True):
        closest = np.array(closest_point(*node, *shape.radii, degree)[:3])
        assert found == pytest.approx(np.linalg.norm(node - closest), abs=2e-4)


def test_fabric_against_a_flat_face_pushes_with_its_area():
    # A box-like body stands on a patch of fabric; a quarter of the fabric lies under it, the rest out of reach.
    grid = (np.arange(40) + 0.5) / 40.0 - 0.5
    nodes = np.stack([*np.meshgrid(grid, grid), np.zeros((40, 40))], axis=-1).reshape(-1, 3)
    area = np.full(1600, 1.0 / 1600)
    box = Impactor(np.full(3, 0.25), 60.0, np.array([0.0, 0.0, 0.25]), np.eye(3), MASS, np.zeros(3))
    touching = area_vectors(nodes, area, box, box.centre)
    assert touching[0] == pytest.approx([0.0, 0.0, 0.25], abs=0.01)
    # Lifted by one reach, its weight falls to 1/e; by fifty, to nothing.
    lifted = area_vectors(nodes, area, box, box.centre + np.array([0.0, 0.0, REACHES[0]]))
    assert lifted[0, 2] == pytest.approx(touching[0, 2] / np.e, rel=0.05)
    assert area_vectors(nodes, area, box, box.centre + np.array([0.0, 0.0, 1.0])) == pytest.approx(
        np.zeros((2, 3)), abs=1e-12
    )


def test_node_areas_add_up(free):
    a, b, c = (free.reference[free.triangles[:, k]] for k in range(3))
    whole = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert node_area(free.reference, free.triangles).sum() == pytest.approx(whole, rel=1e-5)


def test_the_body_of_a_design(free):
    of_design = ImpactorOfDesign.learn(free, free.train)
    found = of_design(np.array([20.0, 0.17]))
    assert of_design.name == "head"
    assert found.radii == pytest.approx([0.17] * 3, abs=1e-9)
    assert found.centre == pytest.approx([0.0, 0.0, CLEARANCE + 0.17], abs=1e-9)
    assert (found.degree, found.mass) == pytest.approx((3.0, MASS), abs=1e-9)
    assert found.rotation == pytest.approx(np.eye(3), abs=1e-9)


@pytest.mark.parametrize(
    ("code", "changes"), [("E-CPL-003", {"locked": True}), ("E-CPL-004", {"mass": None})], ids=["locked", "not affine"]
)
def test_a_body_the_design_does_not_tell_is_refused(free, code, changes):
    class Other(SimpleNamespace):
        def result(self, run):
            radius = free.design([run])[0, 1]
            mass = {"mass": 1.0 / radius} if "mass" in changes else changes
            return SimpleNamespace(case_toml=case(radius, **mass))

    with pytest.raises(InputError, match=code):
        ImpactorOfDesign.learn(Other(design=free.design, parameters=free.parameters), free.train)


def test_a_constant_force_moves_the_body_on_a_parabola(coupled):
    law = lambda design, time, state: np.array([0.0, 0.0, 40.0])  # noqa: E731
    gravity = np.array([0.0, 0.0, -9.81])
    motion = dataclasses.replace(coupled, law=law, gravity=gravity).deploy(
        {"pressure": 20.0, "radius": 0.15}, pushed=np.array([0.0, 0.0, -0.05])
    )
    # Position Verlet is exact for a constant acceleration; within reach from the start, so the law always acts.
    a, t = 40.0 / MASS - 9.81, motion.times
    assert motion.displacement[:, 2] == pytest.approx(0.5 * a * t**2, abs=1e-12)
    assert motion.velocity[:, 2] == pytest.approx(a * t, abs=1e-12)


def test_the_law_is_asked_in_the_middle_of_each_step(coupled):
    asked, speeds = [], []

    def law(design, time, state):
        asked.append(time)
        speeds.append(state[-3:])
        return np.array([0.0, 0.0, 1.0])

    motion = dataclasses.replace(coupled, law=law).deploy(
        {"pressure": 20.0, "radius": 0.15}, pushed=np.array([0.0, 0.0, -0.05])
    )
    np.testing.assert_allclose(speeds, motion.velocity[:-1:EVERY])
    dt = EVERY * (coupled.times[1] - coupled.times[0])
    np.testing.assert_allclose(asked, (np.arange(len(asked)) + 0.5) * dt)
    assert len(asked) == (len(coupled.times) - 1) // EVERY


def test_a_body_that_moves_at_the_start_keeps_moving(coupled):
    speed = np.array([0.3, 0.0, 2.0])
    moving = lambda row: dataclasses.replace(coupled.impactor(row), velocity=speed)  # noqa: E731
    motion = dataclasses.replace(coupled, impactor=moving).replay(
        {"pressure": 20.0, "radius": 0.15}, np.zeros((len(coupled.times) - 1, 3))
    )
    np.testing.assert_allclose(motion.displacement, motion.times[:, None] * speed, atol=1e-12)


def test_a_last_step_that_is_shorter_has_its_own_mean(coupled):
    times = coupled.times[:-2]
    assert (len(times) - 1) % EVERY
    force = np.random.default_rng(3).normal(size=(len(times) - 1, 3))
    motion = dataclasses.replace(coupled, times=times).replay({"pressure": 20.0, "radius": 0.15}, force)
    np.testing.assert_allclose(motion.velocity[-1], force.sum(axis=0) * (times[1] - times[0]) / MASS, atol=1e-12)


def test_the_force_that_is_learned_bears_the_body(free, coupled, monkeypatch):
    """The same motion under gravity takes a force that is larger by the weight."""
    learned = []
    monkeypatch.setattr("billow.rom.coupled.coupled_model.learn_contact_law", lambda *told: learned.append(told[4]))

    class Heavy:
        def __getattr__(self, name):
            return getattr(free, name)

        def result(self, run):
            found = free.result(run)
            heavy = found.case_toml | {"run": {"gravity": [0.0, 0.0, -9.81]}}
            return finished(found.histories, heavy)

    for dataset in (free, Heavy()):
        Coupled.train(dataset, coupled.surrogate, calibrate=False)
    weight = np.broadcast_to([0.0, 0.0, 9.81 * MASS], learned[0].shape)
    np.testing.assert_allclose(learned[1] - learned[0], weight, atol=1e-9)


def test_runs_whose_histories_differ_in_their_times_are_refused(free, coupled):
    class Ragged:
        def __getattr__(self, name):
            return getattr(free, name)

        def result(self, run):
            found = free.result(run)
            if run != free.train[3]:
                return found
            later = {**found.histories, "time [s]": found.histories.time * 1.01}
            return finished(later, found.case_toml)

    with pytest.raises(InputError, match=f"E-CPL-005(?s:.*){free.train[3]}"):
        Coupled.train(Ragged(), coupled.surrogate)


def test_nothing_pushes_a_body_out_of_reach(coupled):
    motion = coupled.deploy({"pressure": 20.0, "radius": 0.15}, pushed=np.array([0.0, 0.0, 20.0]))
    assert not motion.velocity.any()


def test_a_known_force_moves_the_body_as_its_impulse_says(coupled):
    # Momentum is exact for any course of the force: the mean over each step is held over that step.
    gravity = np.array([0.0, 0.0, -9.81])
    force = np.zeros((len(coupled.times) - 1, 3))
    force[:, 2] = 300.0 * np.sin(np.linspace(0.0, 3.0, len(force)))
    motion = dataclasses.replace(coupled, gravity=gravity).replay({"pressure": 20.0, "radius": 0.15}, force)
    impulse = np.cumsum(force[:, 2]) * coupled.times[1]
    ends = np.arange(EVERY, len(coupled.times), EVERY)
    expected = impulse[ends - 1] / MASS - 9.81 * coupled.times[ends]
    assert motion.velocity[ends, 2] == pytest.approx(expected, abs=1e-12)
    # Within a step the velocity is that of the held mean: off by at most the force's change over a step, 12 N.
    whole = np.concatenate([[0.0], impulse / MASS]) - 9.81 * coupled.times
    assert motion.velocity[:, 2] == pytest.approx(whole, abs=12.0 / MASS * EVERY * coupled.times[1])


def test_the_true_contact_force_is_rated_nearly_perfect(free, coupled):
    # What is lost: 0.4 ms for which a force is held, and CFC 180 once more. 0.99 and above at CFC 60.
    evaluation = evaluate_coupled(free, coupled)
    assert evaluation.worst("acceleration CFC 60", TRUE_CONTACT) > 0.99
    assert evaluation.worst("acceleration CFC 180", TRUE_CONTACT) > 0.95
    assert evaluation.worst("velocity", TRUE_CONTACT) > 0.99
    assert evaluation.worst("displacement", TRUE_CONTACT) > 0.99
    assert TRUE_INPUTS not in evaluation.ratings


def test_recorded_force_is_that_of_the_motion(free):
    # Newton: the recorded force, and that of the histories' momentum, both filtered to CFC 180. The synthetic body's
    # velocity is a forward step: half an interval late, which is 0.05 ms of a filter that lets 1 ms through.
    result = free.result(free.test[0])
    recorded = recorded_force(result, "head")
    moved = filtered_force(ImpactorMotion.of_run(result, "head"), MASS, np.zeros(3))
    assert recorded == pytest.approx(moved, abs=0.05 * np.abs(moved).max())


def test_a_bag_told_the_true_forces_is_that_of_the_surrogate_with_forces(free, coupled):
    class Pushed(FreeDataset):
        def snapshots(self, field, runs):
            found = super().snapshots("displacement", runs)
            return found * np.float32(1e3) if field == "contact_force" else found

    dataset = Pushed()
    with_forces = train(dataset, Recipe(modes=3, epochs=30, force_modes=2))
    run, times = dataset.test[0], coupled.step_times
    bag = _bag_with_true_forces(dataset, run, with_forces, times)
    forces = previous(dataset.snapshots("contact_force", [run]))[0]
    known = with_forces.reference + with_forces.predict(dataset.design([run])[0], previous_forces=forces)
    row = int(np.abs(times - dataset.times[9]).argmin())
    assert times[row] == pytest.approx(dataset.times[9], abs=1e-12)
    assert bag[row] == pytest.approx(known[9], abs=1e-5)
    # Between two recorded times it lies between their shapes, or nearly: the dome only rises.
    middle = bag[row + 2, 0, 2]
    assert known[9, 0, 2] - 1e-3 < middle < known[10, 0, 2] + 1e-3
    evaluation = evaluate_coupled(dataset, coupled, with_forces=with_forces)
    assert evaluation.median("acceleration CFC 60", TRUE_INPUTS) > 0.8
    assert evaluation.ratings[TRUE_INPUTS] != evaluation.ratings[COUPLED]  # another bag, another motion
    assert list(evaluation.ratings) == [COUPLED, TRUE_INPUTS, TRUE_CONTACT, MEAN_MOTION]


def test_unseen_motion_is_found_with_nothing_known_in_advance(free, coupled):
    evaluation = evaluate_coupled(free, coupled)
    assert evaluation.median("velocity") > 0.9
    assert evaluation.median("acceleration CFC 60") > 0.8
    assert evaluation.median("velocity") > evaluation.median("velocity", MEAN_MOTION)
    record = json.loads(json.dumps(evaluation.record(), allow_nan=False))
    assert record["iso_18571"]["velocity"]["median"] == evaluation.median("velocity")
    assert record["nothing_known_in_advance"]
    true = record["iso_18571_of_other_answers"][TRUE_CONTACT]["velocity"]
    assert (true["worst"], len(true["scores"])) == (evaluation.worst("velocity", TRUE_CONTACT), len(free.test))


def test_the_closed_loop_does_not_run_away(free, coupled):
    # A body that starts 5 mm off goes another way, but the way stays a few times 5 mm near.
    for design in free.design(free.test):
        straight = coupled.deploy(design).centre
        for off in (-5e-3, 5e-3):
            other = coupled.deploy(design, pushed=np.array([0.0, 0.0, off])).centre
            assert np.abs(other - straight).max() < 6 * 5e-3


def test_a_file_answers_with_the_same_bits(coupled, tmp_path):
    path = coupled.save(tmp_path / "coupled.safetensors")
    design = {"pressure": 17.0, "radius": 0.13}
    again = Coupled.load(path)
    assert np.array_equal(again.despite_verdict().deploy(design).centre, coupled.deploy(design).centre)
    bags = [surrogate.despite_verdict() for surrogate in (Surrogate.load(path), coupled.surrogate)]
    assert np.array_equal(*(bag.predict(design) for bag in bags))
    coupled.surrogate.save(path)
    with pytest.raises(InputError, match="E-CPL-006"):
        Coupled.load(path)


def test_a_file_whose_parts_do_not_fit_is_refused(coupled, tmp_path):
    wrong = dataclasses.replace(coupled, impactor=ImpactorOfDesign("head", coupled.impactor.affine[:3]))
    with pytest.raises(IntegrityError, match="E-ROM-004"):
        Coupled.load(wrong.save(tmp_path / "coupled.safetensors"))


def test_answers_on_disk(coupled, tmp_path):
    answer = coupled.answer({"pressure": 25.0, "radius": 0.15})
    found = write_answer(answer, tmp_path / "out")
    columns = read_histories(tmp_path / "out" / "motion.csv")
    assert columns["head_velocity_z [m/s]"] == pytest.approx(answer.motion.velocity[:, 2], rel=1e-15)
    gained = np.sum(columns["head_acceleration_z [m/s^2]"][1:]) * 1e-4
    assert gained == pytest.approx(answer.motion.velocity[-1, 2], rel=1e-9)
    assert json.loads((tmp_path / "out" / "injury.json").read_text()) == found
    assert (tmp_path / "out" / "motion.svg").read_bytes().startswith(b"<?xml")


def test_designs_outside_are_refused_and_surrogates_that_want_forces(free, coupled):
    with pytest.raises(InputError, match="E-ROM-002"):
        coupled.deploy({"pressure": 99.0, "radius": 0.15})
    wants = dataclasses.replace(coupled.surrogate, forces=SimpleNamespace(width=0))
    with pytest.raises(InputError, match="E-CPL-005"):
        Coupled.train(free, wants)
