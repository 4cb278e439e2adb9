"""The angle of a plane vector is that of the C library, to the error that is told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.geometry.angle import ERROR, angle

component = st.floats(-1e6, 1e6).filter(lambda value: value == 0.0 or abs(value) > 1e-6)


@given(component, component)
def test_it_is_the_arc_tangent_of_both_components(x, y):
    if x or y:
        assert angle(x, y) == pytest.approx(math.atan2(y, x), abs=ERROR)


def test_it_is_so_all_around():
    turn = np.linspace(-np.pi, np.pi, 20_001)
    found = np.array([angle(3.0 * math.cos(a), 3.0 * math.sin(a)) for a in turn])
    error = (found - turn + np.pi) % (2.0 * np.pi) - np.pi
    assert np.abs(error).max() < ERROR
    assert np.abs(error).max() > 0.2 * ERROR  # what is told is what it is


def test_a_vector_without_length_has_a_number():
    assert math.isfinite(angle(0.0, 0.0))
