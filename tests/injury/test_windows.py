"""What every window over samples keeps: its answer when times are shifted, time or values are scaled, or samples are
added on the straight lines between samples; also when a window just fits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.injury.criteria import CLIP, GRAVITY, clip, head_injury
from billow.injury.filters import channel_filter
from billow.injury.rating import rate

INTERVALS = st.sampled_from([1e-4, 7e-4, 1e-3, 1.5e-3])
SHIFTS = st.sampled_from([-3.0, 0.1, 17.3, 1e3])
CURVES = st.lists(st.floats(0.0, 200.0), min_size=3, max_size=50).map(np.array)
LONGEST = st.sampled_from([0.015, 0.036])
MANY = settings(max_examples=60, deadline=None)


def denser(curve, parts):
    samples = len(curve)
    return np.interp(np.arange(parts * (samples - 1) + 1) / parts, np.arange(samples), curve)


@MANY
@given(CURVES, INTERVALS, SHIFTS, LONGEST, st.integers(2, 8))
def test_hic_belongs_to_the_curve(curve, interval, shift, longest, parts):
    times, a = interval * np.arange(len(curve)), GRAVITY * curve
    value = head_injury(times, a, longest).value
    near = pytest.approx(value, rel=1e-7, abs=1e-9)
    assert head_injury(times + shift, a, longest).value == near
    dense = denser(a, parts)
    assert head_injury(interval / parts * np.arange(len(dense)), dense, longest).value == near
    assert head_injury(times, a[::-1], longest).value == near  # time backwards
    assert head_injury(7.0 * times, a, 7.0 * longest).value / 7.0 == near
    assert head_injury(times, 2.0 * a, longest).value / 2.0**2.5 == near


@MANY
@given(CURVES, INTERVALS, SHIFTS, st.booleans(), st.integers(2, 8))
def test_the_clip_belongs_to_the_curve(curve, interval, shift, contiguous, parts):
    times = interval * np.arange(len(curve))
    level = clip(times, curve, contiguous=contiguous)
    assert clip(times + shift, curve, contiguous=contiguous) == pytest.approx(level, rel=1e-6, abs=1e-4)
    dense = denser(curve, parts)
    dense_times = interval / parts * np.arange(len(dense))
    assert clip(dense_times, dense, contiguous=contiguous) == pytest.approx(level, rel=1e-6, abs=1e-4)
    assert clip(times, curve[::-1], contiguous=contiguous) == pytest.approx(level, rel=1e-6, abs=1e-4)
    assert clip(times, 3.0 * curve, contiguous=contiguous) == pytest.approx(3.0 * level, rel=1e-6, abs=1e-4)


@MANY
@given(st.integers(2, 400), SHIFTS, st.floats(0.1, 300.0))
def test_windows_that_just_fit_are_whole(samples, shift, height):
    constant = np.full(samples, height)
    for length, judged in (
        (CLIP, lambda t: clip(t, constant, contiguous=True)),
        (CLIP, lambda t: clip(t, constant, contiguous=False)),
        (0.015, lambda t: (head_injury(t, GRAVITY * constant, 0.015).value / 0.015) ** 0.4),
        (0.036, lambda t: (head_injury(t, GRAVITY * constant, 0.036).value / 0.036) ** 0.4),
    ):
        times = shift + np.linspace(0.0, length, samples)
        assert judged(times) == pytest.approx(height, rel=1e-6)


WAVES = st.lists(
    st.tuples(st.floats(0.2, 2.0), st.floats(0.0, 0.05), st.floats(2e-3, 1e-2)), min_size=1, max_size=4
)  # height, moment and width of some pulses


def pulses(times, wave):
    return sum(height * np.exp(-(((times - moment) / width) ** 2)) for height, moment, width in wave)


@settings(max_examples=60, deadline=None)
@given(WAVES, WAVES, st.integers(40, 250), SHIFTS, st.sampled_from([1e-3, 0.1, 50.0]))
def test_a_rating_belongs_to_the_curves(one, other, samples, shift, scale):
    times = 1e-4 * np.arange(samples)
    curve, reference = pulses(times, one), pulses(times, other)
    rating = rate(times, curve, reference)
    for changed in (rate(times + shift, curve, reference), rate(times, scale * curve, scale * reference)):
        assert changed.overall == pytest.approx(rating.overall, abs=1e-6)
        assert changed.shift == pytest.approx(rating.shift, abs=1e-9)
    dense = rate(np.linspace(0.0, times[-1], 3 * samples - 2), denser(curve, 3), denser(reference, 3))
    assert dense.overall == pytest.approx(rating.overall, abs=1e-6)


def test_of_equal_shifts_a_periodic_curve_has_the_smallest():
    times = 1e-4 * np.arange(501)
    wave = np.sin(2.0 * np.pi * times / 4e-3)
    for factor in (1.0, 1 / 3, 0.1, 7.7):
        assert rate(times, factor * np.roll(wave, 0), factor * wave).shift == 0.0
        assert rate(times, factor * np.full(501, 0.1), wave).phase == 1.0  # a constant is like nothing anywhere


@MANY
@given(CURVES, SHIFTS, st.floats(-5.0, 5.0))
def test_a_filtered_curve_moves_with_its_times_and_its_height(curve, shift, offset):
    times = 1e-4 * np.arange(len(curve))
    filtered = channel_filter(times, curve, 1000)
    near = {"rtol": 1e-6, "atol": 1e-6}
    np.testing.assert_allclose(channel_filter(times + shift, curve, 1000), filtered, **near)
    np.testing.assert_allclose(channel_filter(times, curve + offset, 1000), filtered + offset, **near)
    np.testing.assert_allclose(channel_filter(times, -3.0 * curve, 1000), -3.0 * filtered, **near)
