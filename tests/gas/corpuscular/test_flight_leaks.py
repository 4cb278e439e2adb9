"""No particle leaves a closed bag: flat bags with sharp rims, folds, rolls, slivers, fast and turning walls.

Inside is decided by the winding number, which shares nothing with the flight or its audit.
"""

from __future__ import annotations

import numpy as np
import pytest
from flights import Scene, box, enclosure, flock_of, inside_points, winding
from scipy.linalg import expm

from billow.geometry.bag_shapes import round_bag, square_bag
from billow.parts.gas.corpuscular.winding_number import audit


def flat_round(rng):
    """Two discs that meet at the rim at an angle of 1e-4 to 1e-2."""
    bag = round_bag(0.35, int(rng.integers(4, 9)), 10.0 ** rng.uniform(-4.5, -2.0))
    return bag.surface.triangles, bag.positions.copy()


def flat_square(rng):
    bag = square_bag(0.7, 2 * int(rng.integers(3, 7)), 10.0 ** rng.uniform(-4.5, -2.0))
    return bag.surface.triangles, bag.positions.copy()


def zigzag(rng):
    """A flat bag of 4 mm laid in folds 60 mm wide."""
    bag = square_bag(0.7, 16, 0.004)
    x, z = bag.positions[:, 0].copy(), bag.positions[:, 2].copy()
    s = np.linspace(x.min(), x.max(), 2001)
    angle = 1.2 * np.sin(np.pi * s / 0.06)
    along = np.cumsum(np.cos(angle)) * (s[1] - s[0])
    across = np.cumsum(np.sin(angle)) * (s[1] - s[0])
    lean = np.interp(x, s, angle)
    positions = bag.positions.copy()
    positions[:, 0] = np.interp(x, s, along) - np.sin(lean) * z
    positions[:, 2] = np.interp(x, s, across) + np.cos(lean) * z
    return bag.surface.triangles, positions


def roll(rng):
    """A flat bag of 4 mm rolled up, 12 mm from turn to turn."""
    bag = square_bag(0.7, 24, 0.004)
    x, z = bag.positions[:, 0] - bag.positions[:, 0].min(), bag.positions[:, 2]
    pitch = 0.012 / (2.0 * np.pi)
    turn = (np.sqrt(0.03**2 + 2.0 * pitch * x) - 0.03) / pitch
    radius = 0.03 + pitch * turn - z
    positions = np.column_stack([radius * np.cos(turn), bag.positions[:, 1], radius * np.sin(turn)])
    return bag.surface.triangles, positions


def sliver(rng):
    """A full bag pressed to as little as a thousandth of its length."""
    bag = round_bag(0.35, 6, 0.3)
    return bag.surface.triangles, bag.positions * [10.0 ** rng.uniform(-3.0, 0.0), 1.0, 1.0]


def moving(positions, rng):
    """Turning at up to 3000 rad/s, stretching at up to 300 1/s, flying at 100 m/s: an affine map folds nothing."""
    spin = rng.normal(size=3) * rng.choice([0.0, 300.0, 3000.0])
    turn = np.array([[0.0, -spin[2], spin[1]], [spin[2], 0.0, -spin[0]], [-spin[1], spin[0], 0.0]])
    stretch = rng.normal(size=(3, 3)) * rng.choice([0.0, 50.0, 300.0])
    velocity, middle = rng.normal(size=3) * rng.choice([0.0, 100.0]), positions.mean(axis=0)

    def at(t):
        map_ = expm(turn * t) @ expm(stretch * np.sin(2000.0 * t) / 2000.0)
        return (positions - middle) @ map_.T + middle + velocity * t

    return at


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("shape", [flat_round, flat_square, zigzag, roll, sliver])
def test_no_particle_leaves_a_difficult_bag(shape, seed):
    rng = np.random.default_rng([seed, *shape.__name__.encode()])
    triangles, positions = shape(rng)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    # Some bags lie ten metres from the origin, where positions have fewer digits.
    at = moving(positions @ turn.T + rng.normal(size=3) * rng.choice([0.1, 10.0]), rng)
    dt, speed = rng.choice([1e-6, 5e-6, 2e-5]), rng.choice([50.0, 400.0, 1500.0])
    points = inside_points(triangles, at(0.0), 100, rng, 0.01)
    assert len(points) > 20
    flock = flock_of(points, rng.normal(0.0, speed, points.shape))
    scene = Scene(triangles, at(0.0), flock)
    for k in range(20):
        if k % 7 == 3:
            flock.velocity[:] = rng.normal(0.0, speed, points.shape)
        scene.advance(dt, at((k + 1) * dt))
    assert (np.abs(winding(flock.position, triangles, scene.positions) - 1.0) < 1e-6).all()
    assert len(audit(flock, enclosure(triangles, scene.positions))) == 0


