"""How far an answer may be off: intervals that contain the value of the solver, at a stated level. `scale` ranks values
by error; `quantiles` of held-out errors over it make it an interval (docs/theory.md, Intervals of a surrogate)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError

NO_SUCH_LEVEL = InputError.declare(
    "E-ROM-018",
    "there are no intervals of level {level:g}",
    where="level",
    why="levels are {known}",
    remedy="ask for one of these",
)

LEVELS = (0.5, 0.8, 0.9, 0.95)
FEWEST_RUNS = 8
"""Training runs below which intervals are not calibrated."""

_LOWEST, _HIGHEST, BINS = -6.0, 6.0, 6_000
"""Histogram of ln(|error|/s): bins of 0.2 %."""


@dataclass(frozen=True, eq=False)
class Intervals:
    """levels: [-], (levels,); factors: [-], (levels, 3), half width of an interval over its scale, for x, y and z
    lost_by_time: [m2], (3, times); lost_by_node: [m2], (3, nodes): mean square of what the basis cannot represent; by
        time also of what was not believed of the networks (rom/learn/shrinkage.py)
    """

    levels: np.ndarray
    factors: np.ndarray
    lost_by_time: np.ndarray
    lost_by_node: np.ndarray

    def factor(self, level: float) -> np.ndarray:
        """[-], (3,). InputError E-ROM-018 for a level that was not calibrated."""
        found = np.flatnonzero(np.isclose(self.levels, level))
        if not len(found):
            raise NO_SUCH_LEVEL(level=level, known=", ".join(f"{known:g}" for known in self.levels))
        return self.factors[found[0]]


def scale(surrogate, lost_by_time, lost_by_node, row, times, nodes=slice(None)) -> np.ndarray:
    """s of one design: [m], (times, nodes, 3) float32.

    row: (parameters,); times: [s], (times,); nodes: which
    lost_by_time: [m2], (3, trained times), linear in between; lost_by_node: [m2], (3, nodes)
    """
    members = surrogate.regression.by_member(row[None], times)[:, 0]
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


def quantiles(counts: np.ndarray) -> np.ndarray:
    """[-], (levels, 3), of histograms over ln(|error|/s) that each sum to one: (3, bins)."""
    edges = np.exp(np.linspace(_LOWEST, _HIGHEST, BINS + 1)[1:])
    cumulated = counts.cumsum(axis=1)
    found = [np.searchsorted(component, LEVELS).clip(max=BINS - 1) for component in cumulated]
    return np.stack([edges[index] for index in found], axis=1)


def histogram(error: np.ndarray, scales: np.ndarray) -> np.ndarray:
    """Part of the values, NaN not counted, in each bin of ln(|error|/s): (3, bins). Both: [m], (times, nodes, 3)."""
    counts = np.empty((3, BINS))
    for component in range(3):
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.log(np.abs(error[..., component]) / scales[..., component]).ravel()
        ratio = np.clip(ratio[~np.isnan(ratio)], _LOWEST, _HIGHEST)
        index = ((ratio - _LOWEST) * (BINS / (_HIGHEST - _LOWEST))).astype(int).clip(0, BINS - 1)
        counts[component] = np.bincount(index, minlength=BINS) / max(ratio.size, 1)
    return counts
