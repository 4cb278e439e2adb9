"""Injury criteria of an acceleration: HIC and the 3 ms clip.

Accelerations are given in m/s^2 and reported in g = 9.80665 m/s^2, as regulations do. Between samples a
curve is linear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.injury.curve import sample_interval

GRAVITY = 9.80665
"""Standard gravity: [m/s^2]."""

CLIP = 3e-3
"""[s] for which the 3 ms clip asks."""


@dataclass(frozen=True)
class HeadInjury:
    """Head injury criterion: value [-] (meaning g^2.5 s), start and end of its window [s]."""

    value: float
    start: float
    end: float


def head_injury(times: np.ndarray, acceleration: np.ndarray, longest: float) -> HeadInjury:
    """HIC = max (t2 - t1) [mean of a/g from t1 to t2]^2.5 over windows up to `longest` (49 CFR 571.208, S6.2).

    times: [s], (samples,), evenly spaced; acceleration: resultant [m/s^2], (samples,), filtered to CFC 1000; longest:
    [s], 0.015 for HIC15, 0.036 for HIC36

    The mean is a difference of the cumulated velocity, so the search costs samples times window, not its square.
    Windows begin or end at a sample; one of the longest allowed length that ends between two samples is counted too.
    Raises InputError E-INJ-001.
    """
    interval = sample_interval(times, acceleration)
    times, a = np.asarray(times, float), np.asarray(acceleration, float) / GRAVITY
    velocity = np.concatenate([[0.0], np.cumsum(0.5 * interval * (a[1:] + a[:-1]))])
    best = HeadInjury(0.0, float(times[0]), float(times[0]))

    def consider(value, starts, window):
        nonlocal best
        if len(value) and value.max() > best.value:
            first = int(value.argmax())
            best = HeadInjury(float(value[first]), float(starts[first]), float(starts[first] + window))

    samples = len(times)
    within = min(samples - 1, int(longest / interval * (1.0 + 1e-12)))
    for steps in range(1, within + 1):
        window = steps * interval
        consider(_hic(velocity[steps:] - velocity[:-steps], window), times, window)
    rest = longest - within * interval
    if within < samples - 1 and rest > 1e-9 * interval:
        inside = velocity[:-1] + rest * a[:-1] + 0.5 * rest * rest / interval * (a[1:] - a[:-1])  # after each sample
        consider(_hic(inside[within:] - velocity[: samples - 1 - within], longest), times, longest)
        before = velocity[1:] - (rest * a[1:] - 0.5 * rest * rest / interval * (a[1:] - a[:-1]))  # before each sample
        ends = velocity[within + 1 :]
        consider(_hic(ends - before[: len(ends)], longest), times[1:] - rest, longest)
    return best


def clip(times: np.ndarray, acceleration: np.ndarray, *, contiguous: bool, duration: float = CLIP) -> float:
    """Highest level that lasts for `duration`: [m/s^2]; 0 if the curve is shorter (SAE J885; ECE R94 for the head).

    times: [s], (samples,), evenly spaced; acceleration: resultant [m/s^2], (samples,), not negative
    contiguous: without interruption (the chest, 49 CFR 571.208 S6.3), else summed over all times above (the head)
    Raises InputError E-INJ-001.
    """
    interval = sample_interval(times, acceleration)
    a = np.asarray(acceleration, float)
    low, high = 0.0, float(a.max())
    if interval * (len(a) - 1) < duration or high <= 0.0:
        return 0.0
    while high - low > 1e-9 * high:  # time above a level never grows with the level
        middle = 0.5 * (low + high)
        above = _seconds_above(a, middle, interval)
        lasted = _longest_run(above, a > middle) if contiguous else above.sum()
        low, high = (middle, high) if lasted >= duration else (low, middle)
    return low


def _hic(gain, window):
    return window * np.maximum(gain / window, 0.0) ** 2.5


def _seconds_above(a, level, interval):
    """Time each interval between samples spends above a level: [s], (samples - 1,)."""
    start, stop = a[:-1] - level, a[1:] - level
    high, low = np.maximum(start, stop), np.minimum(start, stop)
    part = np.clip(high / np.where(high > low, high - low, 1.0), 0.0, 1.0)
    return interval * np.where(high > low, part, high > 0.0)


def _longest_run(above, sample_above):
    """Longest sum over intervals that join at samples above the level: [s]."""
    total = np.cumsum(above)
    # A run breaks at every inner sample that is not above.
    breaks = np.flatnonzero(~sample_above[1:-1])
    edges = np.concatenate([[0.0], total[breaks], total[-1:]])
    return np.diff(edges).max()
