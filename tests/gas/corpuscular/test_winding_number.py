"""The audit agrees with solid angles, flight counts what the audit counts, and escaped particles come back inside."""

from __future__ import annotations

import numpy as np
import pytest
from flights import Scene, box, enclosure, flock_of, inside_points, winding
from test_flight_leaks import flat_round, sliver, zigzag

from billow.geometry.bag_shapes import round_bag
from billow.parts.gas.corpuscular.flight import UNCOUNTED
from billow.parts.gas.corpuscular.winding_number import audit, bring_back, recheck_parked, winding_numbers


@pytest.mark.parametrize("shape", [flat_round, zigzag, sliver])
def test_the_audit_finds_exactly_the_particles_outside(shape):
    rng = np.random.default_rng(4)
    triangles, positions = shape(rng)
    reach = 0.05 * np.ptp(positions, axis=0).max()
    low, high = positions.min(axis=0) - reach, positions.max(axis=0) + reach
    near = positions[triangles].mean(axis=1)
    points = np.concatenate([rng.uniform(low, high, (800, 3)), near + rng.normal(0.0, 0.002, near.shape)])
    flock = flock_of(points, np.ones_like(points))
    escaped = audit(flock, enclosure(triangles, positions))
    outside = np.flatnonzero(winding(points, triangles, positions) < 0.5)
    assert 0 < len(outside) < len(points)
    assert np.array_equal(escaped, outside)
    bring_back(flock, escaped)
    assert (winding(flock.position, triangles, positions) > 0.5).all()
    assert (flock.velocity == 1.0).all()
    kept = np.setdiff1d(np.arange(len(points)), outside)
    assert np.array_equal(flock.position[kept], points[kept])


def test_a_particle_in_the_wrong_chamber_is_found_and_brought_back():
    triangles, positions, behind, ahead = box(rooms=2)
    rng = np.random.default_rng(6)
    flock = flock_of(rng.uniform([0.01, 0.01, 0.01], [1.99, 0.99, 0.99], (500, 3)), np.zeros((500, 3)))
    flock.chamber[:] = rng.integers(0, 2, 500)
    wrong = np.flatnonzero((flock.position[:, 0] > 1.0) != flock.chamber)
    assert np.array_equal(audit(flock, enclosure(triangles, positions, behind, ahead)), wrong)
    bring_back(flock, wrong)
    assert ((flock.position[:, 0] > 1.0) == flock.chamber).all()


def test_rays_through_nodes_and_edges_count_once():
    """In a box that stands along the axes every ray from a node's height meets nodes and edges."""
    triangles, positions, behind, ahead = box()
    places = np.arange(-1, 6) / 4.0
    x, y = (a.ravel() for a in np.meshgrid(places, places))
    points = np.column_stack([x, y, np.full(len(x), 0.5)])
    inside = (points[:, :2] > 0.0).all(axis=1) & (points[:, :2] < 1.0).all(axis=1)
    outside = (points[:, :2] < 0.0).any(axis=1) | (points[:, :2] > 1.0).any(axis=1)
    for turn in range(3):  # the ray runs along each axis in turn
        turned = np.roll(positions * [1.0, 1.0, 1.0 - 1e-9], turn, axis=1)
        bag = enclosure(triangles, turned, behind, ahead)
        deep = winding_numbers(np.roll(points, turn, axis=1), np.zeros(len(x)), bag)
        assert (deep[inside] == 1).all()
        assert (deep[outside] == 0).all()


def test_a_particle_without_a_position_has_escaped_and_one_that_left_has_not():
    triangles, positions, behind, ahead = box()
    flock = flock_of([[0.3, 0.4, 1.0 - 1e-12], [0.3, 0.4, 1.0 + 1e-12], [0.3, np.nan, 0.5]], np.zeros((3, 3)))
    assert audit(flock, enclosure(triangles, positions, behind, ahead)).tolist() == [1, 2]
    flock.chamber[:] = -1
    assert len(audit(flock, enclosure(triangles, positions, behind, ahead))) == 0


def test_no_particle_moves_if_its_whole_chamber_has_escaped():
    triangles, positions, behind, ahead = box()
    flock = flock_of([[2.0, 2.0, 2.0]], np.zeros((1, 3)))
    bring_back(flock, audit(flock, enclosure(triangles, positions, behind, ahead)))
    assert flock.position.tolist() == [[2.0, 2.0, 2.0]]


