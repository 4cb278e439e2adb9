"""The error measure of the ROM paper (equation 5) and its spread over unseen snapshots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


def snapshot_rmse(predicted: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Root mean square over nodes of each component's error: [m], (..., nodes, 3) -> (..., 3) float64.

    This is RMSE_{i,l} inside paper equation 5.
    """
    return np.sqrt(np.square(predicted - truth).mean(axis=-2, dtype=float))


@dataclass(frozen=True)
class Summary:
    """The distribution of RMSE over unseen runs and times: [m]. `mean` is the paper's equation 5."""

    mean: float
    p10: float
    p90: float
    maximum: float

    @classmethod
    def of(cls, rmse: np.ndarray) -> Summary:
        """rmse: [m], (runs, times) of one component."""
        low, high = np.percentile(rmse, (10, 90))
        return cls(float(rmse.mean()), float(low), float(high), float(rmse.max()))


def accuracy(mean_rmse: float, reference_length: float) -> float:
    """The paper's accuracy (l_ref - RMSE) / l_ref: [-]. It flatters: standing still can score high too."""
    return (reference_length - mean_rmse) / reference_length
