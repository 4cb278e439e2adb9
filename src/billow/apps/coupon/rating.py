"""How well a simulated test agrees with a measured one, and how much it ripples."""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_filter

WINDOW = 0.1
"""Share of a branch over which a ripple is told from the curve itself."""


def match(
    strain: np.ndarray, stress: np.ndarray, test_strain: np.ndarray, test_stress: np.ndarray
) -> tuple[float, float]:
    """Agreement of loading and of unloading, 1 for identical curves, 0 for an error as large as the curve itself.

    One minus the root mean square of the difference over that of the test, at the test's strains; nan for a branch the
    test does not have. Branches part at the largest strain.
    """
    scores = []
    for sim, test in zip(branches(strain), branches(test_strain), strict=True):
        if test.stop - test.start < 2:
            scores.append(float("nan"))
            continue
        order = np.argsort(strain[sim], kind="stable")
        simulated = np.interp(test_strain[test], strain[sim][order], stress[sim][order])
        error = np.sqrt(np.mean((simulated - test_stress[test]) ** 2)) / np.sqrt(np.mean(test_stress[test] ** 2))
        scores.append(float(max(0.0, 1.0 - error)))
    return scores[0], scores[1]


def branches(strain: np.ndarray) -> tuple[slice, slice]:
    """Loading up to the largest strain, unloading from there."""
    peak = int(np.argmax(strain))
    return slice(0, peak + 1), slice(peak, len(strain))


def ripple(strain: np.ndarray, stress: np.ndarray) -> tuple[float, float]:
    """Largest deviation of loading and of unloading from its own smooth course, over the largest stress [-].

    The smooth course is a quadratic fitted over a tenth of the branch about each sample (Savitzky and Golay, Anal.
    Chem. 36 (1964) 1627). Samples at the ends, where the machine turns, do not count.
    """
    largest = np.abs(stress).max()
    found = []
    for branch in branches(strain):
        values = stress[branch]
        window = max(5, 2 * int(0.5 * WINDOW * len(values)) + 1)
        if len(values) < 3 * window or largest == 0.0:
            found.append(float("nan"))
            continue
        rest = values - savgol_filter(values, window, 2)
        found.append(float(np.abs(rest[window:-window]).max() / largest))
    return found[0], found[1]
