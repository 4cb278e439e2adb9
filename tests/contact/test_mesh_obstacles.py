"""Obstacles from meshes: the contact of the shape they draw, momentum and energy kept, the spin of their inertia."""

from __future__ import annotations

import numpy as np
import pytest
from run_fingerprint import fingerprint

from billow.base.errors import InputError
from billow.case.build import build_model, require_start_clear
from billow.case.obstacles.obstacles import OBSTACLES, build_body
from billow.case.schema import Case
from billow.geometry.mesh_file import CellMesh
from billow.geometry.mesh_writing import write_mesh
from billow.geometry.shapes.box import Box
from billow.geometry.shapes.mesh import Mesh, mass_properties
from billow.geometry.shapes.pose import quaternion_about, quaternion_of, rotation_matrix, times
from billow.geometry.shapes.triangulated import sphere
from billow.parts.bodies import rigid_body
from billow.parts.bodies.bodies import Bodies
from billow.parts.bodies.contact import Nodes
from billow.run.simulate import simulate

SIDES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
STEP = 2e-6


def cells(faces) -> np.ndarray:
    return np.array([[*face, -1][:4] for face in faces], np.int64)


def box_points(half) -> np.ndarray:
    return np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) * np.asarray(half, float)


def saved(path, points, faces):
    faces = cells(faces)
    write_mesh(path, CellMesh(np.asarray(points, float), faces, np.ones(len(faces), np.int64), {}))
    return str(path)


def body_of(path, points, faces, **table):
    table = {"shape": "mesh", "file": saved(path, points, faces), **table}
    return build_body(OBSTACLES[table["shape"]].model_validate(table))


def ball(fineness, radius=0.1):
    points, triangles = sphere(fineness)
    return radius * points, triangles


@pytest.mark.parametrize("fineness", [2, 3, 4])
def test_the_mesh_of_a_ball_is_the_ball_but_for_its_facets(fineness):
    """Its surface lies between the ball and the ball that its facets touch; that gap falls by four with each
    refinement."""
    mesh = Mesh(*ball(fineness))
    corners = mesh.points[mesh.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    gap = 0.1 - np.min(np.sum(normal * corners[:, 0], axis=1) / np.linalg.norm(normal, axis=1))
    assert gap == pytest.approx(0.1 * 0.019 / 4.0 ** (fineness - 2), rel=0.1)
    points = np.random.default_rng(1).uniform(-0.13, 0.13, (300, 3))
    distance, normal = mesh.distance(points)
    away = np.linalg.norm(points, axis=1)
    assert (distance - (away - 0.1)).min() > -1e-12
    assert (distance - (away - 0.1)).max() < gap + 1e-12
    near = np.abs(away - 0.1) < 0.02
    assert (np.einsum("ij,ij->i", normal, points)[near] / away[near]).min() > np.cos(0.35 / 2.0 ** (fineness - 1))


def test_the_mesh_of_a_box_has_its_exact_distance():
    half = np.array([0.1, 0.06, 0.03])
    faces = np.array([t for a, b, c, d in SIDES for t in ([a, b, c], [a, c, d])])
    mesh, exact = Mesh(box_points(half), faces), Box(half, 1e-12)
    points = np.random.default_rng(2).uniform(-0.13, 0.13, (500, 3))
    (d, n), (e, m) = mesh.distance(points), exact.distance(points)
    np.testing.assert_allclose(d, e, atol=1e-11)
    np.testing.assert_allclose(n[d > 0], m[d > 0], atol=1e-9)
    assert mesh.volume() == pytest.approx(8 * np.prod(half), rel=1e-12)
    np.testing.assert_allclose(mesh.inertia(3.0), exact.inertia(3.0), rtol=1e-12)
    assert mesh.numbers[3] == 10.0  # it meets others as the boxiest there is
    assert Mesh(*ball(3)).numbers[3] == pytest.approx(2.0)


def test_a_concave_solid_knows_its_inside():
    """An L of two boxes: pseudonormals tell the side at edges, where normals of faces disagree."""
    x = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]) * 0.05
    points = np.concatenate([np.column_stack([x, np.full(6, z)]) for z in (0.0, 0.05)])
    top = [[6, 7, 8], [6, 8, 9], [6, 9, 10], [6, 10, 11]]
    faces = [f[::-1] for f in (np.array(top) - 6).tolist()] + top
    faces += [t for k in range(6) for t in ([k, (k + 1) % 6, (k + 1) % 6 + 6], [k, (k + 1) % 6 + 6, k + 6])]
    mesh = Mesh(points, np.array(faces))
    tries = np.random.default_rng(3).uniform(-0.02, 0.12, (4000, 3))
    a, b, c = tries.T
    inside = (c > 0) & (c < 0.05) & (a > 0) & (b > 0) & (((a < 0.1) & (b < 0.05)) | ((a < 0.05) & (b < 0.1)))
    assert np.array_equal(mesh.distance(tries)[0] < 0.0, inside)
    assert mesh.volume() == pytest.approx(3 * 0.05**3)


