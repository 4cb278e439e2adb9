"""Channel frequency classes of SAE J211-1 against their definition."""

import numpy as np
import pytest

from billow.apps.verification.injury import channel_classes
from billow.base.errors import InputError
from billow.injury.filters import CLASSES, channel_filter, coefficients


def test_three_decibels_are_lost_at_five_thirds_of_the_class():
    for measurement in channel_classes():
        assert measurement.passed, measurement


def test_coefficients_are_those_printed_in_the_standard():
    # Any set of J211 coefficients passes a constant: a0 + a1 + a2 + b1 + b2 = 1, and is stable.
    for channel_class in CLASSES:
        forward, backward = coefficients(channel_class, 1e-5)
        assert forward.sum() == pytest.approx(backward.sum(), rel=1e-12)
        assert np.abs(np.roots(backward)).max() < 1.0
    # Wa = tan(pi 2.0775 180 1e-4): the worked example of CFC 180 at 10 kHz.
    w = np.tan(np.pi * 2.0775 * 180 * 1e-4)
    a0 = w**2 / (1 + np.sqrt(2) * w + w**2)
    forward, backward = coefficients(180, 1e-4)
    assert forward == pytest.approx([a0, 2 * a0, a0], rel=1e-14)
    assert backward[1] == pytest.approx(2 * (w**2 - 1) / (1 + np.sqrt(2) * w + w**2), rel=1e-14)


def test_a_straight_line_and_the_peak_of_a_slow_wave_stay():
    times = np.linspace(0.0, 0.1, 2001)
    assert channel_filter(times, np.ones(2001), 600) == pytest.approx(np.ones(2001), abs=1e-12)
    # Where the mirrored line begins the filter lags by 3 times its time constant of 0.2 ms; two periods of its corner
    # frequency, damped by 0.7, leave exp(-4 pi 0.7) = 1.4e-4 of it.
    line = 3.0 * times - 0.1
    assert channel_filter(times, line, 600) == pytest.approx(line, abs=3.0 * 2e-4 * 1.4e-4)
    wave = np.sin(2 * np.pi * 20.0 * times)  # (20/374)^4 = 8e-6 of loss at CFC 180, no shift
    assert channel_filter(times, wave, 180) == pytest.approx(wave, abs=2e-4)


def test_filtering_twice_backward_is_symmetric_in_time():
    random = np.random.default_rng(3).standard_normal(400)
    times = np.arange(400) * 1e-4
    there, back = channel_filter(times, random, 180), channel_filter(times, random[::-1], 180)[::-1]
    middle = slice(150, 250)  # at the ends the two passes start in another order
    assert there[middle] == pytest.approx(back[middle], abs=1e-4 * np.abs(there).max())


def test_a_slow_recording_is_refused():
    times = np.arange(100) * 1.01e-4
    with pytest.raises(InputError, match="E-INJ-003"):
        channel_filter(times, np.ones(100), 1000)
    assert channel_filter(times, np.ones(100), 600) == pytest.approx(np.ones(100))


@pytest.mark.parametrize(
    ("times", "curve"),
    [([0.0], [1.0]), ([0.0, 1.0, 3.0], [1.0, 1.0, 1.0]), ([0.0, 1.0], [1.0, np.nan]), ([0.0, 1.0], [1.0])],
)
def test_what_is_no_curve_is_refused(times, curve):
    with pytest.raises(InputError, match="E-INJ-001"):
        channel_filter(np.array(times), np.array(curve), 60)


def test_an_unknown_class_is_refused():
    with pytest.raises(InputError, match="E-INJ-002"):
        channel_filter(np.arange(9) * 1e-4, np.ones(9), 300)
