"""The surface of one response over the design space: value, interval, and a verdict that folds over the runs give."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from billow.design.gaussian_process import Axes, GaussianProcess

LEVELS = (0.5, 0.8, 0.9, 0.95)
"""Of intervals."""
USABLE, INDICATIVE = 0.9, 0.7
"""Q2 of the folds from which a surface is usable, and from which it shows a tendency."""
FOLDS = 8
FEWEST_RUNS = 12
MOST_RUNS = 2_000
MOST_NEVER = 0.1
"""Share of runs in which a response may not exist and still has a surface of the others."""
MOST_ALIKE = 0.2
"""Share of runs that may have one value, such as no contact, before there are two clouds and no surface."""

COMMON = 3.0
"""Times the median deviation of runs held out that every deviation has in common (docs/design.md, How a surface is
made)."""
ROOT = 0.4
"""Power of the scale "root": that which turns HIC into a velocity over the root of a time."""


class Scale(NamedTuple):
    """A function that is rising, and its inverse."""

    forward: object
    back: object


SCALES = {
    "identity": Scale(lambda y: y, lambda z: z),
    "log": Scale(np.log, lambda z: np.exp(np.minimum(z, 700.0))),
    "root": Scale(lambda y: y**ROOT, lambda z: np.maximum(z, 0.0) ** (1.0 / ROOT)),
}
"""A median, and the ends of an interval, are turned back by the inverse; a mean would not be."""


@dataclass(frozen=True)
class Verdict:
    """How a surface does on runs it had not seen, in folds.

    word: usable, indicative, or not usable; why: for "not usable", or a remark; q2: 1 - errors^2 over variance; rmse:
    in the response's unit; runs: that it was made of
    """

    word: str
    why: str
    q2: float
    rmse: float
    runs: int

    @property
    def usable(self) -> bool:
        """Whether optimum, sensitivity and robustness may be asked of it."""
        return self.word != "not usable"

    def __str__(self) -> str:
        told = f"{self.word}, Q2 {self.q2:.3f}" if math.isfinite(self.q2) else self.word
        return f"{told} ({self.why})" if self.why else told


@dataclass(frozen=True, eq=False)
class Surface:
    """process: of the scaled values, None if there is no surface; scale: key of `SCALES`; factors: (levels,), half
    width of an interval over the deviation; verdict; held_out: (runs, 2), each run's value, and that predicted without
    it; common: deviation that is added everywhere, in squares, to that of the process, on the scale"""

    process: GaussianProcess | None
    scale: str
    factors: np.ndarray
    verdict: Verdict
    held_out: np.ndarray
    common: float = 0.0

    def interval(self, points: np.ndarray, level: float = 0.9) -> np.ndarray:
        """Value and both ends of its interval, (designs, 3). points: (designs, axes) in [0, 1]."""
        mean, deviation = self._answer(points)
        half = self.factors[LEVELS.index(level)] * deviation
        return np.stack([SCALES[self.scale].back(mean + side * half) for side in (0.0, -1.0, 1.0)], axis=1)

    def value(self, points: np.ndarray) -> np.ndarray:
        """(designs,): the median."""
        return SCALES[self.scale].back(self.process.predict(points)[0])

    def distribution(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of the scaled response, (designs,) each, the latter as wide as folds found."""
        from scipy.special import ndtri

        mean, deviation = self._answer(points)
        return mean, deviation * self.factors[LEVELS.index(0.9)] / ndtri(0.95)

    def _answer(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        mean, deviation = self.process.predict(points)
        return mean, np.hypot(deviation, self.common)

    def scaled(self, value: float) -> float:
        """A value of the response on its scale; what lies below all values of the scale is minus infinity."""
        if (self.scale == "log" and value <= 0.0) or (self.scale == "root" and value < 0.0):
            return -np.inf
        return float(SCALES[self.scale].forward(value))


def learn(axes: Axes, points: np.ndarray, values: np.ndarray, groups: list[list[int]], scale: str = "auto") -> Surface:
    """The surface of a response.

    points: (runs, axes) in [0, 1]; values: (runs,), NaN for what did not happen; groups: rows of the same design
    together, which are held out together; scale: key of `SCALES`, or auto for the one with the least errors in folds
    """
    known = ~np.isnan(values)
    refusal, remark = _refusal(values, known)
    if refusal:
        return Surface(
            None, "identity", np.full(len(LEVELS), np.nan), _none(refusal, int(known.sum())), np.empty((0, 2))
        )
    kept = np.flatnonzero(known)
    place = {row: k for k, row in enumerate(kept)}
    groups = [[place[row] for row in group if row in place] for group in groups]
    points, values = points[kept], values[kept]
    folds = [np.array([row for group in groups[fold::FOLDS] for row in group], int) for fold in range(FOLDS)]
    folds = [fold for fold in folds if len(fold)]
    whole = {name: GaussianProcess.fit(axes, points, SCALES[name].forward(values)) for name in _scales(values, scale)}
    tried = {name: _held_out(process, folds) for name, process in whole.items()}
    best = min(tried, key=lambda name: _rmse(SCALES[name].back(tried[name][:, 0]), values))
    found = tried[best]
    truth = SCALES[best].forward(values)
    common = COMMON * float(np.median(found[:, 1]))
    ratio = np.sort(np.abs(found[:, 0] - truth) / np.hypot(found[:, 1], common))
    ranks = [min(math.ceil((len(ratio) + 1) * level - 1e-9), len(ratio)) for level in LEVELS]
    factors = np.array([ratio[rank - 1] for rank in ranks])
    predicted = SCALES[best].back(found[:, 0])
    q2 = 1.0 - float(np.square(predicted - values).sum() / np.square(values - values.mean()).sum())
    word = "usable" if q2 >= USABLE else "indicative" if q2 >= INDICATIVE else "not usable"
    why = remark if word != "not usable" else f"on runs held out it explains {max(q2, 0.0):.0%} of the variance"
    verdict = Verdict(word, why, q2, _rmse(predicted, values), len(values))
    return Surface(whole[best], best, factors, verdict, np.column_stack([values, predicted]), common)


def _held_out(whole: GaussianProcess, folds: list[np.ndarray]) -> np.ndarray:
    """(runs, 2): mean and deviation of each run's scaled value by a process that was fitted without its fold."""
    points, values, found = whole.points, whole.values, np.empty((len(whole.values), 2))
    for fold in folds:
        others = np.setdiff1d(np.arange(len(values)), fold)
        process = GaussianProcess.fit(whole.axes, points[others], values[others], like=whole)
        found[fold] = np.stack(process.predict(points[fold]), axis=1)
    return found


def _scales(values: np.ndarray, scale: str) -> list[str]:
    possible = ["identity"] + ["log"] * bool(values.min() > 0.0) + ["root"] * bool(values.min() >= 0.0)
    return possible if scale == "auto" or scale not in possible else [scale]


def _refusal(values: np.ndarray, known: np.ndarray) -> tuple[str, str]:
    """Why there can be no surface, or nothing; and a remark on one that there is."""
    never, count = int((~known).sum()), len(values)
    if never > MOST_NEVER * count:
        return f"it did not happen in {never} of {count} runs: two kinds of runs, no one surface", ""
    kept = values[known]
    if len(kept) < FEWEST_RUNS:
        return f"{len(kept)} runs are fewer than {FEWEST_RUNS}", ""
    if len(kept) > MOST_RUNS:
        return f"{len(kept)} runs are more than {MOST_RUNS}", ""
    if not np.ptp(kept) > 1e-9 * np.abs(kept).max():
        return f"it is {kept[0]:.6g} in all runs", ""
    alike = int(np.unique(kept, return_counts=True)[1].max())
    if alike > max(MOST_ALIKE * len(kept), 2):
        return f"{alike} of {len(kept)} runs have the same value: two kinds of runs, no one surface", ""
    return "", f"it did not happen in {never} of {count} runs, which are left out" if never else ""


def _none(why: str, runs: int) -> Verdict:
    return Verdict("not usable", why, float("nan"), float("nan"), runs)


def _rmse(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.sqrt(np.square(one - other).mean()))
