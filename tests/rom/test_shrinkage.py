"""How much of an answer is believed: least squares over runs held out, and what it does to answers."""

import numpy as np
import pytest

from billow.rom.learn.shrinkage import Agreement, disbelieved, factors, shrunk

TIMES, RUNS, MODES = 40, 30, 12
AT = np.arange(TIMES) * 1e-3


def agreements(noise: float, spread: float = 1.0) -> list[Agreement]:
    """Runs whose departures of unit variance are predicted with errors of variance `noise` in the second half."""
    random, found = np.random.default_rng(0), []
    error = np.sqrt(noise) * (np.arange(TIMES) >= TIMES // 2)[:, None, None]
    for _ in range(RUNS):
        truth = random.standard_normal((TIMES, 3, MODES))
        away = truth + error * random.standard_normal(truth.shape)
        found.append(
            Agreement((away * truth).sum(axis=2), np.square(away).sum(axis=2), np.full((TIMES, 3), spread), AT, AT)
        )
    return found


@pytest.mark.parametrize("noise", [0.0, 1.0, 9.0])
def test_what_is_believed_is_the_part_of_the_variance_that_is_true(noise):
    found = factors(agreements(noise))
    assert found[:16] == pytest.approx(np.ones((16, 3)), abs=1e-12)
    expected = 1.0 / (1.0 + noise)  # regression of the truth on a prediction with independent errors
    expected = (RUNS * expected + 1.0) / (RUNS + 1.0)  # one more run that agrees
    assert found[24:] == pytest.approx(np.full((16, 3), expected), abs=0.03)


def test_opposite_answers_are_not_believed_and_none_twice():
    one = agreements(0.0)[0]
    assert not factors(10 * [Agreement(-one.own, one.own, one.spread, AT, AT)]).any()
    assert (factors(10 * [Agreement(3.0 * one.own, one.own, one.spread, AT, AT)]) == 1.0).all()
    nothing = np.zeros((TIMES, 3))
    assert (factors(10 * [Agreement(nothing, nothing, nothing, AT, AT)]) == 1.0).all()


def test_the_mean_trajectory_stays_and_departures_shrink(dataset, surrogate):
    design = dataset.design(dataset.test[:1])[0]
    by = np.linspace(1.0, 0.0, len(surrogate.times))[:, None] * [1.0, 0.5, 0.25]
    mean = surrogate.regression.outputs.mean.reshape(len(by), 3, -1)
    before, after = surrogate.coefficients(design), shrunk(surrogate, by).coefficients(design)
    assert after == pytest.approx(mean + by[:, :, None] * (before - mean), abs=1e-5)


def test_intervals_keep_what_members_no_longer_show(dataset, surrogate):
    """Spread of the members and what was not believed add up to the spread before."""
    by = np.full((len(surrogate.times), 3), 0.6)
    design = dataset.design(dataset.test[:1])[0]
    members = surrogate.regression.members
    before = np.square(surrogate.spread(design)) * members / (members - 1)
    after = np.square(shrunk(surrogate, by).spread(design)) * members / (members - 1)
    nothing = np.zeros_like(before)
    lost = disbelieved([Agreement(nothing, nothing, before, surrogate.times, surrogate.times)], by).T
    assert after + lost == pytest.approx(before, rel=1e-3)


def test_factors_of_common_times_count_at_the_times_of_each_run():
    """A run whose clock shows only the first half is disbelieved as the first half is."""
    by = np.repeat(np.linspace(1.0, 0.0, TIMES)[:, None], 3, axis=1)
    one = Agreement(by, by, np.ones((5, 3)), np.linspace(0.0, 0.5 * AT[-1], 5), AT)
    assert disbelieved([one], by)[2] == pytest.approx(1.0 - np.square([1.0, 0.875, 0.75, 0.625, 0.5]))