def test_what_was_seen_before_changes_no_bit():
    """The closest triangle of last time, and how far a node was, only save searching."""
    mesh, rng = Mesh(*ball(3)), np.random.default_rng(4)
    points, still, pose = rng.uniform(-0.13, 0.13, (400, 3)), np.zeros(9), np.eye(3).ravel()
    seen = mesh.nothing_seen(len(points))
    for _ in range(5):
        points += rng.normal(scale=1e-3, size=points.shape)
        kept, fresh = np.empty((400, 4)), np.empty((400, 4))
        mesh.look(points, still, still[:3], pose, 0.01, seen, kept)
        mesh.look(points, still, still[:3], pose, 0.01, mesh.nothing_seen(len(points)), fresh)
        near = fresh[:, 0] > -np.inf
        assert 0 < near.sum() < len(points)
        assert np.array_equal(kept[:, 0], fresh[:, 0])
        assert np.array_equal(kept[near], fresh[near])


@pytest.mark.parametrize("thickness", [0.0, 0.01])
def test_mass_properties_are_exact(thickness):
    """Of a box moved and turned, as a solid and as a shell; closed forms."""
    half, turn = np.array([0.1, 0.06, 0.03]), rotation_matrix(quaternion_about(np.array([0.6, 0.0, 0.8]), 0.7))
    faces = np.array([t for a, b, c, d in SIDES for t in ([a, b, c], [a, c, d])])
    amount, centre, tensor = mass_properties(box_points(half) @ turn.T + [1.0, 2.0, 3.0], faces, bool(thickness))
    a, b, c = 2 * half
    squares = half**2
    if thickness:  # of each pair of sides: in the plane h^2/3, across it h^2
        areas = 2 * np.array([b * c, c * a, a * b])
        second = [sum(areas[j] * squares[i] * (1.0 if i == j else 1.0 / 3.0) for j in range(3)) for i in range(3)]
        second = np.array(second) / areas.sum()
        assert amount == pytest.approx(areas.sum())
    else:
        second = squares / 3.0
        assert amount == pytest.approx(a * b * c)
    np.testing.assert_allclose(centre, [1.0, 2.0, 3.0], rtol=1e-12)
    np.testing.assert_allclose(tensor, turn @ np.diag(second.sum() - second) @ turn.T, atol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 0.5, 2.0, 3.1, np.pi])
def test_quaternions_of_rotations(angle):
    for axis in np.eye(3):
        q = times(quaternion_about(axis, angle), quaternion_about(np.array([0.6, 0.8, 0.0]), 0.3))
        np.testing.assert_allclose(rotation_matrix(quaternion_of(rotation_matrix(q))), rotation_matrix(q), atol=1e-12)


def fly(body, positions, velocities, steps, in_sweeps=False, mass=3e-5):
    """Nodes that fly at a body: energy [J], momentum and angular momentum about the origin of all, start and end."""
    nodes = len(positions)
    part = Bodies((body,), np.full(nodes, 1e-4), np.zeros(3))
    state, inverse = part.start(), np.full(nodes, 1.0 / mass)
    told, force = [], np.zeros(3)
    for k in range(steps + 1):
        motion = state.motion[0]
        turning = motion.angular_momentum + body.rigid.mass * np.cross(motion.centre, motion.velocity)
        flying = 0.5 * mass * np.sum(velocities**2) + state.contact.stored.sum()
        told.append((
            flying + rigid_body.kinetic_energy(body.rigid, motion),
            mass * velocities.sum(axis=0) + body.rigid.mass * motion.velocity,
            mass * np.cross(positions, velocities).sum(axis=0) + turning,
        ))  # fmt: skip
        if k == steps:
            break
        room = Nodes(inverse, np.zeros_like(positions), positions, velocities, np.empty_like(positions))
        if in_sweeps:
            rows = part.rows(state, room, STEP)
            part.drift(state, rows)
        else:
            part.kick_touch_drift(state, room, STEP)
        velocities += (0.5 * STEP * inverse)[:, None] * state.contact.force.sum(axis=0)
        force += STEP * state.motion[0].force
        part.move(state, STEP)
    return told, force, state


