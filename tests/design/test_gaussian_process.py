"""The process is the one of the textbook: against formulas written down anew, and refits without a run."""

import dataclasses

import numpy as np
import pytest

from billow.design.gaussian_process import JITTER, STARTED_WITH, Axes, GaussianProcess, _objective, _squares

AXES = Axes((0, 0, 3))


@pytest.fixture(scope="module")
def process():
    random = np.random.default_rng(1)
    points = np.column_stack([random.random((30, 2)), random.integers(0, 3, 30) / 2.0])
    values = np.sin(5 * points[:, 0]) + points[:, 1] ** 2 + (points[:, 2] == 0.5) + 0.01 * random.standard_normal(30)
    return GaussianProcess.fit(AXES, points, values)


def textbook(process, asked):
    """Universal kriging by one bordered system: mean and deviation."""
    lengths, nugget = np.exp(process.log_lengths), np.exp(process.log_nugget) + JITTER

    def correlation(one, other):
        r = np.zeros((len(one), len(other)))
        for k in range(2):
            r += (one[:, None, k] - other[None, :, k]) ** 2 / lengths[k] ** 2
        r += (one[:, None, 2] != other[None, :, 2]) / lengths[2] ** 2
        r = np.sqrt(5 * r)
        return (1 + r + r**2 / 3) * np.exp(-r)

    def trend(points):
        return np.column_stack([np.ones(len(points)), points[:, :2], points[:, 2] == 0.5, points[:, 2] == 1.0])

    x, y = process.points, (process.values - process.values.mean()) / process.values.std()
    f, n = trend(x), len(x)
    k = correlation(x, x) + nugget * np.eye(n)
    bordered = np.block([[k, f], [f.T, np.zeros((f.shape[1], f.shape[1]))]])
    solved = np.linalg.solve(bordered, np.concatenate([y, np.zeros(f.shape[1])]))
    variance = y @ solved[:n] / (n - f.shape[1])
    right = np.concatenate([correlation(x, asked), trend(asked).T])
    left = 1 + nugget - np.einsum("ij,ij->j", right, np.linalg.solve(bordered, right))
    back = process.values.std()
    return right.T @ solved * back + process.values.mean(), np.sqrt(variance * left) * back


def test_mean_and_deviation_are_those_of_the_bordered_system(process):
    random = np.random.default_rng(2)
    asked = np.column_stack([random.random((50, 2)), random.integers(0, 3, 50) / 2.0])
    for found, expected in zip(process.predict(asked), textbook(process, asked), strict=True):
        assert found == pytest.approx(expected, rel=1e-8)


def test_leave_one_out_is_a_refit_without_the_run(process):
    mean, _ = process.leave_one_out()
    for k in (0, 13, 29):
        others = np.arange(30) != k
        standard = (process.values - process.values.mean()) / process.values.std()
        fewer = dataclasses.replace(process, points=process.points[others], values=process.values[others])
        answer = fewer.predict(process.points[[k]])[0][0]
        assert mean[k] == pytest.approx(answer, rel=1e-8)
        assert abs(standard[k]) < 5


def test_the_slope_of_the_likelihood_is_its_slope():
    random = np.random.default_rng(4)
    points = random.random((20, 3))
    squares = np.array([_squares(points[:, [k]], points[:, [k]]) for k in range(3)])
    trend, values = np.column_stack([np.ones(20), points]), random.standard_normal(20)
    at = np.array([0.3, -0.5, 1.0, -4.0])
    _, slope = _objective(at, squares, trend, values)
    for k in range(4):
        step = 1e-6 * np.eye(4)[k]
        ends = [_objective(at + side * step, squares, trend, values)[0] for side in (1, -1)]
        assert slope[k] == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-5, abs=1e-7)


def test_values_in_other_units_or_another_order_change_nothing(process):
    asked = np.array([[0.2, 0.7, 0.5], [0.9, 0.1, 0.0]])
    mean, deviation = process.predict(asked)
    scaled = GaussianProcess.fit(AXES, process.points, 1e3 * process.values + 5.0)
    assert scaled.predict(asked)[0] == pytest.approx(1e3 * mean + 5.0, rel=1e-6)
    assert scaled.predict(asked)[1] == pytest.approx(1e3 * deviation, rel=1e-4)
    turned = GaussianProcess.fit(AXES, process.points[::-1], process.values[::-1])
    assert turned.predict(asked)[0] == pytest.approx(mean, rel=1e-5)


def test_many_runs_find_the_lengths_that_all_starts_would(monkeypatch):
    """Starts are tried with some of the runs; what is found is as likely as with all starts on all runs."""
    random = np.random.default_rng(8)
    points = random.random((150, 3))
    values = np.sin(6.0 * points[:, 0]) + points[:, 1] ** 2 + 0.02 * random.normal(size=150)
    one = GaussianProcess.fit(Axes((0, 0, 0)), points, values)
    monkeypatch.setattr("billow.design.gaussian_process.STARTED_WITH", 1000)
    all_starts = GaussianProcess.fit(Axes((0, 0, 0)), points, values)
    assert np.abs(one.log_lengths - all_starts.log_lengths).max() < 0.02
    assert abs(one.log_nugget - all_starts.log_nugget) < 0.02


@pytest.mark.filterwarnings("error")
def test_many_runs_of_which_some_are_all_alike_are_learned_from_all():
    """Only runs that no start is tried with differ."""
    points = np.random.default_rng(9).random((300, 2))
    values = np.ones(300)
    values[np.linspace(0, 299, STARTED_WITH).astype(int)] = 0.0
    assert np.isfinite(GaussianProcess.fit(Axes((0, 0)), points, values).predict(points[:5])).all()


def test_levels_of_a_factor_are_equally_far_apart():
    columns = AXES.columns(np.array([[0.5, 0.5, level] for level in (0.0, 0.5, 1.0)]))
    assert _squares(columns, columns) == pytest.approx(1.0 - np.eye(3))
