"""What more training runs would buy: the error against their number, as a power law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LearningCurve:
    """error = scale * runs^-rate, fitted to measured errors.

    runs: (sizes,); errors: [m], (sizes,), mean RMSE on unseen runs; rate: [-]; scale: [m]
    """

    runs: tuple[int, ...]
    errors: tuple[float, ...]
    rate: float
    scale: float

    @property
    def doubled(self) -> float:
        """Expected error with twice the runs, from the last measured error rather than from the fit: [m]."""
        return self.errors[-1] * 2.0**-self.rate


def fit(runs, errors) -> LearningCurve | None:
    """Least squares in logarithms. runs: (sizes,); errors: [m], (sizes,). None with fewer than two sizes or an error 0.

    Learning curves of deep networks are power laws over wide ranges (Hestness et al. 2017, arXiv:1712.00409).
    """
    runs, errors = np.asarray(runs, float), np.asarray(errors, float)
    if len(runs) < 2 or not (errors > 0.0).all():
        return None
    slope, offset = np.polyfit(np.log(runs), np.log(errors), 1)
    return LearningCurve(tuple(map(int, runs)), tuple(errors.tolist()), float(-slope), float(np.exp(offset)))
