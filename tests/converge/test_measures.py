"""Synthetic curves whose noise and error are known: the measures find them."""

import numpy as np
import pytest

from billow.apps.converge.measures import Quantity, converge

COUNTS = (1000, 4000, 16000, 64000)
SEEDS = 40
T = np.linspace(0.0, 1.0, 400)
TRUTH = np.sin(7.0 * T) + 3.0 * T


def curves(noise: float, error: float, order: float = 1.0) -> Quantity:
    """noise: of one run with 1000 particles, error: the same for all seeds; both of |TRUTH|."""
    rng, size = np.random.default_rng(1), np.sqrt(np.mean(TRUTH**2))
    samples = {}
    for n in COUNTS:
        own = noise * size * np.sqrt(1000 / n) * rng.standard_normal((SEEDS, len(T)))
        samples[n] = TRUTH * (1.0 + error * (1000 / n) ** order) + own
    return Quantity("curve [-]", samples)


def test_pure_noise_is_found_and_falls_with_the_square_root():
    found = converge(curves(noise=0.2, error=0.0), tolerance=0.0)
    # A variance of 40 seeds x 400 samples is known to sqrt(2/16000) = 1.1 %, its root to 0.6 %; 5 sigma.
    np.testing.assert_allclose(found.noise, 0.2 * np.sqrt(1000 / np.array(COUNTS)), rtol=0.03)
    np.testing.assert_allclose(found.deviation, found.noise, rtol=0.03)
    assert found.exponent == pytest.approx(-0.5, abs=0.01)
    assert found.enough == 1000 or found.shift[0] > found.noise[-1]


def test_an_error_of_first_order_is_found_beneath_little_noise():
    found = converge(curves(noise=1e-5, error=0.1), tolerance=0.0)
    expected = 0.1 * (1000 / np.array(COUNTS) - 1000 / 64000) / (1.0 + 0.1 / 64)
    np.testing.assert_allclose(found.shift[:3], expected[:3], rtol=1e-3)
    assert found.enough is None  # nothing smaller is within the noise of the largest


@pytest.mark.parametrize(("tolerance", "enough"), [(0.11, 1000), (0.03, 4000), (0.006, 16000), (0.001, None)])
def test_enough_is_the_smallest_count_from_which_on_the_tolerance_is_kept(tolerance, enough):
    assert converge(curves(noise=1e-5, error=0.1), tolerance).enough == enough


def test_a_count_that_is_right_by_accident_is_not_enough():
    quantity = curves(noise=1e-5, error=0.1)
    quantity.samples[1000][:] = quantity.samples[64000]
    assert converge(quantity, 0.006).enough == 16000


def test_what_starts_far_from_zero_is_measured_by_its_change():
    quantity = curves(noise=1e-3, error=0.0)
    lifted = Quantity("curve [-]", {n: 1e3 + s for n, s in quantity.samples.items()}, 1e3)
    np.testing.assert_allclose(converge(lifted, 0.0).noise, converge(quantity, 0.0).noise, rtol=1e-9)
