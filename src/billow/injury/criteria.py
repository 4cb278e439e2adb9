"""Injury criteria of an acceleration, linear between samples, and of a body's motion: HIC and the 3 ms clip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.injury.filters import channel_filter, sample_interval

NO_FREE_OBSTACLE = InputError.declare(
    "E-INJ-005",
    "the run has no free obstacle",
    where="{folder}",
    why="a locked obstacle has no acceleration",
    remedy="set obstacles.impactor.locked to false, or obstacles of another name, and run again",
)

GRAVITY = 9.80665
"""Standard gravity: [m/s^2]."""
CLIP = 3e-3
"""[s] for which the 3 ms clip asks."""
HEAD_CLASS = 1000
"""Channel frequency class of head acceleration (SAE J211-1)."""


@dataclass(frozen=True)
class HeadInjury:
    """Head injury criterion: value [-] (meaning g^2.5 s), start and end of its window [s]."""

    value: float
    start: float
    end: float


@dataclass(frozen=True)
class Injury:
    """Of one body, taken as a head: resultant acceleration of its centre, filtered to CFC 1000.

    hic15, hic36: head injury criterion over up to 15 and 36 ms
    clip, contiguous_clip: 3 ms clip, summed and without interruption [m/s^2]; peak: [m/s^2] at peak_time [s]
    """

    hic15: HeadInjury
    hic36: HeadInjury
    clip: float
    contiguous_clip: float
    peak: float
    peak_time: float


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

    def consider(gain, starts, window):
        nonlocal best
        value = window * np.maximum(gain / window, 0.0) ** 2.5
        if len(value) and value.max() > best.value:
            first = int(value.argmax())
            best = HeadInjury(float(value[first]), float(starts[first]), float(starts[first] + window))

    samples = len(times)
    within = min(samples - 1, int(longest / interval * (1.0 + 1e-12)))
    for steps in range(1, within + 1):
        window = steps * interval
        consider(velocity[steps:] - velocity[:-steps], times, window)
    rest = longest - within * interval
    if within < samples - 1 and rest > 1e-9 * interval:
        inside = velocity[:-1] + rest * a[:-1] + 0.5 * rest * rest / interval * (a[1:] - a[:-1])  # after each sample
        consider(inside[within:] - velocity[: samples - 1 - within], times, longest)
        before = velocity[1:] - (rest * a[1:] - 0.5 * rest * rest / interval * (a[1:] - a[:-1]))  # before each sample
        ends = velocity[within + 1 :]
        consider(ends - before[: len(ends)], times[1:] - rest, longest)
    return best


def clip(times: np.ndarray, acceleration: np.ndarray, *, contiguous: bool) -> float:
    """Highest level that lasts for `CLIP`: [m/s^2]; 0 if the curve is shorter (SAE J885; ECE R94 for the head).

    times: [s], (samples,), evenly spaced; acceleration: resultant [m/s^2], (samples,), not negative
    contiguous: without interruption (the chest, 49 CFR 571.208 S6.3), else summed over all times above (the head)
    Raises InputError E-INJ-001.
    """
    interval = sample_interval(times, acceleration)
    a = np.asarray(acceleration, float)
    low, high = 0.0, float(a.max())
    if interval * (len(a) - 1) < CLIP or high <= 0.0:
        return 0.0
    while high - low > 1e-9 * high:  # time above a level never grows with the level
        middle = 0.5 * (low + high)
        above = _seconds_above(a, middle, interval)
        lasted = _longest_run(above, a > middle) if contiguous else above.sum()
        low, high = (middle, high) if lasted >= CLIP else (low, middle)
    return low


def _seconds_above(a, level, interval):
    """Time each interval between samples spends above a level: [s], (samples - 1,)."""
    start, stop = a[:-1] - level, a[1:] - level
    high, low = np.maximum(start, stop), np.minimum(start, stop)
    part = np.clip(high / np.where(high > low, high - low, 1.0), 0.0, 1.0)
    return interval * np.where(high > low, part, high > 0.0)


def _longest_run(above, sample_above):
    """Longest sum over intervals that join at samples above the level: [s]."""
    total = np.cumsum(above)
    breaks = np.flatnonzero(~sample_above[1:-1])  # a run breaks at every inner sample that is not above
    edges = np.concatenate([[0.0], total[breaks], total[-1:]])
    return np.diff(edges).max()


def mean_acceleration(times: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middle of each interval [s], (samples - 1,), and mean acceleration over it [m/s^2], (samples - 1, ...).

    times: [s], (samples,), evenly spaced; velocity: [m/s], (samples, ...)

    A force sampled at an instant would fold contact chatter into the curve (docs/coupled.md, Injury metrics).
    Raises InputError E-INJ-001.
    """
    interval = sample_interval(times, velocity)
    times = np.asarray(times, float)
    return 0.5 * (times[1:] + times[:-1]), np.diff(np.asarray(velocity, float), axis=0) / interval


def assess(times: np.ndarray, velocity: np.ndarray) -> Injury:
    """Injury metrics of a body that moves at `velocity`: [m/s], (samples, 3), at times [s], (samples,). Raises
    InputError E-INJ-001 (no curve), E-INJ-003 (fewer than 10,000 samples per second)."""
    middles, acceleration = mean_acceleration(times, velocity)
    resultant = np.linalg.norm(channel_filter(middles, acceleration, HEAD_CLASS), axis=1)
    highest = int(resultant.argmax())
    return Injury(
        hic15=head_injury(middles, resultant, 0.015),
        hic36=head_injury(middles, resultant, 0.036),
        clip=clip(middles, resultant, contiguous=False),
        contiguous_clip=clip(middles, resultant, contiguous=True),
        peak=float(resultant[highest]),
        peak_time=float(middles[highest]),
    )


def assess_run(result) -> dict[str, Injury]:
    """Injury metrics of every free obstacle of a `Result`, from its histories. Raises InputError E-INJ-005 if the run
    has none, and the errors of `assess`."""
    bodies = result.free_obstacles
    if not bodies:
        raise NO_FREE_OBSTACLE(folder=result.folder)
    return {name: assess(result.histories.time, result.body(name).velocity) for name in bodies}
