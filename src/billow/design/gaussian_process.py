"""A Gaussian process: Matern 5/2 correlation, a length for each axis, a linear mean, and noise of the runs (a nugget).

Lengths and nugget maximise the restricted likelihood with weak priors (Rasmussen and Williams, Gaussian Processes for
Machine Learning, 2006, sections 2.7, 4.2 and 5.4; docs/design.md). One BLAS thread: same bits on any number of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.base.blas_threads import one_blas_thread

LOG_LENGTH = (np.log(2.0), 1.5)
"""Mean and deviation of the prior of a log length; the range of an axis is 1. Idle axes would go to infinity."""
LOG_NUGGET = (-7.0, 3.0)
"""Of the log of the nugget, the noise variance over that of the process."""
LENGTH_BOUNDS, NUGGET_BOUNDS = (-3.0, 4.0), (-18.0, 0.0)
STARTS, STARTED_WITH = 4, 120
"""Starts of the search for lengths and nugget, and the most runs with which all of them are tried: of more runs so many
are taken for that, and what suits them best is the only start with all."""
JITTER = 1e-8
"""Added to the nugget: correlations of near points are singular to rounding."""
LEAST_VARIANCE = 1e-18
"""Of a process, of standardised values: those of a straight line have none but rounding."""
AT_ONCE = 40_000
"""Correlations of designs with runs that are found at once, to fit into the cache."""


@dataclass(frozen=True)
class Axes:
    """From designs in [0, 1] to the columns that distances are taken in.

    levels: of each axis, 0 for a number, else how many levels; a factor has a column for each level, so that any two
    levels are a distance of 1 apart, and one length for all of them.
    """

    levels: tuple[int, ...]

    @cached_property
    def owner(self) -> np.ndarray:
        """Axis of each column."""
        return np.repeat(np.arange(len(self.levels)), [max(n, 1) for n in self.levels])

    def columns(self, unit: np.ndarray) -> np.ndarray:
        """(designs, columns); unit: (designs, axes)."""
        made = []
        for values, count in zip(unit.T, self.levels, strict=True):
            if count:
                level = np.round(values * (count - 1)).astype(int)
                made.append(np.sqrt(0.5) * (level[:, None] == np.arange(count)))
            else:
                made.append(values[:, None])
        return np.concatenate(made, axis=1)

    def trend(self, columns: np.ndarray) -> np.ndarray:
        """Functions whose sum is the mean: a constant, and each column but the first of every factor."""
        first = [k for k, axis in enumerate(self.owner) if self.levels[axis] and (k == 0 or self.owner[k - 1] != axis)]
        used = np.setdiff1d(np.arange(len(self.owner)), first)
        return np.column_stack([np.ones(len(columns)), columns[:, used] - 0.5])


@dataclass(frozen=True, eq=False)
class GaussianProcess:
    """axes; points: (runs, axes) in [0, 1]; values: (runs,); log_lengths: (axes,); log_nugget"""

    axes: Axes
    points: np.ndarray
    values: np.ndarray
    log_lengths: np.ndarray
    log_nugget: float

    @classmethod
    @one_blas_thread()
    def fit(cls, axes: Axes, points: np.ndarray, values: np.ndarray, like: GaussianProcess | None = None):
        """The process whose lengths and nugget suit some runs best. points: (runs, axes) in [0, 1]; values: (runs,);
        like: of nearly the same runs, whose lengths and nugget are the only start of the search."""
        from scipy.optimize import minimize

        if like is None and len(values) > STARTED_WITH:
            some = np.linspace(0, len(values) - 1, STARTED_WITH).astype(int)
            like = cls.fit(axes, points[some], values[some]) if np.ptp(values[some]) > 0.0 else None
        count = len(axes.levels)
        columns = axes.columns(points)
        trend = axes.trend(columns)
        squares = np.array([_squares(columns[:, axes.owner == k], columns[:, axes.owner == k]) for k in range(count)])
        standard = (values - values.mean()) / values.std()
        random = np.random.default_rng(0)
        bounds = [LENGTH_BOUNDS] * count + [NUGGET_BOUNDS]
        if like is None:
            lengths = [np.full(count, np.log(1.5)), *random.normal(np.log(1.5), 0.7, (STARTS - 1, count))]
            starts = [np.append(start, LOG_NUGGET[0]) for start in lengths]
        else:
            starts = [np.append(like.log_lengths, like.log_nugget)]
        best = None
        for start in starts:
            found = minimize(_objective, start, (squares, trend, standard), "TNC", True, bounds=bounds)
            if best is None or found.fun < best.fun:
                best = found
        return cls(axes, points, values, best.x[:count], float(best.x[count]))

    @cached_property
    def _known(self) -> _Known:
        columns = self.axes.columns(self.points)
        scaled = columns * np.exp(-self.log_lengths)[self.axes.owner]
        correlation = matern(_squares(scaled, scaled))
        correlation[np.diag_indices(len(columns))] += np.exp(self.log_nugget) + JITTER
        standard = (self.values - self.values.mean()) / self.values.std()
        return _Known(correlation, self.axes.trend(columns), standard, scaled)

    @one_blas_thread()
    def predict(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of a new run at points (designs, axes): (designs,) each.

        The deviation holds the uncertainty of the mean function, and the noise of a run.
        """
        blocks = [self._block(block) for block in self._split(points)]
        mean, deviation = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
        return mean, deviation

    @one_blas_thread()
    def mean(self, points: np.ndarray) -> np.ndarray:
        """Mean alone of `predict`, (designs,)."""
        return np.concatenate([self._back(self._between(block)[0]) for block in self._split(points)])

    def _split(self, points: np.ndarray) -> list[np.ndarray]:
        size = max(AT_ONCE // len(self.values), 1)
        return np.split(points, range(size, len(points), size))

    def _between(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mean of the standardised values (designs,), correlation with the runs, and functions of the mean."""
        known, columns = self._known, self.axes.columns(points)
        between = matern(_squares(columns * np.exp(-self.log_lengths)[self.axes.owner], known.scaled))
        trend = self.axes.trend(columns)
        return trend @ known.weights + between @ known.residual, between, trend

    def _block(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        known = self._known
        mean, between, trend = self._between(points)
        inner = known.whitener @ between.T
        away = trend - inner.T @ known.whitened_trend
        lost = known.trend_whitener @ away.T
        noise = 1.0 + np.exp(self.log_nugget) + JITTER
        variance = known.variance * (noise - np.square(inner).sum(axis=0) + np.square(lost).sum(axis=0))
        return self._back(mean), np.sqrt(np.maximum(variance, 0.0)) * self.values.std()

    def _back(self, standard: np.ndarray) -> np.ndarray:
        return standard * self.values.std() + self.values.mean()

    @one_blas_thread()
    def leave_one_out(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation at each run by the others, with lengths, nugget and variance as they are: (runs,) each.

        In closed form (Dubrule, Mathematical Geology 15 (1983) 687-699): with P of the restricted likelihood the error
        is (P y)_i / P_ii.
        """
        known = self._known
        diagonal = np.diag(known.projection)
        error = known.projection @ known.standard / diagonal
        deviation = np.sqrt(known.variance / diagonal) * self.values.std()
        return self.values - error * self.values.std(), deviation


class _Known:
    """What of a process does not depend on the question."""

    def __init__(self, correlation: np.ndarray, trend: np.ndarray, standard: np.ndarray, scaled: np.ndarray):
        # NumPy alone: SciPy brings a BLAS of its own, whose threads wait for each other on matrices as small as these.
        self.standard, self.scaled = standard, scaled
        lower = np.linalg.cholesky(correlation)
        self.whitener = np.linalg.inv(lower)
        self.whitened_trend = self.whitener @ trend
        normal = self.whitened_trend.T @ self.whitened_trend
        trend_lower = np.linalg.cholesky(normal)
        self.trend_whitener = np.linalg.inv(trend_lower)
        self.inverse = self.whitener.T @ self.whitener
        spanned = self.trend_whitener @ (trend.T @ self.inverse)
        self.projection = self.inverse - spanned.T @ spanned
        self.residual = self.projection @ standard
        self.weights = self.trend_whitener.T @ (spanned @ standard)
        self.variance = max(float(standard @ self.residual) / (len(trend) - trend.shape[1]), LEAST_VARIANCE)
        self.log_determinants = 2.0 * np.log(np.diag(lower)).sum() + 2.0 * np.log(np.diag(trend_lower)).sum()


def _squares(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Squared distances (n, m) of rows."""
    found = np.square(one).sum(axis=1)[:, None] + np.square(other).sum(axis=1) - 2.0 * (one @ other.T)
    return np.maximum(found, 0.0)


def matern(squares: np.ndarray) -> np.ndarray:
    """Matern 5/2 correlation at squared distances over lengths (Rasmussen and Williams, equation 4.17)."""
    third = (5.0 / 3.0) * squares
    r = np.sqrt(5.0 * squares)
    decay = np.exp(-r)
    r += third
    r += 1.0
    r *= decay
    return r


def _objective(logs: np.ndarray, squares: np.ndarray, trend: np.ndarray, standard: np.ndarray):
    """Negative log of restricted likelihood and priors, and its slope. squares: (axes, runs, runs), not scaled."""
    scaled = squares * np.exp(-2.0 * logs[:-1])[:, None, None]
    r = np.sqrt(5.0 * scaled.sum(axis=0))
    decay = np.exp(-r)
    correlation = (1.0 + r + r * r / 3.0) * decay
    nugget = np.exp(logs[-1])
    correlation[np.diag_indices(len(standard))] += nugget + JITTER
    try:
        known = _Known(correlation, trend, standard, trend)
    except np.linalg.LinAlgError:
        return 1e10, np.zeros_like(logs)
    free = len(standard) - trend.shape[1]
    value = 0.5 * (free * np.log(known.variance) + known.log_determinants)
    away = np.append((logs[:-1] - LOG_LENGTH[0]) / LOG_LENGTH[1], (logs[-1] - LOG_NUGGET[0]) / LOG_NUGGET[1])
    # d(log likelihood)/dt = (trace(P dK) - a' dK a / variance) / 2, a = P y; dK/dlog(length) = (1+r) exp(-r) 5 d^2/3
    sensitivity = known.projection - np.outer(known.residual, known.residual) / known.variance
    slope = np.append(
        0.5 * np.einsum("ij,kij->k", sensitivity * (1.0 + r) * decay * (5.0 / 3.0), scaled),
        0.5 * nugget * np.trace(sensitivity),
    )
    deviations = np.append(np.full(len(logs) - 1, LOG_LENGTH[1]), LOG_NUGGET[1])
    return value + 0.5 * float(away @ away), slope + away / deviations
