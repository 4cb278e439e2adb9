"""Ratings of a bench test: what they say of curves whose difference is known."""

import numpy as np
import pytest

from billow.apps.coupon.rating import branches, match, ripple

TIME = np.linspace(0.0, 1.0, 401)
STRAIN = 0.1 * np.sin(np.pi * TIME)
STRESS = 1e8 * STRAIN**2 + 1e6 * np.cos(0.5 * np.pi * TIME)


def test_match_of_a_scaled_curve_is_the_scale():
    assert match(STRAIN, STRESS, STRAIN, STRESS) == pytest.approx((1.0, 1.0), abs=1e-12)
    assert match(STRAIN, 0.9 * STRESS, STRAIN, STRESS) == pytest.approx((0.9, 0.9), abs=1e-12)
    assert match(STRAIN, 3.0 * STRESS, STRAIN, STRESS) == (0.0, 0.0)


def test_match_rates_each_branch():
    wrong = np.where(np.arange(401) > 200, 0.5, 1.0) * STRESS
    loading, unloading = match(STRAIN, wrong, STRAIN, STRESS)
    assert loading == pytest.approx(1.0, abs=0.01)
    assert unloading == pytest.approx(0.5, abs=0.01)
    only_loading = slice(0, 201)
    assert np.isnan(match(STRAIN, STRESS, STRAIN[only_loading], STRESS[only_loading])[1])
    assert branches(STRAIN) == (slice(0, 201), slice(200, 401))


def test_ripple_is_the_amplitude_of_what_is_not_smooth():
    smooth = ripple(STRAIN, STRESS)
    assert max(smooth) < 1e-4
    rough = STRESS + 0.03 * STRESS.max() * np.sin(2.0 * np.pi * 50.0 * TIME)  # eight samples a period
    for branch in ripple(STRAIN, rough):
        assert branch == pytest.approx(0.03, rel=0.2)
