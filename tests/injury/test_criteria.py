"""HIC and 3 ms clip against closed forms and brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.apps.verification.injury import half_sine_hic
from billow.injury.criteria import GRAVITY, clip, head_injury


def test_half_sine():
    for measurement in half_sine_hic():
        assert measurement.passed, measurement


def test_a_constant_is_judged_over_the_longest_window():
    # (t2 - t1) a^2.5 grows with the window; 15 ms is no whole number of 0.7 ms, so the ends must be interpolated.
    times = np.arange(60) * 7e-4
    for longest in (0.015, 0.036):
        found = head_injury(times, np.full(60, 50.0 * GRAVITY), longest)
        assert found.value == pytest.approx(longest * 50.0**2.5, rel=1e-12)
        assert found.end - found.start == pytest.approx(longest, rel=1e-12)


def test_a_window_that_begins_between_samples_is_found():
    # Rising lines are judged over the last 15 ms: HIC = w (mean)^2.5, exact for any sampling.
    times = np.arange(60) * 7e-4
    slope = 2000.0
    found = head_injury(times, slope * GRAVITY * times, 0.015)
    assert found.value == pytest.approx(0.015 * (slope * (times[-1] - 0.0075)) ** 2.5, rel=1e-12)
    assert found.start == pytest.approx(times[-1] - 0.015, abs=1e-12)


def test_longer_than_the_curve_and_braking_curves():
    times = np.arange(11) * 1e-3
    assert head_injury(times, np.full(11, GRAVITY), 0.036).value == pytest.approx(0.010, rel=1e-12)
    assert head_injury(times, np.full(11, -GRAVITY), 0.036).value == 0.0


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(0.0, 200.0), min_size=3, max_size=40), st.sampled_from([0.015, 0.036]))
def test_against_all_windows_of_a_fine_grid(values, longest):
    times, curve = np.arange(len(values)) * 1e-3, np.array(values)
    steps = np.arange(20 * (len(values) - 1) + 1)
    a = np.interp(0.05 * steps, np.arange(len(values)), curve)
    velocity = np.concatenate([[0.0], np.cumsum(0.025e-3 * (a[1:] + a[:-1]))])
    window = 0.05e-3 * (steps - steps[:, None])
    allowed = (window > 0.0) & (window <= longest * (1 + 1e-12))
    mean = (velocity - velocity[:, None])[allowed] / window[allowed]
    brute = (window[allowed] * np.maximum(mean, 0.0) ** 2.5).max()
    found = head_injury(times, curve * GRAVITY, longest).value
    assert brute * (1.0 - 1e-9) <= found + 1e-12
    assert found == pytest.approx(brute, rel=2e-2, abs=1e-12)  # an end off by half of the grid loses its square


def test_clip_of_a_half_sine():
    # The level above which a half sine of length T stays for 3 ms: A cos(pi 3 ms / 2 T), the same summed or not.
    length, times = 10e-3, np.linspace(0.0, 10e-3, 2001)
    curve = 700.0 * np.sin(np.pi * times / length)
    for contiguous in (False, True):
        # Straight lines between samples lose (pi dt / T)^2 / 8 of the height.
        assert clip(times, curve, contiguous=contiguous) == pytest.approx(
            700.0 * np.cos(np.pi * 3e-3 / (2.0 * length)), rel=1e-6
        )


def test_two_pulses_count_together_only_in_the_sum():
    # Two triangles of height 100 and base 4 ms: above 100 - h each lasts 4 ms h / 100.
    times = np.linspace(0.0, 12e-3, 1201)
    curve = 100.0 * np.maximum(0.0, 1.0 - np.abs(np.abs(times - 6e-3) - 3e-3) / 2e-3)
    assert clip(times, curve, contiguous=True) == pytest.approx(25.0, rel=1e-6)
    assert clip(times, curve, contiguous=False) == pytest.approx(62.5, rel=1e-6)


def test_clip_of_what_is_too_short_or_silent():
    times = np.linspace(0.0, 2e-3, 21)
    assert clip(times, np.ones(21), contiguous=True) == 0.0
    assert clip(3 * times, np.zeros(21), contiguous=False) == 0.0
    assert clip(3 * times, np.ones(21), contiguous=True) == pytest.approx(1.0, rel=1e-8)
