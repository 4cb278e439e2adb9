"""Powers in loops are powers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from billow.geometry.power import SMALLEST, power


@given(x=st.floats(1e-30, 1e30), p=st.floats(-3.0, 10.0))
@example(x=1.0, p=0.0)
@example(x=math.sqrt(0.5), p=1.0)
@example(x=np.nextafter(math.sqrt(0.5), 0.0), p=1.0)
@example(x=np.nextafter(1.0, 0.0), p=10.0)
def test_a_power_is_exact_to_rounding_of_its_exponent(x, p):
    expected = x**p
    assert power(x, p) == pytest.approx(expected, rel=1e-15 * (1.0 + abs(p * math.log(x))), abs=0.0)


@given(x=st.floats(SMALLEST, 1e300))
def test_the_power_of_zero_is_one(x):
    assert power(x, 0.0) == 1.0


def test_what_is_too_small_or_too_large_ends_at_a_bound():
    assert power(SMALLEST, 8.0) == pytest.approx(2.0**-1000, rel=1e-12)
    assert power(SMALLEST, -8.0) == pytest.approx(2.0**1000, rel=1e-12)
