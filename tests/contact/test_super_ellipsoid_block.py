"""Points in a block have the closest points that they have alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid, near_super_ellipsoid
from billow.geometry.shapes.super_ellipsoid_block import BLOCK, COUNTS, DEPTH, MX, MY, MZ, REACH, ROWS, X, near_points

UPRIGHT = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
shapes = st.builds(
    lambda radii, degree: SuperEllipsoid(np.array(radii), degree),
    st.tuples(*[st.floats(0.05, 0.5)] * 3).filter(lambda r: max(r) < 4.0 * min(r)),
    st.sampled_from([2.0, 2.3, 3.0, 4.5, 10.0]),
)


def look(shape, points, reach, asked):
    """Whether each point is within reach, depth and normal: (BLOCK, 5)."""
    block = np.zeros(ROWS * BLOCK)
    block[X : X + 3 * BLOCK] = points.T.ravel()
    block[REACH : REACH + BLOCK], block[COUNTS : COUNTS + BLOCK] = reach, asked
    near_points(block, tuple(shape.numbers))
    return np.column_stack([block[row : row + BLOCK] for row in (COUNTS, DEPTH, MX, MY, MZ)])


def alone(shape, points, reach):
    found = [near_super_ellipsoid(tuple(shape.numbers), UPRIGHT, *point, reach, 0.0, 0.0) for point in points]
    return np.array(found, dtype=float)


def crowd(shape, seed, flat):
    """Points around the surface; of some, coordinates are zero."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(BLOCK, 3)) * shape.radii
    points[rng.random((BLOCK, 3)) < flat] = 0.0
    points[~points.any(axis=1)] = [0.0, 0.0, 1.0]
    measure = (np.abs(points / shape.radii) ** shape.degree).sum(axis=1) ** (1.0 / shape.degree)
    return points / measure[:, None] * rng.uniform(0.85, 1.1, BLOCK)[:, None]


@given(shape=shapes, seed=st.integers(0, 10**6), flat=st.sampled_from([0.0, 0.3]))
def test_points_in_a_block_have_the_answers_that_they_have_alone(shape, seed, flat):
    points, reach = crowd(shape, seed, flat), 1e-3
    together, each = look(shape, points, reach, 1.0), alone(shape, points, reach)
    # At the end of the reach rounding decides.
    doubtful = np.abs(each[:, 1] + reach) < 1e-12
    np.testing.assert_array_equal(together[~doubtful, 0], each[~doubtful, 0])
    counts = (together[:, 0] > 0.0) & (each[:, 0] > 0.0)
    assert counts.sum() > 10
    assert together[counts, 1] == pytest.approx(each[counts, 1], abs=1e-12)
    assert together[counts, 2:] == pytest.approx(each[counts, 2:], abs=1e-9)


@given(shape=shapes, seed=st.integers(0, 10**6))
def test_an_answer_does_not_depend_on_the_others(shape, seed):
    """Not the last bit: a search that has ended rests while others go on."""
    points = crowd(shape, seed, 0.1)
    together = look(shape, points, 1e-3, 1.0)
    chosen = np.random.default_rng(seed).random(BLOCK) < 0.3
    part = look(shape, np.where(chosen[:, None], points, 10.0 * points), 1e-3, chosen.astype(float))
    np.testing.assert_array_equal(part[chosen], together[chosen])
    assert not part[~chosen, 0].any()


def test_the_centre_has_a_direction():
    for shape in (SuperEllipsoid(np.full(3, 0.1), 2.0), SuperEllipsoid(np.array([0.2, 0.15, 0.1]), 3.0)):
        found = look(shape, np.zeros((BLOCK, 3)), 1e-3, 1.0)
        assert found == pytest.approx(np.tile([1.0, shape.size, 0.0, 0.0, 1.0], (BLOCK, 1)), abs=1e-12)
