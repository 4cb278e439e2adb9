"""The reduced basis by the full singular value decomposition in float64: what the randomized one is held against."""

from __future__ import annotations

import numpy as np

from billow.rom.learn.pod import make_basis, sum_of_squares
from billow.rom.surrogate.basis import Basis


def exact_pod(snapshots: np.ndarray, modes: int) -> Basis:
    """As `pod`, 400 times slower at 10,000 x 20,000."""
    left, singular, _ = np.linalg.svd(snapshots.astype(float), full_matrices=False)
    return make_basis(left, singular, sum_of_squares(snapshots), modes)