def cloud(count=60):
    rng = np.random.default_rng(5)
    way = rng.normal(size=(count, 3))
    start = 0.12 * way / np.linalg.norm(way, axis=1)[:, None]
    return start, -start / 0.12 * 30.0 + rng.normal(scale=5.0, size=(count, 3))


@pytest.mark.parametrize("in_sweeps", [False, True], ids=["one pass", "sweeps"])
def test_a_free_mesh_keeps_momentum_angular_momentum_and_energy(tmp_path, in_sweeps):
    points, triangles = ball(3)
    body = body_of(
        tmp_path / "a.vtkhdf", points, triangles, locked=False, mass=0.05, friction=0.0, damping=0.0, slope=1e4
    )
    start, speeds = cloud()
    told, _, _ = fly(body, start.copy(), speeds.copy(), 2000, in_sweeps)
    (energy, momentum, turning), (energy_2, momentum_2, turning_2) = told[0], told[-1]
    np.testing.assert_allclose(momentum_2, momentum, atol=1e-13)
    np.testing.assert_allclose(turning_2, turning, atol=2e-5 * np.abs(turning).max() + 1e-6)
    assert energy_2 == pytest.approx(energy, rel=2e-3)


def test_the_contact_of_a_ball_as_a_mesh_is_that_of_the_ball(tmp_path):
    """Impulses on both, from the same cloud; the facets turn normals by up to 0.04 and lie 0.03 mm in."""
    whole = {"shape": "super-ellipsoid", "radii": 0.1, "clearance": -0.1, "friction": 0.0, "damping": 0.0, "slope": 1e4}
    exact = build_body(OBSTACLES["super-ellipsoid"].model_validate(whole))
    impulses = []
    for fineness in (2, 3, 4, None):
        body = exact
        if fineness is not None:
            table = {key: whole[key] for key in ("friction", "damping", "slope")}
            body = body_of(tmp_path / f"{fineness}.vtkhdf", *ball(fineness), **table)
        impulses.append(fly(body, *cloud(), 2000)[1])
    *meshes, exactly = impulses
    off = [np.linalg.norm(impulse - exactly) / np.linalg.norm(exactly) for impulse in meshes]
    assert off[2] < 0.02
    assert off[2] < off[0]


def test_a_sheet_is_touched_on_both_sides(tmp_path):
    square = [[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]]
    body = body_of(tmp_path / "a.stl.vtkhdf", square, [[0, 1, 2, 3]], thickness=0.01, density=1000.0, locked=False)
    assert body.rigid.mass == pytest.approx(0.04 * 0.01 * 1000.0)
    assert np.sort(body.rigid.inertia) == pytest.approx(0.4 * np.array([0.04, 0.04, 0.08]) / 12)
    points = np.array([[0.0, 0.0, 0.02], [0.03, 0.02, -0.02], [0.12, 0.0, 0.0]])
    np.testing.assert_allclose(body.distance(points)[0], [0.015, 0.015, 0.015], atol=1e-12)


