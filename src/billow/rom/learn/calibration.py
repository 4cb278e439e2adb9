"""From the scale of an error to an interval: factors found on runs that the networks have not seen, held out in folds
(docs/theory.md, Intervals of a surrogate)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from billow.rom.learn.dataset import Dataset, read_run
from billow.rom.learn.reduction import Reduction
from billow.rom.surrogate.intervals import LEVELS, scale
from billow.rom.surrogate.surrogate import Surrogate

FOLDS = 4
ENOUGH_RUNS = 60
"""Folds are left out once this many runs have been held out: they would add less than their training costs."""

_MOST_NODES = 2_000
"""Nodes whose errors are counted: every n-th one of a larger mesh, because neighbours have the same errors."""

_LOWEST, _HIGHEST, _BINS = -6.0, 6.0, 6_000
"""Histogram of ln(|error|/s): bins of 0.2 %."""


def held_out(runs: tuple[str, ...]) -> list[tuple[str, ...]]:
    """The runs that are held out together, fold by fold."""
    folds = [runs[fold::FOLDS] for fold in range(FOLDS)]
    enough = next((n for n in range(1, FOLDS) if sum(map(len, folds[:n])) >= ENOUGH_RUNS), FOLDS)
    return folds[:enough]


def calibrate(
    dataset: Dataset, runs: tuple[str, ...], learn: Callable[[tuple[str, ...]], tuple[Surrogate, Reduction]]
) -> np.ndarray:
    """Factors for `LEVELS`: [-], (levels, 3). runs: names, at least `FEWEST_RUNS`; learn(runs): a surrogate and its
    Reduction, learned from these alone."""
    counts, scored = np.zeros((3, _BINS)), 0
    for fold in held_out(runs):
        surrogate, reduction = learn(tuple(run for run in runs if run not in fold))
        every = slice(None, None, -(-surrogate.nodes // _MOST_NODES))
        for run in fold:
            design, truth = dataset.design([run])[0], read_run(dataset, run)[:, every]
            scales = scale(surrogate, reduction.lost_by_time, reduction.lost_by_node, design, surrogate.times, every)
            error = surrogate.predict(design, extrapolate=True)[:, every] - truth
            # A held node would be covered by any interval, so it does not count.
            counts += histogram(np.where(np.any(truth != 0.0, axis=0), error, np.nan), scales)
        scored += len(fold)
    return quantiles(counts / scored)


def quantiles(counts: np.ndarray) -> np.ndarray:
    """[-], (levels, 3), of histograms over ln(|error|/s) that each sum to one: (3, bins)."""
    edges = np.exp(np.linspace(_LOWEST, _HIGHEST, _BINS + 1)[1:])
    cumulated = counts.cumsum(axis=1)
    found = [np.searchsorted(component, LEVELS).clip(max=_BINS - 1) for component in cumulated]
    return np.stack([edges[index] for index in found], axis=1)


def histogram(error: np.ndarray, scales: np.ndarray) -> np.ndarray:
    """Part of the values, NaN not counted, in each bin of ln(|error|/s): (3, bins). error, scales: [m], (times, nodes,
    3)."""
    counts = np.empty((3, _BINS))
    for component in range(3):
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.log(np.abs(error[..., component]) / scales[..., component]).ravel()
        ratio = np.clip(ratio[~np.isnan(ratio)], _LOWEST, _HIGHEST)
        index = ((ratio - _LOWEST) * (_BINS / (_HIGHEST - _LOWEST))).astype(int).clip(0, _BINS - 1)
        counts[component] = np.bincount(index, minlength=_BINS) / max(ratio.size, 1)
    return counts
