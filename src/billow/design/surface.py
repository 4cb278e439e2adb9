"""The surface of one response over the design space: value, interval, and a verdict that folds over the runs give."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
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

COMMON = 2.0
"""Times the median deviation of runs held out that every deviation has in common (docs/design.md, How a surface is
made)."""
CHECKED = 0.9
"""Level of the intervals that are asked whether they hold runs held out."""
HOLDS = 0.86
"""Share of runs that these must not surely miss, for a surface to be usable."""
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
    in the response's unit; runs: that it was made of; asked, held: runs that it had not seen, in folds and beside them,
    and how many of these lie in intervals of `CHECKED` that had not seen them either
    """

    word: str
    why: str
    q2: float
    rmse: float
    runs: int
    asked: int = 0
    held: int = 0

    @property
    def usable(self) -> bool:
        """Whether optimum, sensitivity and robustness may be asked of it."""
        return self.word != "not usable"

    @property
    def coverage(self) -> tuple[float, float]:
        """Ends between which the share of all runs in intervals of `CHECKED` lies, with 95 % (Clopper and Pearson,
        Biometrika 26 (1934) 404-413)."""
        from scipy.special import betaincinv

        missed = self.asked - self.held
        low = betaincinv(self.held, missed + 1, 0.025) if self.held else 0.0
        return float(low), float(betaincinv(self.held + 1, missed, 0.975)) if missed else 1.0

    @property
    def share(self) -> str:
        """How many runs lay in intervals of `CHECKED`, in words; empty without intervals."""
        low, high = (100.0 * end for end in self.coverage)
        return f"{self.held} of {self.asked} runs ({low:.0f} to {high:.0f} %)" if self.asked else ""

    def __str__(self) -> str:
        told = [self.word] + [f"Q2 {self.q2:.3f}"] * math.isfinite(self.q2)
        told += [f"{100 * CHECKED:.0f} % intervals held {self.share}"] * bool(self.asked)
        return f"{', '.join(told)}{f'; {self.why}' if self.why else ''}"


@dataclass(frozen=True, eq=False)
class Surface:
    """process: of the scaled values, None if there is no surface; scale: key of `SCALES`; factors: (levels,), half
    width of an interval over the deviation; verdict; held_out: (runs, 2), each run's value, and that predicted without
    it; common: deviation that is added everywhere, in squares, to that of the process, on the scale; fold: (runs,), the
    one that each run belongs to; folds: processes of the runs without each fold"""

    process: GaussianProcess | None
    scale: str
    factors: np.ndarray
    verdict: Verdict
    held_out: np.ndarray
    common: float = 0.0
    fold: np.ndarray = field(default_factory=lambda: np.empty(0, int))
    folds: tuple[GaussianProcess, ...] = ()

    def interval(self, points: np.ndarray, level: float = 0.9) -> np.ndarray:
        """Value and both ends of its interval, (designs, 3). points: (designs, axes) in [0, 1]."""
        mean, deviation = self.distribution(points, level)
        half = _normal(level) * deviation
        return np.stack([SCALES[self.scale].back(mean + side * half) for side in (0.0, -1.0, 1.0)], axis=1)

    def value(self, points: np.ndarray) -> np.ndarray:
        """(designs,): the median."""
        return SCALES[self.scale].back(self.process.mean(points))

    def distribution(self, points: np.ndarray, level: float = CHECKED) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of the scaled response, (designs,) each: of the normal distribution with the
        interval of a level.

        The deviation has two parts. One is that of the process, as wide as its errors on runs held out. The other is
        how far processes that miss a fold of the runs lie apart: what the lengths hang on shows there, place by place.
        """
        mean, deviation = self.process.predict(points)
        factor = self.factors[LEVELS.index(level)] / _normal(level)
        apart = np.std([process.mean(points) for process in self.folds], axis=0)
        return mean, np.hypot(factor * np.hypot(deviation, self.common), apart)

    def scaled(self, value: float) -> float:
        """A value of the response on its scale; what lies below all values of the scale is minus infinity."""
        if (self.scale == "log" and value <= 0.0) or (self.scale == "root" and value < 0.0):
            return -np.inf
        return float(SCALES[self.scale].forward(value))


def learn(
    axes: Axes,
    points: np.ndarray,
    values: np.ndarray,
    groups: list[list[int]],
    scale: str = "auto",
    unseen: tuple[np.ndarray, np.ndarray] | None = None,
) -> Surface:
    """The surface of a response.

    points: (runs, axes) in [0, 1]; values: (runs,), NaN for what did not happen; groups: rows of the same design
    together, which are held out together; scale: key of `SCALES`, or auto for the one with the least errors in folds;
    unseen: points and values of runs that are not learned from, to ask the intervals
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
    fold = np.empty(len(values), int)
    for number, group in enumerate(groups := [group for group in groups if group]):
        fold[group] = number % FOLDS
    whole = {name: GaussianProcess.fit(axes, points, SCALES[name].forward(values)) for name in _scales(values, scale)}
    tried = {name: _without(process, fold) for name, process in whole.items()}
    found = {name: _held_out(processes, points, fold) for name, processes in tried.items()}
    best = min(found, key=lambda name: _rmse(SCALES[name].back(found[name][:, 0]), values))
    mean, deviation = found[best].T
    common = COMMON * float(np.median(deviation))
    ratio = np.abs(mean - SCALES[best].forward(values)) / np.hypot(deviation, common)
    factors = np.array([_quantile(ratio, level) for level in LEVELS])
    predicted = SCALES[best].back(mean)
    q2 = 1.0 - float(np.square(predicted - values).sum() / np.square(values - values.mean()).sum())
    word = "usable" if q2 >= USABLE else "indicative" if q2 >= INDICATIVE else "not usable"
    why = remark if word != "not usable" else f"on runs held out it explains {max(q2, 0.0):.0%} of the variance"
    verdict = Verdict(word, why, q2, _rmse(predicted, values), len(values))
    held_out = np.column_stack([values, predicted])
    surface = Surface(whole[best], best, factors, verdict, held_out, common, fold, tuple(tried[best]))
    return replace(surface, verdict=_asked(surface, ratio, unseen))


