"""Intervals cover what they promise, and a surrogate says where it should not be trusted."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm
from synthetic import SyntheticDataset

from billow.base.errors import InputError
from billow.rom.judge.errors import check_intervals, fit_learning_curve
from billow.rom.learn.dataset import collect
from billow.rom.learn.reduction import reduce_runs
from billow.rom.learn.train import Recipe, held_out, train
from billow.rom.surrogate.design_space import neighbour_distances
from billow.rom.surrogate.intervals import LEVELS, histogram, quantiles, scale
from billow.rom.surrogate.surrogate import Surrogate


@given(st.floats(0.01, 100.0))
def test_the_factor_of_gaussian_errors_is_their_quantile(size):
    # |error| <= factor * s for a part `level`, error ~ N(0, (size s)^2): factor = size * quantile((1 + level)/2).
    random = np.random.default_rng(1)
    scales = random.uniform(1e-3, 1e-1, (100, 400, 3))
    error = size * scales * random.standard_normal(scales.shape)
    factors = quantiles(histogram(error, scales))
    expected = size * norm.ppf((1 + np.array(LEVELS)) / 2)
    # Sampling error of a quantile of 40,000 values: 1.5 % at most here; bins add 0.2 %.
    np.testing.assert_allclose(factors, np.tile(expected[:, None], 3), rtol=0.025)


def test_values_that_are_held_do_not_count():
    error = np.array([[[1.0], [np.nan], [0.0]]]) * np.ones(3)
    counts = histogram(error, np.ones((1, 3, 3)))
    np.testing.assert_allclose(counts.sum(axis=1), 1.0)
    assert np.count_nonzero(counts[0]) == 2


def test_runs_are_held_out_whole_each_once_and_no_more_than_needed():
    runs = tuple(f"{n:04d}" for n in range(50))
    folds = held_out([(run,) for run in runs])
    assert sorted(sum(folds, ())) == list(runs)
    assert [len(fold) for fold in held_out([(f"{n}",) for n in range(400)])] == [100]
    assert ("a", "b") in held_out([("a", "b"), ("c",), ("d",)])  # runs of one design are held out together


def test_ninety_percent_of_unseen_values_are_covered(surrogate):
    # Forty unseen runs of the same formula; the goal of the project is 85 to 95 % for each component.
    unseen = SyntheticDataset(train=2, test=40, seed=7)
    checks = {check.level: check for check in check_intervals(surrogate, unseen, unseen.test)}
    assert ((checks[0.9].covered > 0.85) & (checks[0.9].covered < 0.95)).all(), checks[0.9].covered
    widths = [checks[level].half_width for level in LEVELS]
    assert (np.diff(widths, axis=0) > 0).all()


def test_a_component_that_never_moves_is_covered():
    dataset = SyntheticDataset(train=8, test=2, times=5, nodes=60)
    real = dataset.snapshots
    dataset.snapshots = lambda field, runs: real(field, runs) * np.array([1, 0, 1], np.float32)
    surrogate = train(dataset, Recipe(modes=2, epochs=2)).despite_verdict()
    for check in check_intervals(surrogate, dataset, dataset.test):
        assert check.covered[1] == 1.0
        assert check.half_width[1] < 1e-6
    assert np.isfinite(surrogate.half_width(dataset.design(dataset.test))).all()


def test_what_is_covered_counts_what_can_move_run_by_run():
    """Three nodes, the first held: 0.05 m is inside +-0.1 m, 0.5 m is not."""
    truth = {"one": [0.0, 0.05, 0.5], "two": [0.0, 0.05, 0.05]}
    shape = (4, 3, 3)

    class Known:
        design = staticmethod(lambda runs: np.zeros((len(runs), 1)))
        snapshots = staticmethod(
            lambda field, runs: np.stack(
                [np.broadcast_to(np.array(truth[r], np.float32)[:, None], shape) for r in runs]
            )
        )

    class Zero:
        nodes, intervals = 3, SimpleNamespace(levels=(0.5,))
        predict = staticmethod(lambda design, **_: np.zeros(shape))
        half_width = staticmethod(lambda design, **_: np.full(shape, 0.1))

    (check,) = check_intervals(Zero, Known, ("one", "two"))
    np.testing.assert_allclose(check.by_run, [[0.5] * 3, [1.0] * 3])
    np.testing.assert_allclose(check.covered, 0.75)
    np.testing.assert_allclose(check.worst_run, 0.5)
    np.testing.assert_allclose(check.half_width, 0.1)


def test_the_scale_is_spread_and_truncation_at_each_node(surrogate, dataset):
    row, lost = dataset.design(dataset.test)[0], (surrogate.intervals.lost_by_time, surrogate.intervals.lost_by_node)
    members = surrogate.regression.by_member(row[None], surrogate.times)[:, 0].reshape(-1, 20, 3, 8)
    fields = np.einsum("mtk,kn->mtn", members[:, :, 2], surrogate.bases[2].modes)
    outside = np.outer(lost[0][2], lost[1][2]) / lost[1][2].mean()
    expected = np.sqrt(fields.var(axis=0, ddof=1) + outside)
    np.testing.assert_allclose(scale(surrogate, *lost, row, surrogate.times)[:, :, 2], expected, rtol=1e-3, atol=1e-8)
    half = surrogate.half_width(row, surrogate.times[[4, 9]], level=0.8)
    factor = surrogate.intervals.factors[1, 2]
    np.testing.assert_allclose(half[:, :, 2], factor * expected[[4, 9]], rtol=1e-3, atol=1e-8)


def test_what_is_lost_is_the_mean_square_outside_the_basis(surrogate, dataset):
    snapshots = collect(dataset, dataset.train)
    matrix, basis = snapshots[2], surrogate.bases[2]
    outside = np.square(matrix - basis.fields(basis.coefficients(matrix)), dtype=float)
    np.testing.assert_allclose(surrogate.intervals.lost_by_node[2], outside.mean(axis=1), rtol=1e-4)
    by_time = outside.reshape(len(matrix), 30, 20).mean(axis=(0, 1))
    found = reduce_runs(dataset, dataset.train, surrogate.modes, seed=0).lost_by_time[2]
    np.testing.assert_allclose(found, by_time, rtol=1e-4, atol=1e-15)
    assert (surrogate.intervals.lost_by_time[2] >= found * (1.0 - 1e-4)).all()  # and what was not believed


def test_intervals_travel_with_the_file(surrogate, saved, dataset):
    row = dataset.design(dataset.test)[0]
    loaded = Surrogate.load(saved)
    np.testing.assert_array_equal(loaded.half_width(row), surrogate.half_width(row))
    np.testing.assert_array_equal(loaded.designs, dataset.design(dataset.train))
    without = dataclasses.replace(surrogate, intervals=None)
    with pytest.raises(InputError, match="E-ROM-017"):
        without.half_width(row)
    with pytest.raises(InputError, match=r"E-ROM-018(?s:.*)0\.5, 0\.8, 0\.9, 0\.95"):
        surrogate.half_width(row, level=0.99)


def test_progress_of_calibration_is_one_bar(dataset):
    told = []
    train(dataset, Recipe(modes=2, epochs=2), runs=dataset.train[:8], progress=lambda *what: told.append(what))
    assert [(epoch, of) for epoch, of, *_ in told] == [(n, 10) for n in range(1, 11)]
    assert {which for *_, which in told[:2]} == {"training 1 of 5"}
    assert sorted(which for *_, which in told[2:]) == sorted(2 * [f"training {n} of 5" for n in range(2, 6)])


def test_a_design_is_told_from_where_it_stands(surrogate):
    middle = {p.name: 0.5 * (p.low + p.high) for p in surrogate.parameters}
    at_home = surrogate.standing(surrogate.designs[3])
    assert at_home.nearest == pytest.approx(0.0, abs=1e-7)
    assert at_home.warnings() == []
    outside = surrogate.standing(middle | {"jet": 75.0})
    assert outside.outside == ("jet",)
    assert "jet outside the trained range" in outside.warnings()[0]
    far = surrogate.standing({p.name: p.low if p.name != "slope" else p.high for p in surrogate.parameters})
    assert far.nearest > at_home.usual
    isolated = dataclasses.replace(far, nearest=2.0 * far.largest)
    assert isolated.isolated
    assert "farther than any of them" in isolated.warnings()[0]


def test_distance_to_the_nearest_neighbour():
    points = np.array([[0.0, 0.0], [0.3, 0.4], [1.0, 0.4]])
    np.testing.assert_allclose(neighbour_distances(points), [0.5, 0.5, 0.7])


@given(st.floats(0.01, 2.0), st.floats(1e-4, 1e-1))
def test_a_power_law_is_found_and_says_what_more_runs_buy(rate, scale):
    runs = np.array([12, 24, 48])
    curve = fit_learning_curve(runs, scale * runs**-rate)
    assert curve.rate == pytest.approx(rate, rel=1e-6)
    assert curve.doubled == pytest.approx(scale * 96.0**-rate, rel=1e-6)


def test_a_curve_needs_two_sizes():
    assert fit_learning_curve([10], [0.1]) is None
    assert fit_learning_curve([10, 20], [0.1, 0.0]) is None
    assert fit_learning_curve([10, 20], [0.1, 0.2]).doubled == pytest.approx(0.4)
