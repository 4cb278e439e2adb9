"""What more training runs would buy: the error against their number, as a power law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LearningCurve:
    """error = scale * runs^-rate, fitted to measured errors.

    runs: (sizes,); errors: [m], (sizes,), mean RMSE on unseen runs; rate: [-]; scale: [m]
    scatter: [-], standard deviation of ln(error) around the fit; NaN with two sizes, which any power law meets
    """

    runs: tuple[int, ...]
    errors: tuple[float, ...]
    rate: float
    scale: float
    scatter: float

    def at(self, runs: float) -> float:
        """Expected error with this many training runs: [m]. Beyond twice the largest size measured it is a guess."""
        return self.scale * runs**-self.rate

    def runs_for(self, error: float) -> float | None:
        """Training runs that the error [m] needs; None if errors do not fall with runs."""
        return (self.scale / error) ** (1.0 / self.rate) if self.rate > 0.0 else None


def fit(runs, errors) -> LearningCurve | None:
    """Least squares in logarithms. runs: (sizes,); errors: [m], (sizes,). None with fewer than two sizes or an error 0.

    Learning curves of deep networks are power laws over wide ranges (Hestness et al. 2017, arXiv:1712.00409).
    """
    runs, errors = np.asarray(runs, float), np.asarray(errors, float)
    if len(runs) < 2 or not (errors > 0.0).all():
        return None
    slope, offset = np.polyfit(np.log(runs), np.log(errors), 1)
    rest = np.log(errors) - (slope * np.log(runs) + offset)
    scatter = float(np.sqrt(np.square(rest).sum() / (len(runs) - 2))) if len(runs) > 2 else float("nan")
    return LearningCurve(tuple(map(int, runs)), tuple(errors.tolist()), float(-slope), float(np.exp(offset)), scatter)
