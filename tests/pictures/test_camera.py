"""Where places in space come to lie in a picture."""

import numpy as np
import pytest

from billow.pictures.camera import MARGIN, VIEWS, Camera, axes_of

CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@pytest.mark.parametrize("view", VIEWS)
def test_axes_are_right_handed_and_of_length_one(view):
    axes = axes_of(view)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(np.cross(axes[0], axes[1]), axes[2], atol=1e-15)


@pytest.mark.parametrize(
    ("view", "right", "up"),
    [("front", 0, 2), ("side", 1, 2), ("top", 0, 1)],
)
def test_views_along_the_axes_show_what_their_names_say(view, right, up):
    expected = np.stack([np.eye(3)[right], np.eye(3)[up]])
    np.testing.assert_allclose(axes_of(view)[:2], expected, atol=1e-15)


def test_from_above_and_below_left_and_right_are_the_same_and_depth_is_turned():
    np.testing.assert_allclose(axes_of("top")[0], axes_of("below")[0], atol=1e-15)
    np.testing.assert_allclose(axes_of("top")[2], -axes_of("below")[2], atol=1e-15)


@pytest.mark.parametrize("view", VIEWS)
def test_everything_is_in_the_picture_and_touches_its_margin(view):
    camera = Camera.around([CUBE + 5.0, 0.1 * CUBE + [5.0, 5.0, 9.0]], view, 400, 300)
    x, y, _ = camera.project(np.concatenate([CUBE + 5.0, 0.1 * CUBE + [5.0, 5.0, 9.0]])).T
    assert x.min() >= 400 * MARGIN - 1e-9
    assert x.max() <= 400 * (1 - MARGIN) + 1e-9
    assert y.min() >= 300 * MARGIN - 1e-9
    assert y.max() <= 300 * (1 - MARGIN) + 1e-9
    assert np.isclose(np.ptp(x), 400 * (1 - 2 * MARGIN)) or np.isclose(np.ptp(y), 300 * (1 - 2 * MARGIN))


@pytest.mark.parametrize("view", VIEWS)
def test_lengths_across_the_view_are_the_scale_times_the_length(view):
    camera = Camera.around([CUBE], view, 640, 480)
    start = np.array([[0.3, -0.2, 0.1]])
    for axis, (dx, dy) in zip(axes_of(view)[:2], ((1.0, 0.0), (0.0, -1.0)), strict=True):
        moved = camera.project(start + 0.25 * axis) - camera.project(start)
        np.testing.assert_allclose(moved[0], 0.25 * camera.scale * np.array([dx, dy, 0.0]), atol=1e-9)


def test_the_nearer_of_two_places_has_the_larger_depth():
    camera = Camera.around([CUBE], "front", 100, 100)
    near, far = camera.project(np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]))
    np.testing.assert_allclose(near[:2], far[:2])
    assert near[2] > far[2]


def test_more_samples_show_the_same_in_more_pixels():
    camera = Camera.around([CUBE], "iso", 100, 80)
    np.testing.assert_allclose(camera.larger(3).project(CUBE), 3.0 * camera.project(CUBE))


def test_a_single_point_and_a_flat_bag_can_be_seen():
    assert np.isfinite(Camera.around([np.zeros((1, 3))], "iso", 100, 100).project(np.zeros((1, 3)))).all()
    flat = CUBE * [1.0, 1.0, 0.0]
    assert np.isfinite(Camera.around([flat], "front", 100, 100).project(flat)).all()
