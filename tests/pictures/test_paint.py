"""Painted scenes: who is before whom, what is covered, and that colours can be read off a colour bar."""

import numpy as np
import pytest

from billow.geometry.shapes.triangulated import sphere
from billow.pictures.camera import Camera
from billow.pictures.light import paint
from billow.pictures.scene import Body, Plane, Scene, corner_normals, tubes

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def ball(centre, radius, colour, fill=None, cut=True):
    points, triangles = sphere(4)
    colours = np.tile(np.asarray(colour, float), (len(triangles), 3, 1))
    return Body(radius * points + centre, triangles, colours, np.zeros(len(triangles), int), fill, cut)


def look(bodies, view="front", plane=None, side=160):
    camera = Camera.around([body.points for body in bodies], view, side, side)
    plane = None if plane is None else plane.facing(camera.axes[2])
    return camera, paint(Scene.of(bodies, plane), camera)


def at(camera, picture, place):
    x, y, _ = camera.project(np.array([place]))[0]
    return picture[int(y), int(x)]


@pytest.mark.parametrize(("view", "seen"), [("front", RED), ("side", GREEN)])
def test_the_nearer_ball_hides_the_other(view, seen):
    """The red ball is nearer from the front, -y, the green one from the side, +x."""
    bodies = [ball([0.0, -2.0, 0.0], 0.5, RED), ball([0.0, 0.0, 0.0], 0.5, GREEN)]
    if view == "side":
        bodies = [ball([-2.0, 0.0, 0.0], 0.5, RED), ball([0.0, 0.0, 0.0], 0.5, GREEN)]
    for order in (bodies, bodies[::-1]):
        camera, picture = look(order, view)
        colour = at(camera, picture, [0.0, 0.0, 0.0])[:3]
        assert colour.argmax() == np.argmax(seen)
        assert np.sort(colour)[1] < 0.3 * colour.max()


def test_covered_shares_add_up_to_the_area_of_the_ball():
    camera, picture = look([ball([1.0, 2.0, 3.0], 0.4, RED)])
    assert picture[..., 3].sum() == pytest.approx(np.pi * (0.4 * camera.scale) ** 2, rel=3e-3)
    partial = (picture[..., 3] > 0.0) & (picture[..., 3] < 1.0)
    assert 0 < partial.sum() < 800  # its outline is smooth


def test_light_comes_from_above_and_leaves_hue_as_it_is():
    camera, picture = look([ball([0.0, 0.0, 0.0], 1.0, (0.2, 0.4, 0.8))])
    above, below = at(camera, picture, [0.0, -0.8, 0.55]), at(camera, picture, [0.0, -0.8, -0.55])
    assert above[:3].sum() > 1.1 * below[:3].sum()
    np.testing.assert_allclose(below[:3] / below[2], [0.25, 0.5, 1.0], atol=0.02)


def test_the_same_scene_gives_the_same_bits():
    bodies = [ball([0.0, 0.0, 0.0], 1.0, RED), ball([0.3, -0.4, 0.2], 0.9, GREEN)]
    np.testing.assert_array_equal(look(bodies)[1], look(bodies)[1])


def test_where_pieces_of_a_body_meet_there_is_an_edge():
    points, triangles = sphere(4)
    upper = (points[triangles].mean(axis=1)[:, 2] > 0.0).astype(int)
    colours = np.ones((len(triangles), 3, 3))
    whole, halves = (Body(points, triangles, colours, patch) for patch in (0 * upper, upper))
    _, smooth = look([whole])
    _, parted = look([halves])
    column = slice(60, 100)
    dark = smooth[column, 80, 0] - parted[column, 80, 0]
    assert dark.max() > 0.1
    assert abs(int(dark.argmax()) + 60 - 80) <= 3


def test_a_plane_opens_a_shell_and_fills_a_solid():
    front = Plane(np.array([0.0, 1.0, 0.0]), 0.0)
    camera, shell = look([ball([0.0, 0.0, 0.0], 1.0, RED)], plane=front)
    _, solid = look([ball([0.0, 0.0, 0.0], 1.0, RED, fill=GREEN)], plane=front)
    _, whole = look([ball([0.0, 0.0, 0.0], 1.0, RED, fill=GREEN, cut=False)], plane=front)
    assert at(camera, shell, [0.0, 0.0, 0.0])[:3].argmax() == 0
    np.testing.assert_allclose(at(camera, solid, [0.0, 0.0, 0.0])[:3], GREEN, atol=1e-6)
    assert at(camera, whole, [0.0, 0.0, 0.0])[:3].argmax() == 0


def test_normals_are_smooth_within_a_patch_and_break_at_its_border():
    points, triangles = sphere(3)
    normals = corner_normals(points, triangles, np.zeros(len(triangles), int))
    assert np.einsum("tci,tci->tc", normals, points[triangles]).min() > 0.995
    flat = corner_normals(points, triangles, np.arange(len(triangles)))
    np.testing.assert_allclose(flat[:, 0], flat[:, 1], atol=1e-12)
    corners = points[triangles]
    np.testing.assert_allclose(np.einsum("ti,ti->t", flat[:, 0], corners[:, 1] - corners[:, 0]), 0.0, atol=1e-12)


def test_a_tube_has_its_length_and_width_and_one_without_length_is_left_out():
    body = tubes(np.array([[0.0, 0, 0], [5, 5, 5]]), np.array([[0.0, 0, 2], [5, 5, 5]]), 0.1, RED)
    assert np.ptp(body.points[:, 2]) == pytest.approx(2.0)
    np.testing.assert_allclose(np.linalg.norm(body.points[:, :2], axis=1), 0.1)
    corners = body.points[body.triangles]
    outwards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ti,ti->t", outwards[:, :2], corners.mean(axis=1)[:, :2]) > 0.0).all()
