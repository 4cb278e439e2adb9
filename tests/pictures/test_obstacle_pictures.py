"""Surfaces of obstacles for pictures, against their closed forms."""

from types import SimpleNamespace

import numpy as np
import pytest

from billow.geometry.shapes.box import Box
from billow.geometry.shapes.cylinder import Cylinder
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid
from billow.geometry.shapes.triangulated import reach, sphere
from billow.results.histories import History
from billow.results.obstacles import has_end, obstacles_at, outline, surface


def volume(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def test_the_sphere_is_closed_faces_outwards_and_has_its_volume():
    points, triangles = sphere(4)
    assert len(triangles) == 20 * 4**4
    edges, counts = np.unique(
        np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_counts=True
    )
    assert (counts == 2).all()
    assert len(points) - len(edges) + len(triangles) == 2
    assert volume(points, triangles) == pytest.approx(4.0 / 3.0 * np.pi, rel=3e-3)


@pytest.mark.parametrize("degree", [2.0, 3.5, 8.0])
def test_a_super_ellipsoid_has_its_volume_and_lies_on_its_surface(degree):
    shape = SuperEllipsoid(np.array([0.1, 0.2, 0.3]), degree)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    obstacle = shape.describe() | {"center": [0.5, 0.0, 1.0], "rotation": turn.tolist()}
    points, triangles = surface(obstacle)
    assert volume(points - [0.5, 0.0, 1.0], triangles) == pytest.approx(shape.volume(), rel=1e-2)
    np.testing.assert_allclose(outline(obstacle, points), 0.0, atol=1e-9)
    assert np.abs(points[:, 0] - 0.5).max() == pytest.approx(0.2, rel=5e-3)  # turned by a right angle about z


@pytest.mark.parametrize("fineness", [2, 4])
@pytest.mark.parametrize(
    "shape",
    [
        Box(np.array([0.1, 0.2, 0.3]), 0.002), Box(np.array([0.3, 0.2, 0.01]), 0.01), Cylinder(0.15, 0.2, 0.002),
        Cylinder(0.15, 0.01, 0.01), Cylinder(0.05, 0.4, 0.05),
    ],
)  # fmt: skip
def test_boxes_and_cylinders_are_closed_and_have_their_volume_and_flat_faces(shape, fineness):
    points, triangles = surface(shape.describe() | {"center": [0, 0, 0], "rotation": np.eye(3).tolist()}, fineness)
    _, counts = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_counts=True)
    assert (counts == 2).all()
    np.testing.assert_allclose(shape.distance(points)[0], 0.0, atol=1e-9)
    flat = 0.05 if fineness == 2 else 0.005  # a polygon of 16 or 64 corners in place of a circle: pi^2 2/(3 n^2)
    assert (1.0 - flat) * shape.volume() < volume(points, triangles) < shape.volume()
    assert len(triangles) < 5120


def test_the_reach_of_an_ellipsoid_along_its_axes_is_its_radii():
    shape = SuperEllipsoid(np.array([0.1, 0.2, 0.3]), 2.0)
    np.testing.assert_allclose(reach(shape, np.eye(3)), [0.1, 0.2, 0.3], rtol=1e-9)


def test_a_plate_has_no_end():
    assert not has_end(HalfSpace().describe())
    assert has_end(SuperEllipsoid(np.ones(3), 2.0).describe())


def test_a_free_obstacle_is_where_its_histories_say():
    half = np.sqrt(0.5)
    columns = {"time [s]": [0.0, 0.01]}
    columns |= {f"head_centre_{axis} [m]": [0.0, k + 1.0] for k, axis in enumerate("xyz")}
    columns |= {
        f"head_quaternion_{axis} [-]": [float(axis == "w"), q]
        for axis, q in zip("wxyz", (half, 0, 0, half), strict=True)
    }
    described = SuperEllipsoid(np.ones(3), 2.0).describe() | {
        "name": "head",
        "center": [0, 0, 0],
        "rotation": np.eye(3).tolist(),
    }
    history = History({name: np.array(values) for name, values in columns.items()})
    result = SimpleNamespace(record={"obstacles": [described | {"locked": False}]}, histories=history)
    (start,), (end,) = obstacles_at(result, 0.0), obstacles_at(result, 0.02)
    assert start["center"] == [0.0, 0.0, 0.0]
    assert end["center"] == [1.0, 2.0, 3.0]
    np.testing.assert_allclose(np.array(end["rotation"]) @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-12)
    result.record["obstacles"][0]["locked"] = True
    assert obstacles_at(result, 0.02)[0]["center"] == [0, 0, 0]
