"""How far an answer may be off: intervals that hold what the solver would have said, at a stated level.

Each predicted value has a scale of its own: the disagreement of the ensemble there and what the basis cannot say,

    s^2(t, node) = var over members of the field(t, node) + lost(t) lost(node) / mean(lost).

The scale ranks values by error but is too small as an error bar. It becomes an interval by a factor found on runs that
the networks have not seen (conformal prediction; Vovk, Gammerman and Shafer 2005): the runs are split into folds, for
each fold a surrogate learns from the others, and the factor is the quantile of |error|/s over the held-out values. All
values of a run are held out together, because neighbours in time and space are no new evidence, and every run counts
the same (pooled distribution of Dunn, Wasserman and Ramdas, J. Amer. Statist. Assoc. 118 (2023) 2491-2502).

Folds learn from fewer runs than the surrogate, so intervals come out somewhat too wide, which is the safe side; the
customary raise of the level for few runs is therefore left out. Measured: driver bag against a locked obstacle, 60
training runs, 30 unseen ones, nominal 90 %: 92, 92 and 94 % of the values of x, y and z are covered.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.rom.learn.snapshots import collect

LEVELS = (0.5, 0.8, 0.9, 0.95)
FOLDS = 4
ENOUGH_RUNS = 60
"""Folds are left out once this many runs have been held out: what they would add is not worth their training."""

FEWEST_RUNS = 8
_MOST_NODES = 2_000
"""Nodes whose errors are counted: every so-many-th one of a larger mesh; neighbours say the same."""

_LOWEST, _HIGHEST, _BINS = -6.0, 6.0, 6_000
"""Histogram of ln(|error|/s): bins of 0.2 %."""


@dataclass(frozen=True, eq=False)
class Intervals:
    """levels: [-], (levels,); factors: [-], (levels, 3), half width of an interval over its scale, for x, y and z
    lost_by_time: [m2], (3, times); lost_by_node: [m2], (3, nodes): mean square of what the basis cannot say
    """

    levels: np.ndarray
    factors: np.ndarray
    lost_by_time: np.ndarray
    lost_by_node: np.ndarray

    def factor(self, level: float) -> np.ndarray:
        """[-], (3,). InputError E-ROM-018 for a level that was not calibrated."""
        found = np.flatnonzero(np.isclose(self.levels, level))
        if not len(found):
            raise InputError(
                "E-ROM-018",
                f"there are no intervals of level {level:g}",
                where="level",
                why=f"levels are {', '.join(f'{known:g}' for known in self.levels)}",
                remedy="ask for one of these",
            )
        return self.factors[found[0]]


def scale(surrogate, lost_by_time, lost_by_node, row, times, further=None, nodes=slice(None)) -> np.ndarray:
    """s of one design: [m], (times, nodes, 3) float32.

    row: (parameters,); times: [s], (times,); further: (1, times, further) or None; nodes: which
    lost_by_time: [m2], (3, trained times), linear in between; lost_by_node: [m2], (3, nodes)
    """
    members = surrogate.regression.by_member(row[None], times, further)[:, 0]
    away = (members - members.mean(axis=0)).reshape(len(members), len(times), 3, -1)
    answer = np.empty((len(times), lost_by_node[:, nodes].shape[1], 3), np.float32)
    for component, basis in enumerate(surrogate.bases):
        modes = basis.modes[:, nodes]
        variance = sum(np.square(member[:, component] @ modes) for member in away) / max(len(members) - 1, 1)
        lost = np.interp(times, surrogate.times, lost_by_time[component])
        mean = lost_by_node[component].mean()
        if mean > 0.0:
            variance += np.outer(lost, lost_by_node[component, nodes] / mean).astype(np.float32)
        answer[:, :, component] = np.sqrt(variance)
    return answer


def held_out(runs: tuple[str, ...]) -> list[tuple[str, ...]]:
    """The runs that are held out together, fold by fold."""
    folds = [runs[fold::FOLDS] for fold in range(FOLDS)]
    enough = next((n for n in range(1, FOLDS) if sum(map(len, folds[:n])) >= ENOUGH_RUNS), FOLDS)
    return folds[:enough]


def calibrate(dataset, runs: tuple[str, ...], learn: Callable) -> np.ndarray:
    """Factors for `LEVELS`: [-], (levels, 3).

    runs: names, at least `FEWEST_RUNS`; learn(runs): a surrogate and its Reduction, learned from these alone
    """
    counts, scored = np.zeros((3, _BINS)), 0
    for fold in held_out(runs):
        surrogate, reduction = learn(tuple(run for run in runs if run not in fold))
        for run in fold:
            counts += _scores(surrogate, reduction, collect(dataset, [run]))
        scored += len(fold)
    return quantiles(counts / scored)


def quantiles(counts: np.ndarray) -> np.ndarray:
    """[-], (levels, 3), of histograms over ln(|error|/s) that each sum to one: (3, bins)."""
    edges = np.exp(np.linspace(_LOWEST, _HIGHEST, _BINS + 1)[1:])
    cumulated = counts.cumsum(axis=1)
    found = [np.searchsorted(component, LEVELS).clip(max=_BINS - 1) for component in cumulated]
    return np.stack([edges[index] for index in found], axis=1)


def histogram(error: np.ndarray, scales: np.ndarray) -> np.ndarray:
    """Part of the values in each bin of ln(|error|/s): (3, bins). error, scales: [m], (times, nodes, 3).

    Values that are NaN do not count.
    """
    counts = np.empty((3, _BINS))
    for component in range(3):
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.log(np.abs(error[..., component]) / scales[..., component]).ravel()
        ratio = np.clip(ratio[~np.isnan(ratio)], _LOWEST, _HIGHEST)
        index = ((ratio - _LOWEST) * (_BINS / (_HIGHEST - _LOWEST))).astype(int).clip(0, _BINS - 1)
        counts[component] = np.bincount(index, minlength=_BINS) / max(ratio.size, 1)
    return counts


def _scores(surrogate, reduction, unseen) -> np.ndarray:
    every = slice(None, None, -(-surrogate.nodes // _MOST_NODES))
    row = unseen.design[0]
    scales = scale(surrogate, reduction.lost_by_time, reduction.lost_by_node, row, surrogate.times, nodes=every)
    truth = unseen.matrices[:, every].transpose(2, 1, 0)
    error = surrogate.predict(row, extrapolate=True)[:, every] - truth
    # A node that is held would be covered by any interval: it says nothing.
    return histogram(np.where(np.any(truth != 0.0, axis=0), error, np.nan), scales)
