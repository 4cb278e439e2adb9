"""Injury metrics of a design, with how far each may be off (docs/coupled.md, Injury metrics of an answer).

A metric has two sources: the motion that the coupled model finds, and the values that the solver found in the training
runs, whose logarithm is fitted by a linear function of the design. A peak or HIC is easily lost in a learned motion, so
the source is chosen for each metric by its errors on runs that were held out. The same errors make the interval.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, norm

from billow.injury.criteria import GRAVITY, Injury
from billow.results.dataset_files import Parameter
from billow.rom.surrogate.design_space import to_unit
from billow.rom.surrogate.judgement import Comparison, Judgement

LEVEL = 0.9
"""Of all intervals of a coupled model: [-]."""

METRICS = {
    "hic15": "HIC15",
    "hic36": "HIC36",
    "clip_3ms_g": "3 ms clip [g]",
    "contiguous_clip_3ms_g": "3 ms clip, contiguous [g]",
    "peak_g": "peak [g]",
}
"""Keys of `injury_record` and how they are shown."""

MEAN_OF_RUNS = "mean of the training runs"
MOTION, RUNS = "from the motion", "fitted to the values of the training runs"
"""Sources of a metric."""

SMALLEST = 1e-6
"""A metric counts as at least this part of its largest value in the training runs: an untouched body has 0."""


def injury_record(injury: Injury) -> dict[str, float]:
    """Plain numbers: HIC in g^2.5 s, accelerations in g."""
    return {
        "hic15": injury.hic15.value,
        "hic36": injury.hic36.value,
        "clip_3ms_g": injury.clip / GRAVITY,
        "contiguous_clip_3ms_g": injury.contiguous_clip / GRAVITY,
        "peak_g": injury.peak / GRAVITY,
    }


def metric_values(injury: Injury) -> np.ndarray:
    """(metrics,), in the order of `METRICS`."""
    record = injury_record(injury)
    return np.array([record[name] for name in METRICS])


@dataclass(frozen=True)
class Estimate:
    """A metric, the ends of its interval of level `LEVEL`, None without, and its source.

    usable: False if, on runs it had not seen, it was no better than the mean of the training runs, or its intervals did
    not hold what they should
    """

    value: float
    low: float | None
    high: float | None
    source: str
    usable: bool


@dataclass(frozen=True, eq=False)
class LogLinear:
    """Logarithm of each metric as a linear function of the design, by least squares.

    weights: (1 + parameters, metrics); inverse: (1 + parameters, 1 + parameters), of the normal matrix
    """

    weights: np.ndarray
    inverse: np.ndarray

    @classmethod
    def fit(cls, designs: np.ndarray, logs: np.ndarray, parameters: tuple[Parameter, ...]) -> LogLinear:
        """designs: (runs, parameters); logs: (runs, metrics)."""
        rows = _rows(designs, parameters)
        inverse = np.linalg.pinv(rows.T @ rows)
        return cls(inverse @ rows.T @ logs, inverse)

    def __call__(self, design: np.ndarray, parameters: tuple[Parameter, ...]) -> tuple[np.ndarray, float]:
        """Logarithms of the metrics of one design, (metrics,), and the scale of their errors, sqrt(1 + leverage): the
        standard error of a new observation over that of one observation."""
        row = _rows(design[None], parameters)[0]
        return row @ self.weights, float(np.sqrt(1.0 + row @ self.inverse @ row))


def _rows(designs, parameters):
    return np.column_stack([np.ones(len(designs)), 2.0 * to_unit(designs, parameters) - 1.0])


@dataclass(frozen=True, eq=False)
class InjuryModel:
    """From a design, and the metrics of the motion found for it, to metrics with intervals.

    fit: of the training runs' own values; smallest: (metrics,), below which a value counts as this
    from_motion: (metrics,) bool, whether the motion is the source; factors: (metrics,), half width of the interval of
    the logarithm over its scale
    """

    fit: LogLinear
    smallest: np.ndarray
    from_motion: np.ndarray
    factors: np.ndarray

    def logs(self, values: np.ndarray) -> np.ndarray:
        """Natural logarithms of metrics: (..., metrics)."""
        return np.log(np.maximum(values, self.smallest))

    def __call__(self, design, values, parameters, lost: set[str]) -> dict[str, Estimate]:
        """design: (parameters,); values: (metrics,), of the motion; lost: shown names of metrics that are not usable"""
        fitted, scale = self.fit(design, parameters)
        centre = np.where(self.from_motion, self.logs(values), fitted)
        half = self.factors * np.where(self.from_motion, 1.0, scale)
        value, low, high = (np.exp(np.clip(logs, -700.0, 700.0)) for logs in (centre, centre - half, centre + half))
        sources = [MOTION if own else RUNS for own in self.from_motion]
        return {
            name: Estimate(float(value[k]), float(low[k]), float(high[k]), sources[k], shown not in lost)
            for k, (name, shown) in enumerate(METRICS.items())
        }


def least_factor(errors: np.ndarray, fitted: int = 0) -> np.ndarray:
    """The factor that makes intervals of `LEVEL` from held-out errors over their scale: (runs, ...) -> (...).

    The larger of two, for runs are few. The k-th smallest of n errors, k = (n + 1) level rounded up, holds for any
    distribution, on average over such sets of runs (split conformal prediction). The normal tolerance factor (root mean
    square, mean known to be 0) holds `LEVEL` of the answers in `CONFIDENCE` of such sets: ten errors that happen to be
    small must not make intervals that are too narrow. At least `FEWEST` runs.

    fitted: numbers that were fitted to the same runs, by which their errors are fewer than they seem
    """
    count, free = len(errors), max(len(errors) - fitted, 1)
    rank = int(np.ceil((count + 1) * LEVEL - 1e-9))
    tolerance = norm.ppf(0.5 + 0.5 * LEVEL) * np.sqrt(free / chi2.ppf(1.0 - CONFIDENCE, free))
    root_mean_square = np.sqrt(np.square(errors).mean(axis=0))
    return np.maximum(np.sort(np.abs(errors), axis=0)[rank - 1], tolerance * root_mean_square)


CONFIDENCE = 0.9
"""[-]"""
FEWEST = 9
"""Held-out runs from which an interval of 90 % can be made: of eight, not even the largest error is enough."""


def learn_injury(designs, values, held_out, parameters: tuple[Parameter, ...]) -> tuple[InjuryModel, list[Comparison]]:
    """A model of the metrics and how it does on runs held out.

    designs: (runs, parameters); values: (runs, metrics), of the solver
    held_out: of every fold, the rows of its runs, and the metrics of their motions by a model that had not seen them,
        (rows, metrics)
    """
    smallest = np.maximum(SMALLEST * values.max(axis=0), 1e-12)
    logs = np.log(np.maximum(values, smallest))
    errors: dict[str, list[np.ndarray]] = {MOTION: [], RUNS: [], MEAN_OF_RUNS: []}
    scales = []
    for rows, moved in held_out:
        others = np.setdiff1d(np.arange(len(values)), rows)
        fit = LogLinear.fit(designs[others], logs[others], parameters)
        for row, of_motion in zip(rows, moved, strict=True):
            fitted, scale = fit(designs[row], parameters)
            errors[MOTION].append(np.log(np.maximum(of_motion, smallest)) - logs[row])
            errors[RUNS].append(fitted - logs[row])
            errors[MEAN_OF_RUNS].append(logs[others].mean(axis=0) - logs[row])
            scales.append(scale)
    found = {source: np.array(of_one) for source, of_one in errors.items()}
    off = {source: np.sqrt(np.square(of_one).mean(axis=0)) for source, of_one in found.items()}
    from_motion = off[MOTION] < off[RUNS]
    of_runs = least_factor(found[RUNS] / np.array(scales)[:, None], fitted=1 + len(parameters))
    factors = np.where(from_motion, least_factor(found[MOTION]), of_runs)
    model = InjuryModel(LogLinear.fit(designs, logs, parameters), smallest, from_motion, factors)
    return model, compare(np.where(from_motion, off[MOTION], off[RUNS]), off[MEAN_OF_RUNS])


def compare(own: np.ndarray, mean: np.ndarray) -> list[Comparison]:
    """own, mean: (metrics,), root mean square errors of logarithms, of the model and of the mean of the runs."""
    percent = [100.0 * np.expm1(np.minimum(errors, 100.0)) for errors in (own, mean)]
    return [
        Comparison(f"{shown} is off by [%]", MEAN_OF_RUNS, float(a), float(b), ignores_design=True)
        for shown, a, b in zip(METRICS.values(), *percent, strict=True)
    ]


def compare_intervals(held: np.ndarray, runs: int) -> list[Comparison]:
    """held: (metrics,), how many of `runs` unseen values lie inside their intervals. Lost if their part is smaller than
    `LEVEL`: no metric is called usable whose intervals held less than they say, though chance may be the cause."""
    few = math.ceil(LEVEL * runs - 1e-9) - 1
    answer = f"least for {100 * LEVEL:.0f} % intervals"
    return [
        Comparison(f"{shown} inside its interval [%]", answer, 100.0 * n / runs, 100.0 * few / runs, False, True)
        for shown, n in zip(METRICS.values(), held.tolist(), strict=True)
    ]


def not_usable(judgement: Judgement) -> set[str]:
    """Shown names of the metrics that lost a comparison."""
    measures = [one.measure for one in judgement.lost]
    return {shown for shown in METRICS.values() if any(measure.startswith(f"{shown} i") for measure in measures)}
