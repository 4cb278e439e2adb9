"""Sections of meshes, and the texts that name planes."""

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.geometry.shapes.triangulated import sphere
from billow.pictures.scene import Plane
from billow.pictures.section import across, cut, parse_plane


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("offset", [-0.4, 0.0, 0.7])
def test_a_sphere_is_cut_in_a_circle(axis, offset):
    points, triangles = sphere(5)
    segments, _ = cut(points, triangles, Plane(np.eye(3)[axis], offset))
    np.testing.assert_allclose(segments[..., axis], offset, atol=1e-12)
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum()
    assert length == pytest.approx(2.0 * np.pi * np.sqrt(1.0 - offset**2), rel=2e-3)


def test_a_closed_surface_gives_closed_loops_even_through_its_nodes():
    points, triangles = sphere(3)
    assert (points[:, 1] == 0.0).any()
    segments, _ = cut(points, triangles, Plane(np.array([0.0, 1.0, 0.0]), 0.0))
    ends, counts = np.unique(segments.reshape(-1, 3).round(12), axis=0, return_counts=True)
    assert len(ends)
    assert (counts % 2 == 0).all()


def test_each_segment_says_its_triangle():
    points, triangles = sphere(2)
    plane = Plane(np.array([0.0, 0.0, 1.0]), 0.1)
    segments, which = cut(points, triangles, plane)
    for segment, t in zip(segments, which, strict=True):
        corners = points[triangles[t]]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        np.testing.assert_allclose((segment - corners[0]) @ normal, 0.0, atol=1e-12)


def test_a_plane_beside_the_mesh_cuts_nothing():
    points, triangles = sphere(2)
    assert len(cut(points, triangles, Plane(np.array([1.0, 0.0, 0.0]), 2.0))[0]) == 0


@pytest.mark.parametrize(
    ("text", "axis", "offset"),
    [("y=0", 1, 0.0), (" z = 120 mm", 2, 0.12), ("x=-0.05", 0, -0.05)],
)
def test_planes_are_named_by_axis_and_place(text, axis, offset):
    plane = parse_plane(text)
    np.testing.assert_array_equal(plane.normal, np.eye(3)[axis])
    assert plane.offset == pytest.approx(offset)


@pytest.mark.parametrize("text", ["", "q=0", "y", "y=", "y=a", "y=0 kg", "y=0=0", "y=nan", "y=1e999"])
def test_what_names_no_plane_is_refused(text):
    with pytest.raises(InputError, match="E-PIC-001"):
        parse_plane(text)


def test_the_side_towards_the_viewer_is_left_away():
    plane = Plane(np.array([0.0, 1.0, 0.0]), 0.2)
    for towards in ([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]):
        facing = plane.facing(np.array(towards))
        viewer = 10.0 * np.array([towards])
        assert facing.kept(viewer)[0] < 0.0
        np.testing.assert_allclose(facing.kept(np.array([[3.0, 0.2, 1.0]])), 0.0, atol=1e-15)


def test_sections_show_the_two_other_axes():
    assert [across(Plane(np.eye(3)[k], 0.0)) for k in range(3)] == [(1, 2), (0, 2), (0, 1)]
