"""The audit agrees with the winding number, and who was lost is inside again."""

from __future__ import annotations

import numpy as np
import pytest
from flights import box, flock_of, winding
from test_flight_leaks import flat_round, sliver, zigzag

from billow.gas.corpuscular.audit import find_escaped, push_back
from billow.gas.corpuscular.walls import Walls
from billow.geometry.search_grid import SearchGrid


def bag_walls(triangles):
    return Walls.build(triangles, np.zeros(len(triangles)), np.full(len(triangles), -1))


@pytest.mark.parametrize("shape", [flat_round, zigzag, sliver])
def test_audit_finds_exactly_those_outside(shape):
    rng = np.random.default_rng(4)
    triangles, positions = shape(rng)
    reach = 0.05 * np.ptp(positions, axis=0).max()
    low, high = positions.min(axis=0) - reach, positions.max(axis=0) + reach
    near = positions[triangles].mean(axis=1)
    points = np.concatenate([rng.uniform(low, high, (800, 3)), near + rng.normal(0.0, 0.002, near.shape)])
    flock = flock_of(points, np.ones_like(points))
    walls, grid = bag_walls(triangles), SearchGrid.build(triangles, positions, positions)
    escaped = find_escaped(flock, walls, grid, positions)
    outside = np.flatnonzero(winding(points, triangles, positions) < 0.5)
    assert 0 < len(outside) < len(points)
    assert np.array_equal(escaped, outside)
    push_back(flock, escaped, walls, grid, positions)
    assert (winding(flock.position, triangles, positions) > 0.5).all()
    assert (flock.velocity == 1.0).all()
    kept = np.setdiff1d(np.arange(len(points)), outside)
    assert np.array_equal(flock.position[kept], points[kept])


def test_a_particle_in_the_wrong_room_is_found_and_brought_home():
    triangles, positions, behind, ahead = box(rooms=2)
    rng = np.random.default_rng(6)
    flock = flock_of(rng.uniform([0.01, 0.01, 0.01], [1.99, 0.99, 0.99], (500, 3)), np.zeros((500, 3)))
    flock.chamber[:] = rng.integers(0, 2, 500)
    walls, grid = Walls.build(triangles, behind, ahead), SearchGrid.build(triangles, positions, positions)
    wrong = np.flatnonzero((flock.position[:, 0] > 1.0) != flock.chamber)
    assert np.array_equal(find_escaped(flock, walls, grid, positions), wrong)
    push_back(flock, wrong, walls, grid, positions)
    assert ((flock.position[:, 0] > 1.0) == flock.chamber).all()


def test_rounding_at_the_wall_is_no_escape_and_nan_is():
    triangles, positions, _, _ = box()
    flock = flock_of([[0.3, 0.4, 1.0 + 1e-9], [0.3, 0.4, 1.0 + 1e-5], [0.3, np.nan, 0.5]], np.zeros((3, 3)))
    grid = SearchGrid.build(triangles, positions, positions)
    assert find_escaped(flock, bag_walls(triangles), grid, positions).tolist() == [1, 2]
    flock.chamber[:] = -1  # who has left through a vent is not looked for
    assert len(find_escaped(flock, bag_walls(triangles), grid, positions)) == 0
