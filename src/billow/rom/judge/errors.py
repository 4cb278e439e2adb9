"""Errors on unseen snapshots by the ROM paper's measure (equation 5), and how intervals cover them.

Their sources are truncation, what the best coefficients cannot represent, and regression, what wrong coefficients add.
Their squares add up, and both follow from coefficients (docs/theory.md, Reduced basis).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from billow.rom.learn.dataset import Dataset, read_run
from billow.rom.surrogate.basis import Basis
from billow.rom.surrogate.surrogate import Surrogate


def snapshot_rmse(predicted: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Root mean square over nodes of each component's error: [m], (..., nodes, 3) -> (..., 3) float64. This is
    RMSE_{i,l} inside paper equation 5."""
    return np.sqrt(np.square(predicted - truth).mean(axis=-2, dtype=float))


@dataclass(frozen=True)
class Summary:
    """The distribution of RMSE over unseen runs and times: [m]. `mean` is the paper's equation 5."""

    mean: float
    p10: float
    p90: float
    maximum: float

    @classmethod
    def of(cls, rmse: np.ndarray) -> Summary:
        """rmse: [m], (runs, times) of one component."""
        low, high = np.percentile(rmse, (10, 90))
        return cls(float(rmse.mean()), float(low), float(high), float(rmse.max()))


def accuracy(mean_rmse: float, reference_length: float) -> float:
    """The paper's accuracy (l_ref - RMSE) / l_ref: [-]. It flatters: standing still can score high too."""
    return (reference_length - mean_rmse) / reference_length


@dataclass(frozen=True, eq=False)
class Projection:
    """Some runs in a basis.

    nodes: number of them; known: [m], (runs, times, 3, modes) float32, the best coefficients
    outside: [m2], (runs, times, 3) float64, sum over nodes of the squares that all modes leave
    """

    known: np.ndarray
    outside: np.ndarray
    nodes: int

    def truncation(self, modes: int) -> np.ndarray:
        """RMSE over nodes with the first `modes` modes and the best coefficients: [m], (runs, times, 3)."""
        cut = np.square(self.known[..., modes:], dtype=float).sum(axis=3)
        return np.sqrt((self.outside + cut) / self.nodes)

    def regression(self, learned: np.ndarray, modes: int) -> np.ndarray:
        """RMSE over nodes that wrong coefficients alone make: [m], (runs, times, 3). learned: [m], (runs, times, 3, at
        least modes), predicted coefficients."""
        wrong = np.square(learned[..., :modes] - self.known[..., :modes], dtype=float).sum(axis=3)
        return np.sqrt(wrong / self.nodes)


def project(shapes: Iterable[np.ndarray], bases: tuple[Basis, ...]) -> Projection:
    """shapes: [m], displacement (times, nodes, 3) of each run, read one at a time."""
    known, outside = [], []
    for shape in shapes:
        components = [np.ascontiguousarray(shape[:, :, c].T) for c in range(3)]  # (nodes, times)
        pairs = list(zip(bases, components, strict=True))
        found = [basis.coefficients(component) for basis, component in pairs]
        rests = [c - basis.fields(a) for (basis, c), a in zip(pairs, found, strict=True)]
        known.append(np.stack([a.T for a in found], axis=1))
        outside.append(np.stack([np.square(rest).sum(axis=0, dtype=float) for rest in rests], axis=1))
    return Projection(np.stack(known), np.stack(outside), bases[0].modes.shape[1])


@dataclass(frozen=True, eq=False)
class ErrorsByModes:
    """RMSE over nodes of unseen snapshots, by one model judged with several numbers of modes: fewer modes are the first
    of more, and every coefficient has its own output.

    counts: numbers of modes, rising; the last is the number the model was trained with
    truncation, regression: [m], (counts, runs, times, 3)
    """

    counts: tuple[int, ...]
    truncation: np.ndarray
    regression: np.ndarray

    @classmethod
    def of(cls, counts: tuple[int, ...], unseen: Projection, learned: np.ndarray) -> ErrorsByModes:
        """learned: [m], (runs, times, 3, counts[-1]), predicted coefficients."""
        truncation = np.stack([unseen.truncation(count) for count in counts])
        return cls(counts, truncation, np.stack([unseen.regression(learned, count) for count in counts]))

    @property
    def rmse(self) -> np.ndarray:
        """[m], (counts, runs, times, 3), RMSE inside paper equation 5."""
        return np.hypot(self.truncation, self.regression)

    def summary(self, component: int, row: int = -1) -> Summary:
        """Distribution over unseen snapshots of one component, with `counts[row]` modes."""
        return Summary.of(self.rmse[row, :, :, component])

    def means(self, component: int) -> np.ndarray:
        """Mean over unseen snapshots for each number of modes: [m], (counts,)."""
        return self.rmse[..., component].mean(axis=(1, 2))


