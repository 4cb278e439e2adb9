"""The search grid: how far its empty cells are from those with lists."""

from __future__ import annotations

import numpy as np
import pytest

from billow.geometry.search_grid import MOST_CLEAR, SearchGrid, cells_to_lists


def nearest_by_brute_force(lists, counts):
    """Of every pair of cells: steps apart along the axis along which they are furthest."""
    place = np.stack(np.unravel_index(np.arange(np.prod(counts)), counts), axis=1)
    away = np.full(len(place), MOST_CLEAR)
    for cell in place[lists]:
        away = np.minimum(away, np.abs(place - cell).max(axis=1))
    return away


@pytest.mark.parametrize("counts", [(5, 4, 3), (1, 1, 30), (20, 1, 2), (2, 19, 1), (13, 12, 11)])
@pytest.mark.parametrize("share", [0.0, 0.01, 0.2])
def test_clear_cells_are_counted_as_by_brute_force(counts, share):
    rng = np.random.default_rng(1)
    lists = rng.random(np.prod(counts)) < share
    first = np.concatenate([[0], np.cumsum(lists * rng.integers(1, 4, len(lists)))]).astype(np.int32)
    found = cells_to_lists(first, np.array(counts))
    assert found.dtype == np.uint8
    assert np.array_equal(found, nearest_by_brute_force(lists, counts))


def test_no_triangle_is_within_the_clear_cells_of_a_point():
    """What the flight rests on: a box of `clear` cells less one around a point's cell, and the margin, is empty."""
    rng = np.random.default_rng(2)
    start = rng.uniform(0.0, 1.0, (60, 1, 3)) + rng.uniform(-0.1, 0.1, (60, 3, 3))
    end = start + rng.uniform(-0.01, 0.01, start.shape)
    triangles = np.arange(180).reshape(60, 3)
    grid = SearchGrid.build(triangles, start.reshape(-1, 3), end.reshape(-1, 3))
    low, high = np.minimum(start, end).min(axis=1), np.maximum(start, end).max(axis=1)
    points = rng.uniform(-0.2, 1.2, (2000, 3))
    cells = grid.cells_of(points)
    free = grid.clear[cells].astype(float)
    assert 500 < np.count_nonzero(free) < 1900
    assert free.max() > 2
    room = ((free - 1.0) * grid.cell + grid.margin)[:, None, None]
    touched = (low - points[:, None] < room) & (points[:, None] - high < room)
    assert not touched.all(axis=2)[free > 0].any()