def test_a_spinning_top_precesses_as_euler_says(tmp_path):
    """Torque-free, two equal moments: the axis goes round the angular momentum at L / I1, whatever the axes of the
    file."""
    half, turn = np.array([0.05, 0.05, 0.12]), rotation_matrix(quaternion_about(np.array([0.0, 0.6, 0.8]), 1.1))
    spin = turn @ np.array([30.0, 0.0, 60.0])
    points = box_points(half) @ turn.T + [0.3, 0.1, 0.2]
    body = body_of(tmp_path / "a.vtkhdf", points, SIDES, locked=False, mass=2.0, spin=spin.tolist())
    exact = 2.0 * np.array([0.05**2 + 0.12**2, 0.05**2 + 0.12**2, 2 * 0.05**2]) / 3.0
    np.testing.assert_allclose(np.sort(body.rigid.inertia), np.sort(exact), rtol=1e-12)
    momentum = turn @ (exact * np.array([30.0, 0.0, 60.0]))
    state = Bodies((body,), np.empty(0), np.zeros(3)).start().motion[0]
    np.testing.assert_allclose(state.centre, [0.3, 0.1, 0.2], atol=1e-15)
    np.testing.assert_allclose(state.angular_momentum, momentum, rtol=1e-12)
    axis, end, energy = turn[:, 2], 0.05, rigid_body.kinetic_energy(body.rigid, state)
    first = state.rotation.T @ axis
    for _ in range(5000):
        rigid_body.advance(body.rigid, state, np.zeros(3), end / 5000)
    size = np.linalg.norm(momentum)
    goes = rotation_matrix(quaternion_about(momentum / size, end * size / exact[0])) @ axis
    np.testing.assert_allclose(state.rotation @ first, goes, atol=1e-6)
    assert rigid_body.kinetic_energy(body.rigid, state) == pytest.approx(energy, rel=1e-9)


def test_mass_centre_and_inertia_may_be_given(tmp_path):
    file = saved(tmp_path / "a.vtkhdf", box_points([0.1, 0.1, 0.1]), SIDES)
    table = {"shape": "mesh", "file": file, "locked": False, "mass": 3.0, "centre": [0.02, 0.0, 0.0],
             "inertia": [0.02, 0.03, 0.04, 0.005, 0.0, 0.0], "place": [1.0, 0.0, 0.0], "turn": 90.0}  # fmt: skip
    body = build_body(OBSTACLES["mesh"].model_validate(table))
    np.testing.assert_allclose(body.start.centre, [1.0, 0.02, 0.0], atol=1e-12)
    tensor = np.array([[0.02, 0.005, 0.0], [0.005, 0.03, 0.0], [0.0, 0.0, 0.04]])
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    rotation = body.start.rotation
    np.testing.assert_allclose(rotation @ np.diag(body.rigid.inertia) @ rotation.T, turn @ tensor @ turn.T, atol=1e-15)
    with pytest.raises(InputError, match="E-GEO-152"):
        build_body(OBSTACLES["mesh"].model_validate({**table, "inertia": [0.02, 0.03, 0.06, 0, 0, 0]}))


def test_a_run_with_a_mesh_goes_on_in_the_same_bits_and_carries_its_file(small_case, in_two, tmp_path):
    points, triangles = ball(2, 0.08)
    head = {"shape": "mesh", "name": "head", "file": saved(tmp_path / "head.vtkhdf", points, triangles),
            "place": [0.02, 0.0, 0.13], "locked": False, "mass": 1.0, "velocity": [0.0, 0.0, -5.0]}  # fmt: skip
    case = Case.from_dict({**small_case.to_dict(), "obstacles": [head]}).vary({"run.end_time": 0.02})
    require_start_clear(build_model(case))
    straight = simulate(case, tmp_path / "straight", threads=1)
    assert fingerprint(in_two(case, tmp_path / "resumed").folder) == fingerprint(straight.folder)
    assert (straight.folder / "obstacles_head.vtkhdf").is_file()
    assert Case.load(straight.folder / "case.toml").digest() == case.digest()
    force = straight.histories.of("head").force
    assert np.abs(force).max() > 10.0
    (told,) = straight.record["obstacles"]
    assert len(told["triangles"]) == len(triangles)
    energy = next(c for c in straight.record["quality"]["criteria"] if c["name"].startswith("energy residual"))
    assert energy["verdict"] == "PASS", energy


def test_a_sharp_solid_knows_its_inside():
    """Before an acute edge the normals of its faces disagree about the side; their weighted sum does not."""
    points = np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.01, 0.01, 0.1]])
    mesh = Mesh(points, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    tries = np.random.default_rng(8).uniform([-0.03, -0.03, -0.03], [0.07, 0.07, 0.14], (4000, 3))
    shares = np.linalg.solve(np.vstack([points.T, np.ones(4)]), np.vstack([tries.T, np.ones(len(tries))]))
    assert np.array_equal(mesh.distance(tries)[0] < 0.0, (shares > 0.0).all(axis=0))