ENOUGH_RUNS = 24
"""Training runs from which a learning curve says what more would bring: with fewer, one run more or less decides."""


@dataclass(frozen=True)
class LearningCurve:
    """What more training runs would buy: error = scale [m] * runs^-rate [-], fitted to `errors` [m], (sizes,), the mean
    RMSE on unseen runs that was measured with `runs`, (sizes,)."""

    runs: tuple[int, ...]
    errors: tuple[float, ...]
    rate: float
    scale: float

    @property
    def tells(self) -> bool:
        """True if there is enough to go on: three sizes, up to `ENOUGH_RUNS`."""
        return len(self.runs) >= 3 and self.runs[-1] >= ENOUGH_RUNS

    @property
    def per_doubling(self) -> float:
        """Part by which twice as many runs lower the error: [-], negative if it grows."""
        return 1.0 - 2.0**-self.rate

    @property
    def doubled(self) -> float:
        """Expected error with twice the runs, from the last measured error rather than from the fit: [m]."""
        return self.errors[-1] * 2.0**-self.rate


def fit_learning_curve(runs, errors) -> LearningCurve | None:
    """Least squares in logarithms. runs: (sizes,); errors: [m], (sizes,). None with fewer than two sizes or an error 0.
    Learning curves of deep networks are power laws over wide ranges (Hestness et al. 2017, arXiv:1712.00409)."""
    runs, errors = np.asarray(runs, float), np.asarray(errors, float)
    if len(runs) < 2 or not (errors > 0.0).all():
        return None
    slope, offset = np.polyfit(np.log(runs), np.log(errors), 1)
    return LearningCurve(tuple(map(int, runs)), tuple(errors.tolist()), float(-slope), float(np.exp(offset)))


@dataclass(frozen=True)
class IntervalCheck:
    """Intervals of one level [-] on unseen runs: `by_run` [-], (runs, 3), is the part of each run's values of x, y, z
    that lie inside, `half_width` [m], (3,), the mean."""

    level: float
    by_run: np.ndarray
    half_width: np.ndarray

    @property
    def covered(self) -> np.ndarray:
        """[-], (3,): part of all values that lie inside."""
        return self.by_run.mean(axis=0)

    @property
    def worst_run(self) -> np.ndarray:
        """[-], (3,): the smallest part of a run's values that lie inside."""
        return self.by_run.min(axis=0)


def check_intervals(surrogate: Surrogate, dataset: Dataset, runs: tuple[str, ...]) -> tuple[IntervalCheck, ...]:
    """One check for each calibrated level on `runs` of a dataset, read one after the other, twice; empty without
    intervals. Nodes that are held would be covered by any interval, and are left out."""
    if surrogate.intervals is None:
        return ()
    levels = surrogate.intervals.levels
    covered = np.zeros((len(levels), len(runs), 3))
    width = np.zeros((len(levels), 3))
    moved = np.zeros((surrogate.nodes, 3), bool)
    for run in runs:
        moved |= np.any(read_run(dataset, run) != 0.0, axis=0)
    moved |= ~moved.any(axis=0)  # a component that never moves counts as it is
    for row, (run, design) in enumerate(zip(runs, dataset.design(runs), strict=True)):
        error = np.abs(surrogate.predict(design, extrapolate=True) - read_run(dataset, run))
        for place, level in enumerate(levels):
            half = surrogate.half_width(design, level=level, extrapolate=True)
            for component, nodes in enumerate(moved.T):
                covered[place, row, component] = (error[:, nodes, component] <= half[:, nodes, component]).mean()
                width[place, component] += half[:, nodes, component].mean() / len(runs)
    return tuple(IntervalCheck(float(level), *found) for level, *found in zip(levels, covered, width, strict=True))