def bent_through_itself(turn):
    """A round bag bent about y until its ends lie in each other for turn > 1."""
    bag = round_bag(0.35, 8, 0.1)
    x, y, z = bag.positions.T
    angle = np.pi * turn * x / 0.35
    radius = 0.35 / (np.pi * turn) + z
    return bag.surface.triangles, np.column_stack([radius * np.sin(angle), y, radius * np.cos(angle)])


@pytest.mark.parametrize("dt", [5e-5, 3e-4])
def test_a_bag_that_intersects_itself_is_no_valve(dt):
    """Ends of a bag pass into each other and out again: no particle leaves, and each has the right overlap at all
    times, also on paths as long as three edges of the mesh."""
    rng = np.random.default_rng(8)
    turns = np.concatenate([np.linspace(0.9, 1.12, 40), np.full(80, 1.12), np.linspace(1.12, 0.9, 40)])
    triangles, positions = bent_through_itself(turns[0])
    points = inside_points(triangles, positions, 2000, rng, 1e-3)
    flock = flock_of(points, rng.normal(0.0, 400.0, points.shape))
    scene = Scene(triangles, positions, flock)
    deepest = 0
    for k, turn in enumerate(turns):
        scene.advance(dt, bent_through_itself(turn)[1])
        if k % 10 != 9:
            continue
        depth = np.round(winding(flock.position, triangles, scene.positions))
        deepest = max(deepest, int((depth > 1).sum()))
        assert (depth >= 1).all()
        counted = flock.overlap.copy()
        assert np.array_equal(counted, depth - 1)
        assert len(audit(flock, enclosure(triangles, scene.positions))) == 0
        assert np.array_equal(flock.overlap, counted)
    assert deepest > 10
    assert not flock.overlap.any()


def test_an_overlap_holds_its_share_of_the_gas():
    rng = np.random.default_rng(9)
    triangles, positions = bent_through_itself(1.12)
    points = inside_points(triangles, positions, 6000, rng, 1e-3)
    box_low, box_high = positions.min(axis=0), positions.max(axis=0)
    probe = np.round(winding(rng.uniform(box_low, box_high, (40_000, 3)), triangles, positions))
    share = (probe == 2).sum() / (probe >= 1).sum()
    flock = flock_of(points, rng.normal(0.0, 400.0, points.shape))
    audit(flock, enclosure(triangles, positions))
    scene = Scene(triangles, positions, flock)
    for _ in range(100):
        scene.advance(5e-5)
    inside = (flock.overlap == 1).mean()
    # Both shares are counts: three standard deviations of a binomial number each.
    spread = 3.0 * np.sqrt(share / len(points) + share / (probe >= 1).sum())
    assert share > 0.005
    assert abs(inside - share) < spread


def test_only_parked_particles_are_recounted_and_moved():
    triangles, positions = bent_through_itself(1.12)
    points = inside_points(triangles, positions, 3000, np.random.default_rng(10), 1e-3)
    depth = np.round(winding(points, triangles, positions)).astype(int)
    points[[0, 2]] += 10.0
    flock = flock_of(points, np.zeros_like(points))
    flock.overlap[:1500:2] = UNCOUNTED
    flock.overlap[1::2] = 7
    recheck_parked(flock, enclosure(triangles, positions))
    assert np.array_equal(flock.overlap[4:1500:2], depth[4:1500:2] - 1)
    assert (winding(flock.position[[0, 2]], triangles, positions) > 0.5).all()
    assert (flock.position[1] == points[1]).all()
    assert (flock.overlap[1::2] == 7).all()


def test_flight_marks_parked_particles_as_uncounted():
    """In a bag a hundredth of a millimetre thick, everybody hits a wall more often than flight follows."""
    bag = round_bag(0.35, 6, 1e-5)
    triangles = bag.surface.triangles
    points = inside_points(triangles, bag.positions, 200, np.random.default_rng(11), 4e-6)
    flock = flock_of(points, np.tile([0.0, 10.0, 400.0], (len(points), 1)))
    scene = Scene(triangles, bag.positions, flock)
    parked = scene.advance(1e-5).parked
    assert parked > 0
    assert (flock.overlap == UNCOUNTED).sum() == parked
    recheck_parked(flock, enclosure(triangles, scene.positions))
    assert not flock.overlap.any()
    assert (winding(flock.position, triangles, scene.positions) > 0.5).all()