def test_no_particle_leaves_a_flat_bag_that_fills():
    """2 mm over 700 mm to start with, panels moving apart at up to 10 m/s and rippling, 1 ms."""
    bag = round_bag(0.35, 12, 0.002)
    radius = np.hypot(*bag.positions[:, :2].T) / 0.35
    side = np.sign(bag.positions[:, 2])
    dome = np.sqrt(np.maximum(0.0, 1.0 - radius**2))

    def at(t):
        full = 0.5 * (1.0 - np.cos(np.pi * t / 0.02))
        ripple = 0.2 * full * np.sin(40.0 * bag.positions[:, 0] + 600.0 * t) * (1.0 - radius**2)
        positions = bag.positions * [1.0 - 0.2 * full, 1.0 - 0.2 * full, 1.0]
        positions[:, 2] += side * full * (0.2 * dome + 0.02 * ripple)
        return positions

    rng = np.random.default_rng(1)
    triangles = bag.surface.triangles
    points = inside_points(triangles, at(0.0), 500, rng, 1e-3)
    flock = flock_of(points, rng.normal(0.0, 431.0, points.shape))
    scene = Scene(triangles, at(0.0), flock)
    hits = sum(scene.advance(1e-5, at((k + 1) * 1e-5)).hits for k in range(100))
    assert hits > 100 * len(points)
    assert len(audit(flock, enclosure(triangles, scene.positions))) == 0
    assert (winding(flock.position, triangles, scene.positions) > 0.5).all()


@pytest.mark.parametrize("bulge", [(0.6, 0.0), (0.6, 0.7), (1.4, 0.3), (-0.3, -0.9)])
def test_an_opening_that_bulges_through_fabric_lets_nothing_out(bulge):
    """Two cubes side by side, the wall between them is open and hangs out through a wall of either, or both."""
    rng = np.random.default_rng(5)
    triangles, positions, behind, ahead = box(rooms=2)
    middle = np.isclose(positions[:, 0], 1.0) & (abs(positions[:, 1:] - 0.5) < 0.3).all(axis=1)
    positions[middle, :2] += bulge
    opening = (behind == 0) & (ahead == 1)
    group = np.zeros(2, np.int32)
    places, speeds = rng.uniform(0.01, 0.99, (2000, 3)) * [2.0, 1.0, 1.0], rng.normal(0.0, 300.0, (2000, 3))
    flock = flock_of(places, speeds, (places[:, 0] > 1.0).astype(np.int32))
    surroundings = enclosure(triangles, positions, behind, ahead, group)
    assert len(audit(flock, surroundings)) == 0  # and sets the chambers right, where the wall has moved over particles
    scene = Scene(triangles, positions, flock, behind, ahead, opening * 1.0, group=group)
    for _ in range(40):
        scene.advance(1e-4)
        assert ((flock.position > 0.0) & (flock.position < [2.0, 1.0, 1.0])).all()
        assert (flock.chamber >= 0).all()
    chamber = flock.chamber.copy()
    assert len(audit(flock, surroundings)) == 0
    assert np.array_equal(chamber, flock.chamber)
