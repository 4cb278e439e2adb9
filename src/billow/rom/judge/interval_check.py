"""How many unseen values the intervals cover."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.rom.learn.dataset import Dataset, read_run
from billow.rom.surrogate.surrogate import Surrogate


@dataclass(frozen=True)
class IntervalCheck:
    """Intervals of one level on unseen runs.

    level: [-]; covered: [-], (3,), part of all values (runs, times, nodes) of x, y and z that lie inside
    by_run: [-], (runs, 3), the same for each run; half_width: [m], (3,), mean
    """

    level: float
    covered: np.ndarray
    by_run: np.ndarray
    half_width: np.ndarray

    @property
    def worst_run(self) -> np.ndarray:
        """[-], (3,): the smallest part of a run's values that lie inside."""
        return self.by_run.min(axis=0)


def check_intervals(surrogate: Surrogate, dataset: Dataset, runs: tuple[str, ...]) -> tuple[IntervalCheck, ...]:
    """One check for each calibrated level on `runs` of a dataset, read one after the other, twice; empty without
    intervals.

    A value counts if it can move at all: nodes that are held have no error, would be covered by any interval, and are
    left out.
    """
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
    return tuple(
        IntervalCheck(float(level), covered[place].mean(axis=0), covered[place], width[place])
        for place, level in enumerate(levels)
    )
