"""Closed surfaces: volume, areas, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.geometry.bag_shapes import square_bag
from billow.geometry.surface import Surface, area_vectors, check_closed, nodal_share

BOX_POINTS = np.array([[x, y, z] for x in (0.0, 2.0) for y in (0.0, 3.0) for z in (0.0, 0.5)])
BOX = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


def surface(triangles, nodes=8, names=("bag",)):
    return Surface.build(triangles, np.zeros(len(triangles)), names, nodes)


def refusal(triangles, positions=BOX_POINTS):
    with pytest.raises(InputError) as caught:
        check_closed(surface(triangles, len(positions)), positions, "test bag")
    assert "test bag" in caught.value.where
    return caught.value


@given(
    shift=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    stretch=st.tuples(*[st.floats(0.01, 10.0)] * 3),
    order=st.permutations(range(12)),
)
def test_volume_of_a_box_wherever_it_is(shift, stretch, order):
    points = BOX_POINTS * stretch
    volume = surface(BOX[list(order)]).volume(points + shift)
    assert volume == pytest.approx(3.0 * np.prod(stretch), rel=1e-9)
    total = area_vectors(BOX, points).sum(axis=0)
    assert np.abs(total).max() <= 1e-12 * np.abs(area_vectors(BOX, points)).max()


def test_volume_is_the_slope_of_area():
    """dV/dx of each node is a third of the area vectors around it: what pressure forces rest on."""
    bag = square_bag(0.4, 6, 0.05)
    share = np.zeros_like(bag.positions)
    np.add.at(share, bag.surface.triangles.astype(int), area_vectors(bag.surface.triangles, bag.positions)[:, None] / 3)
    for node in range(0, len(share), 7):
        for axis in range(3):
            moved = [bag.positions.copy(), bag.positions.copy()]
            moved[0][node, axis] += 1e-5
            moved[1][node, axis] -= 1e-5
            slope = (bag.surface.volume(moved[0]) - bag.surface.volume(moved[1])) / 2e-5
            assert slope == pytest.approx(share[node, axis], abs=1e-10)


def test_corners_are_listed_node_by_node():
    s = surface(BOX)
    for node in range(8):
        mine = s.corners[s.corner_start[node] : s.corner_start[node + 1]]
        assert (np.diff(mine) > 0).all()
        assert (s.triangles.ravel()[mine] == node).all()
    assert s.corner_start[-1] == 36
    assert nodal_share(BOX, np.arange(12.0), 8).sum() == pytest.approx(66.0, rel=1e-15)


def test_a_box_is_a_bag():
    check_closed(surface(BOX), BOX_POINTS, "test bag")


@pytest.mark.parametrize("missing", range(12))
def test_an_open_surface_is_refused(missing):
    error = refusal(np.delete(BOX, missing, axis=0))
    assert error.code == "E-GEO-001"
    assert "3 free edges" in error.what
    assert "edge of part bag between nodes" in error.where


def test_an_unsewn_seam_is_refused():
    """Two nodes in one place are still two nodes."""
    triangles, points = BOX.copy(), np.concatenate([BOX_POINTS, BOX_POINTS[:1]])
    triangles[0, 0] = 8
    assert refusal(triangles, points).code == "E-GEO-001"


def test_a_third_wall_at_an_edge_is_refused():
    points = np.concatenate([BOX_POINTS, [[9.0, 9.0, 9.0]]])
    error = refusal(np.concatenate([BOX, [[0, 1, 8]]]), points)
    assert error.code == "E-GEO-001"
    assert "1 edges shared by more than two" in error.what


@pytest.mark.parametrize("turned", range(12))
def test_a_mirrored_triangle_is_refused(turned):
    triangles = BOX.copy()
    triangles[turned] = triangles[turned, [0, 2, 1]]
    assert refusal(triangles).code == "E-GEO-002"


def test_an_inside_out_bag_is_refused():
    assert refusal(BOX[:, [0, 2, 1]]).code == "E-GEO-003"
    assert refusal(BOX, BOX_POINTS * [1.0, 1.0, -1.0]).code == "E-GEO-003"


def two_boxes(second, shift, scale):
    """A box, and another one moved and scaled, whose triangles are given."""
    return np.concatenate([BOX, second + 8]), np.concatenate([BOX_POINTS, BOX_POINTS * scale + shift])


def test_each_closed_piece_has_outward_normals():
    triangles, points = two_boxes(BOX[:, ::-1], [5.0, 0.0, 0.0], 0.5)
    error = refusal(triangles, points)
    assert error.code == "E-GEO-003"
    assert "a closed piece of 12 triangles" in error.what
    assert "around (5.5, 0.75, 0.125) m" in error.where
    assert refusal(*two_boxes(BOX[:, ::-1], [5.0, 0.0, 0.0], 2.0)).code == "E-GEO-003"  # also the larger of two
    triangles, points = two_boxes(BOX, [5.0, 0.0, 0.0], 0.5)
    check_closed(surface(triangles, 16), points, "two bags")
    triangles, points = two_boxes(BOX[:, ::-1], [0.5, 0.5, 0.1], 0.5)
    check_closed(surface(triangles, 16), points, "a bag with a cavity")


def test_parts_are_found_by_name():
    s = Surface.build(BOX, np.repeat([0, 1], 6), ("front", "rear"), 8)
    assert s.triangles_of("rear").tolist() == [6, 7, 8, 9, 10, 11]
    assert s.triangles_of("vent").size == 0
