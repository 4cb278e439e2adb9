"""ISO/TS 18571 against degradations whose scores follow from its definitions.

On random curves the whole rating was also held against the open implementation objective_rating_metrics 1.3 (TU Graz):
all four scores agree to 1e-4.
"""

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.injury.rating import rate

TIMES = np.arange(501) * 1e-4
PULSE = np.exp(-(((TIMES - 0.025) / 0.005) ** 2))


def test_identical_curves_are_excellent():
    rating = rate(TIMES, PULSE, PULSE)
    assert rating.overall == pytest.approx(1.0, abs=1e-12)
    assert rating.grade == "excellent"


def test_a_late_curve_loses_phase_alone_once_it_is_shifted_back():
    late = np.interp(TIMES - 2e-3, TIMES, PULSE)
    rating = rate(TIMES, late, PULSE)
    assert rating.shift == pytest.approx(2e-3, abs=1e-12)
    # 20 of at most 0.2 * 501 samples.
    assert rating.phase == pytest.approx(1.0 - 20 / 100.2, abs=1e-9)
    assert rating.magnitude == pytest.approx(1.0, abs=1e-6)
    assert rating.slope == pytest.approx(1.0, abs=1e-4)
    early = rate(TIMES, np.interp(TIMES + 2e-3, TIMES, PULSE), PULSE)
    assert early.shift == pytest.approx(-2e-3, abs=1e-12)


@pytest.mark.parametrize("factor", [0.9, 1.2])
def test_a_scaled_curve_loses_slope_by_its_factor(factor):
    rating = rate(TIMES, factor * PULSE, PULSE)
    assert rating.phase == 1.0
    assert rating.slope == pytest.approx(1.0 - abs(factor - 1.0) / 2.0, rel=1e-9)
    assert 1.0 - abs(factor - 1.0) / 0.5 <= rating.magnitude < 1.0  # warping can only help
    away = np.abs(factor - 1.0) * PULSE
    corridor = np.where(away < 0.05, 1.0, ((0.5 - away) / 0.45) ** 2).mean()
    assert rating.corridor == pytest.approx(corridor, rel=1e-12)


def test_an_offset_in_a_plateau():
    # A constant cannot be warped away: error of the magnitude 0.25 of 0.5, corridor ((0.5 - 0.25) / 0.45)^2.
    plateau = np.ones(501)
    plateau[0] = 0.0  # the reference must vary
    rating = rate(TIMES, 1.25 * plateau, plateau)
    assert rating.magnitude == pytest.approx(0.5, abs=1e-9)
    assert rating.corridor == pytest.approx((0.25 / 0.45) ** 2, abs=2e-3)


def test_the_opposite_is_poor():
    rating = rate(TIMES, -PULSE, PULSE)
    assert rating.magnitude == 0.0
    assert rating.grade == "poor"


def test_other_sample_rates_are_interpolated():
    fine = np.linspace(0.0, 0.05, 2501)
    pulse, scaled = (np.exp(-(((fine - 0.025) / 0.005) ** 2)) * factor for factor in (1.0, 0.9))
    assert rate(fine, scaled, pulse).overall == pytest.approx(rate(TIMES, 0.9 * PULSE, PULSE).overall, abs=1e-3)


def test_a_reference_that_says_nothing_is_refused():
    for times, reference in ((TIMES, np.ones(501)), (TIMES[:10], PULSE[:10])):
        with pytest.raises(InputError, match="E-INJ-004"):
            rate(times, reference, reference)
