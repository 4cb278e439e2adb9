"""Which cells share a state."""

from __future__ import annotations

import numpy as np

from billow.base.scratch import Scratch
from billow.geometry.cut_cells import neighbours
from billow.geometry.lattice_clipping import key_of
from billow.parts.gas.mesh.clusters import NOBODY, find_clusters


def in_a_row(volumes, apertures, pace=0.0, after=None, starved=NOBODY):
    """Clusters of cells along z with these volumes, and apertures between each and the next."""
    n = len(volumes)
    key = np.array([key_of(0, 0, k) for k in range(n)])
    aperture = np.zeros((n, 3))
    aperture[: n - 1, 2] = apertures
    volume = np.array([volumes, volumes if after is None else after], float)
    return find_clusters(
        key, neighbours(key), volume, aperture, np.zeros(n + 1, np.int32), np.full((n, 3), pace), np.zeros(n), 1e-3,
        Scratch(), starved,
    )  # fmt: skip


def test_full_cells_stand_alone():
    found = in_a_row([1.0, 1.0, 1.0], [1.0, 1.0], 300.0)
    assert found.of.tolist() == [0, 1, 2]
    assert found.before.tolist() == found.after.tolist() == [1.0, 1.0, 1.0]


def test_a_small_cell_joins_the_neighbour_behind_its_widest_face():
    found = in_a_row([1.0, 0.1, 0.9], [0.3, 0.8])
    assert found.of.tolist() == [1, 0, 0]  # the one that has several cells comes first
    assert found.special == 1
    assert found.members[found.start[0] : found.start[1]].tolist() == [1, 2]
    np.testing.assert_allclose(found.before, [1.0, 1.0])


def test_a_thin_layer_stays_a_layer():
    """Open sideways by no more than it is thick."""
    assert in_a_row([0.05, 0.05, 0.05], [0.05, 0.05], 300.0).of.tolist() == [0, 1, 2]


def test_cells_on_both_sides_of_a_face_that_is_inside_out_join():
    assert in_a_row([1.0, 1.0, 1.0], [-0.2, 0.5]).of.tolist() == [0, 0, 1]


def test_what_is_inside_out_finds_as_many_neighbours_as_it_takes():
    """With less room than is inside out, a little thinner gas in its other cells would leave a cluster with none."""
    found = in_a_row([1.0, -1.5, 1.0, 1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    assert found.before[0] > 1.5
    assert found.lost == 0
    assert len(found.before) > 2


def test_a_cluster_that_would_hold_no_gas_is_adopted_once():
    rooms, faces = [1.0, 0.9, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]
    assert in_a_row(rooms, faces).of.tolist() == [0, 1, 2, 3, 4]
    found = in_a_row(rooms, faces, starved=np.array([False, False, False, True, False]))
    assert sorted(np.bincount(found.of).tolist()) == [1, 1, 1, 2]
    assert found.of[3] in (found.of[2], found.of[4])


def test_neighbours_that_would_hold_no_gas_are_adopted_together_by_one_that_does():
    some = np.array([False, True, True, True, False])
    found = in_a_row([1.0, 0.6, 1.0, 0.6, 0.9], [1.0] * 4, starved=some)
    assert found.of[1] == found.of[2] == found.of[3] == found.of[0]  # the larger one beside them
    assert found.of[4] != found.of[0]


def test_a_cluster_without_room_and_without_neighbours_is_counted():
    assert in_a_row([1e-6], []).lost == 1


def test_cells_that_live_or_die_in_a_step_join_others():
    found = in_a_row([0.0, 1.0, 0.3], [0.4, 0.3], after=[0.2, 1.0, 0.0])
    assert found.of.tolist() == [0, 0, 0]
