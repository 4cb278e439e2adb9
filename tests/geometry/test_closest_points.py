"""Closest points of a point and a triangle and of two segments, against a search over all places."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.geometry.closest_points import of_segments, on_triangle

SHARES = np.linspace(0.0, 1.0, 61)


def corners(seed, count, flat):
    """Points at random; flat: how much they are squeezed onto a line, so that triangles become slivers."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points[:, 1:] *= flat
    return points


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), flat=st.sampled_from([1.0, 1e-3, 0.0]))
def test_triangle(seed, flat):
    p, a, b, c = corners(seed, 4, flat)
    s, t, *way = on_triangle(*p, *a, *b, *c)
    assert min(s, t, 1.0 - s - t) >= -1e-12
    here = a + s * (b - a) + t * (c - a)
    assert np.allclose(p - here, way, atol=1e-12)
    i, j = (grid.ravel() for grid in np.meshgrid(SHARES, SHARES))
    i, j = i[i + j <= 1.0], j[i + j <= 1.0]
    elsewhere = a + i[:, None] * (b - a) + j[:, None] * (c - a)
    assert np.linalg.norm(way) <= np.linalg.norm(p - elsewhere, axis=1).min() + 1e-9


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), flat=st.sampled_from([1.0, 1e-3, 0.0]))
def test_segments(seed, flat):
    a, b, c, d = corners(seed, 4, flat)
    s, t, *way = of_segments(*a, *b, *c, *d)
    assert 0.0 <= s <= 1.0
    assert 0.0 <= t <= 1.0
    assert np.allclose(a + s * (b - a) - c - t * (d - c), way, atol=1e-12)
    one, other = a + SHARES[:, None] * (b - a), c + SHARES[:, None] * (d - c)
    apart = np.linalg.norm(one[:, None] - other[None], axis=2).min()
    assert np.linalg.norm(way) <= apart + 1e-5 * (flat != 1.0) + 1e-9


@pytest.mark.parametrize("point", [[0.2, 0.1, 0.3], [0.0, 0.0, 0.0]])
def test_what_has_no_size(point):
    """A triangle and a segment of one point."""
    s, t, *way = on_triangle(*point, *[0.5] * 9)
    assert np.allclose(way, np.array(point) - 0.5)
    s, t, *way = of_segments(*point, *point, *[0.5] * 6)
    assert np.isfinite([s, t]).all()
    assert np.allclose(way, np.array(point) - 0.5)
