"""How like two curves are: the objective rating of ISO/TS 18571 (docs/theory.md, Injury metrics).

The reference needs to be the test, the curve the model: exchanged, they rate differently.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.compiled import kernel
from billow.base.errors import InputError
from billow.injury.filters import sample_interval

UNUSABLE_REFERENCE = InputError.declare(
    "E-INJ-004",
    "the reference curve is too short or constant",
    where="ISO/TS 18571 rating",
    why="it lasts {duration:.3g} s and varies by {variation:.3g}",
    cause="an obstacle that was never touched",
    remedy="rate a curve that changes, over at least 2 ms",
)

INTERVAL = 1e-4
"""[s] between samples, as the standard demands."""

INNER, OUTER, CORRIDOR_EXPONENT = 0.05, 0.50, 2.0
LARGEST_SHIFT = 0.20
WARPING_WINDOW = 0.10
MAGNITUDE_LIMIT, SLOPE_LIMIT = 0.50, 2.0
SLOPE_WINDOW = 9
"""Parameters of the standard: half widths of the corridors over the largest reference value; shift and warping window
over the length of the curve; errors at which a score is 0; samples over which slopes are averaged."""

EQUAL = 1e-9
"""Part of a size below which a difference is rounding: of correlations, of the values of a constant curve."""

GRADES = ((0.94, "excellent"), (0.80, "good"), (0.58, "fair"))


@dataclass(frozen=True)
class Rating:
    """Scores of ISO/TS 18571: [-], 0 to 1. shift: [s] by which the curve comes late."""

    corridor: float
    phase: float
    magnitude: float
    slope: float
    shift: float

    @property
    def overall(self) -> float:
        """R = 0.4 Z + 0.2 (E_P + E_M + E_S)."""
        return 0.4 * self.corridor + 0.2 * (self.phase + self.magnitude + self.slope)

    @property
    def grade(self) -> str:
        """excellent, good, fair or poor."""
        return next((grade for limit, grade in GRADES if self.overall > limit), "poor")


def rate(times: np.ndarray, curve: np.ndarray, reference: np.ndarray) -> Rating:
    """Rating of a curve against a reference at the same times.

    times: [s], (samples,), evenly spaced; curve, reference: same unit, (samples,)
    Raises InputError E-INJ-001 if one is no curve, E-INJ-004 if the reference is constant or shorter than 2 ms.
    """
    sample_interval(times, curve)
    sample_interval(times, reference)
    samples = round((times[-1] - times[0]) / INTERVAL) + 1
    if samples <= 2 * SLOPE_WINDOW or _is_constant(reference):
        raise UNUSABLE_REFERENCE(duration=times[-1] - times[0], variation=np.ptp(reference))
    grid = times[0] + INTERVAL * np.arange(samples)
    curve, reference = np.interp(grid, times, curve), np.interp(grid, times, reference)
    shift = _best_shift(curve, reference)
    allowed = LARGEST_SHIFT * samples
    shifted, matched = _overlap(curve, reference, shift)
    return Rating(
        corridor=_corridor(curve, reference),
        phase=max(0.0, 1.0 - abs(shift) / allowed),
        magnitude=_magnitude(shifted, matched),
        slope=_score(_smooth_slope(shifted), _smooth_slope(matched), SLOPE_LIMIT),
        shift=shift * INTERVAL,
    )


def _corridor(curve, reference):
    away = np.abs(curve - reference) / np.abs(reference).max()
    between = np.clip((OUTER - away) / (OUTER - INNER), 0.0, 1.0)
    return float((between**CORRIDOR_EXPONENT).mean())


def _overlap(curve, reference, shift):
    """The parts of both that face each other once the curve is moved `shift` samples to earlier times."""
    count = len(curve) - abs(shift)
    return curve[max(shift, 0) :][:count], reference[max(-shift, 0) :][:count]


def _best_shift(curve, reference):
    """Shift [samples] of the best correlation, the smallest if several are equal."""
    best, found = _correlation(curve, reference), 0
    for size in range(1, int(LARGEST_SHIFT * len(curve) + EQUAL) + 1):
        for shift in (size, -size):
            correlation = _correlation(*_overlap(curve, reference, shift))
            if correlation > best + EQUAL:
                best, found = correlation, shift
    return found


def _correlation(one, other):
    if _is_constant(one) or _is_constant(other):
        return -1.0
    one, other = one - one.mean(), other - other.mean()
    size = np.sqrt((one @ one) * (other @ other))
    return one @ other / size


def _is_constant(curve):
    return np.ptp(curve) <= EQUAL * np.abs(curve).max()


def _magnitude(curve, reference):
    """Of samples matched by dynamic time warping: steps (1, 1), (1, 0), (0, 1) of equal weight, squared differences, no
    farther from the diagonal than a tenth of the length."""
    samples = len(curve)
    band = max(int(np.ceil(WARPING_WINDOW * samples - EQUAL)) - 1, 1)
    pairs, length = np.empty((2 * samples, 2), np.int64), np.zeros(1, np.int64)
    _warp(samples, np.ascontiguousarray(curve), np.ascontiguousarray(reference), band, pairs, length)
    return _score(curve[pairs[: length[0], 0]], reference[pairs[: length[0], 1]], MAGNITUDE_LIMIT)


@kernel
def _warp(n, curve, reference, band, path_out, length_out):
    # Only the band about the diagonal is kept: pair (i, j) stands in row i, column j - i + band + 1.
    cost = np.full((n + 1, 2 * band + 3), np.inf)
    cost[0, band + 1] = 0.0
    for i in range(1, n + 1):
        for j in range(max(1, i - band), min(n, i + band) + 1):
            k = j - i + band + 1
            nearest = min(cost[i - 1, k], cost[i - 1, k + 1], cost[i, k - 1])
            cost[i, k] = nearest + (curve[i - 1] - reference[j - 1]) ** 2
    i, j, count = n, n, 0
    while i > 0 and j > 0:
        path_out[count, 0], path_out[count, 1] = i - 1, j - 1
        count += 1
        k = j - i + band + 1
        both, one, other = cost[i - 1, k], cost[i - 1, k + 1], cost[i, k - 1]
        if both <= one and both <= other:
            i, j = i - 1, j - 1
        elif one <= other:
            i -= 1
        else:
            j -= 1
    length_out[0] = count


def _score(values, reference, limit):
    """1 for equal values, 0 from a relative error of `limit`."""
    error = np.abs(values - reference).sum() / np.abs(reference).sum()
    return float(max(0.0, 1.0 - error / limit))


def _smooth_slope(curve):
    """Central differences averaged over 9 samples, fewer near the ends: (samples,), unit of the curve per sample."""
    slope = np.gradient(curve)
    total = np.concatenate([[0.0], np.cumsum(slope)])
    middle = np.arange(len(slope))
    half = np.minimum(np.minimum(middle, middle[::-1]), SLOPE_WINDOW // 2)
    return (total[middle + half + 1] - total[middle - half]) / (2 * half + 1)
