"""Whether intervals hold what they promise on unseen runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.rom.snapshots import Snapshots


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


def check_intervals(surrogate, unseen: Snapshots) -> tuple[IntervalCheck, ...]:
    """One check for each calibrated level; empty without intervals.

    A value counts if it can move at all: nodes that are held have no error, would be covered by any interval, and are
    left out.
    """
    if surrogate.intervals is None:
        return ()
    levels = surrogate.intervals.levels
    covered = np.zeros((len(levels), len(unseen.runs), 3))
    width = np.zeros((len(levels), 3))
    moving = [np.any(component != 0.0, axis=1) for component in unseen.matrices]
    moving = [nodes if nodes.any() else ~nodes for nodes in moving]  # a component that never moves counts as it is
    times = len(unseen.times)
    for run, design in enumerate(unseen.design):
        truth = unseen.matrices[:, :, run * times : (run + 1) * times].transpose(2, 1, 0)
        error = np.abs(surrogate.predict(design, extrapolate=True) - truth)
        for row, level in enumerate(levels):
            half = surrogate.half_width(design, level=level, extrapolate=True)
            for component, nodes in enumerate(moving):
                covered[row, run, component] = (error[:, nodes, component] <= half[:, nodes, component]).mean()
                width[row, component] += half[:, nodes, component].mean() / len(unseen.runs)
    return tuple(
        IntervalCheck(float(level), covered[row].mean(axis=0), covered[row], width[row])
        for row, level in enumerate(levels)
    )
