"""Meshes of other programs made fit: seams merged, normals turned, holes found and filled."""

from __future__ import annotations

import numpy as np
import pytest

from billow.geometry.mesh_file import CellMesh, read_mesh
from billow.geometry.mesh_repair import (
    crowded,
    filling,
    flipped,
    free_edges,
    loops,
    merged,
    pieces,
    seam_tolerance,
    to_flip,
    volumes,
)
from billow.geometry.mesh_writing import write_mesh

CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
SIDES = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]])


def volume(points, cells) -> float:
    return sum(v for v, _ in volumes(points, cells, pieces(cells, len(points))).values())


def test_a_cube_is_closed_and_has_its_volume():
    assert len(free_edges(SIDES)) == 0
    assert crowded(SIDES) is None
    assert volume(CUBE, SIDES) == pytest.approx(1.0)
    assert volume(CUBE, flipped(SIDES, np.ones(6, bool))) == pytest.approx(-1.0)


@pytest.mark.parametrize("which", range(1, 63))
def test_any_turned_sides_are_found(which):
    turned = (which >> np.arange(6)) & 1 == 1
    mixed = flipped(SIDES, turned)
    found = to_flip(mixed)
    assert found.sum() <= 3
    assert abs(volume(CUBE, flipped(mixed, found))) == pytest.approx(1.0)


def test_turning_keeps_the_first_corner_and_undoes_itself():
    cells = np.array([[4, 5, 6, -1], [1, 2, 3, 4]])
    once = flipped(cells, np.array([True, True]))
    assert once.tolist() == [[4, 6, 5, -1], [1, 4, 3, 2]]
    assert np.array_equal(flipped(once, np.array([True, True])), cells)


def test_a_moebius_strip_has_no_side():
    n = 8
    ring = np.arange(n)
    cells = np.column_stack([ring, (ring + 1) % n, (ring + 1) % n + n, ring + n])
    cells[-1] = [n - 1, n, 0, 2 * n - 1]  # the two rims change places
    with pytest.raises(ValueError, match="one side"):
        to_flip(cells)


def test_seams_are_merged_within_the_tolerance_and_nothing_else():
    own = np.arange(24).reshape(6, 4)  # every side has corners of its own
    rng = np.random.default_rng(1)
    points = CUBE[SIDES.ravel()] + 1e-5 * rng.uniform(-1, 1, (24, 3))
    assert seam_tolerance(points, own) == pytest.approx(1e-3, rel=1e-3)
    target, count = merged(points, own, seam_tolerance(points, own))
    assert count == 16
    assert len(free_edges(target[own])) == 0
    assert volume(points, target[own]) == pytest.approx(1.0, rel=1e-4)
    assert merged(points, own, 1e-7)[1] == 0
    with pytest.raises(ValueError, match="one cell"):
        merged(points, own, 1.5)


def test_an_edge_of_three_cells_is_found_with_all_of_them():
    cells = np.concatenate([SIDES, [[0, 1, 7, 6]]])
    ends, sharing = crowded(cells)
    assert sorted(ends.tolist()) in ([0, 1], [6, 7])
    assert 6 in sharing
    assert len(sharing) == 3


def test_holes_are_found_and_filled_so_that_the_bag_is_closed_again():
    rest = SIDES[1:]
    (loop,) = loops(rest)
    assert sorted(loop.tolist()) == [0, 1, 2, 3]
    more = filling(CUBE, loop)
    whole = np.concatenate([rest, np.column_stack([more, [-1, -1]])])
    assert len(free_edges(whole)) == 0
    assert not to_flip(whole).any()
    assert volume(CUBE, whole) == pytest.approx(1.0)


def test_a_star_is_filled_with_its_own_area():
    angle = 2 * np.pi * np.arange(14) / 14
    radius = np.where(np.arange(14) % 2, 0.4, 1.0)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(14)])
    for loop in (np.arange(14), np.arange(14)[::-1]):
        corners = points[filling(points, loop)]
        areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
        expected = 0.5 * (points[:, 0] @ np.roll(points[:, 1], -1) - points[:, 1] @ np.roll(points[:, 0], -1))
        assert abs(areas.sum()) == pytest.approx(expected)
        assert np.abs(areas).sum() == pytest.approx(expected)


def test_two_holes_come_longest_first_and_holes_that_touch_are_refused():
    cells = np.delete(SIDES, [0, 1], axis=0)
    found = loops(np.concatenate([cells, [[8, 9, 10, -1]]]))
    assert [len(loop) for loop in found] == [4, 4, 3]
    touching = np.array([[0, 1, 2, -1], [0, 3, 4, -1]])
    with pytest.raises(ValueError, match="two open edges"):
        loops(touching)


def test_a_mesh_that_is_written_is_read_with_the_same_bits(tmp_path):
    points = np.random.default_rng(2).normal(size=(9, 3))
    cells = np.array([[0, 1, 2, -1], [3, 4, 5, 6], [6, 7, 8, -1]])
    write_mesh(tmp_path / "a.vtkhdf", CellMesh(points, cells, np.array([7, 3, 7]), {}))
    back = read_mesh(tmp_path / "a.vtkhdf")
    assert back.points.tobytes() == points.tobytes()
    assert np.array_equal(back.cells, cells)
    assert back.part.tolist() == [7, 3, 7]