def _asked(surface: Surface, ratio: np.ndarray, unseen) -> Verdict:
    """The verdict with what intervals hold: runs of a fold by the factor that the other folds give, and unseen runs.
    ratio: (runs,), error over deviation of each run held out."""
    asked, held = len(ratio), 0
    for number in range(len(surface.folds)):
        within = surface.fold == number
        held += int((ratio[within] <= _quantile(ratio[~within], CHECKED)).sum())
    if unseen is not None:
        points, values = (part[~np.isnan(unseen[1])] for part in unseen)
        if len(values):
            _, low, high = surface.interval(points, CHECKED).T
            asked, held = asked + len(values), held + int(((low <= values) & (values <= high)).sum())
    verdict = replace(surface.verdict, asked=asked, held=held)
    if verdict.word == "usable" and verdict.coverage[1] < HOLDS:
        why = f"intervals miss more than they say{f'; {verdict.why}' if verdict.why else ''}"
        verdict = replace(verdict, word="indicative", why=why)
    return verdict


def _quantile(ratio: np.ndarray, level: float) -> float:
    """What a further ratio lies below with the chance of a level, if it is one of their kind (conformal prediction:
    Vovk, Gammerman and Shafer, Algorithmic Learning in a Random World, 2005); between two of them linear."""
    place = min((len(ratio) + 1) * level, len(ratio))
    return float(np.interp(place, np.arange(1, len(ratio) + 1), np.sort(ratio)))


def _normal(level: float) -> float:
    """Half width of an interval of the normal distribution over its deviation."""
    from scipy.special import ndtri

    return float(ndtri(0.5 + 0.5 * level))


def _without(whole: GaussianProcess, fold: np.ndarray) -> list[GaussianProcess]:
    """A process of the runs without each fold, lengths and nugget fitted again."""
    kept = [fold != number for number in range(fold.max() + 1)]
    return [GaussianProcess.fit(whole.axes, whole.points[rows], whole.values[rows], like=whole) for rows in kept]


def _held_out(processes: list[GaussianProcess], points: np.ndarray, fold: np.ndarray) -> np.ndarray:
    """(runs, 2): mean and deviation of each run's scaled value by the process without its fold."""
    found = np.empty((len(points), 2))
    for number, process in enumerate(processes):
        found[fold == number] = np.stack(process.predict(points[fold == number]), axis=1)
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
