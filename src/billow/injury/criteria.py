"""Injury criteria of an acceleration, linear between samples, and of a body's motion: HIC and the 3 ms clip."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

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
FITS = 1e-8
"""Part of a window by which it may miss a length and still have it: times lose digits when they are far from zero."""
FEWEST_SAMPLES = 200
"""Samples between which windows are searched; curves of fewer get some in between."""
MOST_REFINED, FINEST = 30, 1e-5
"""Windows between samples that are refined, and the part of a sample interval at which that ends."""
HEAD_CLASS = 1000
"""Channel frequency class of head acceleration (SAE J211-1)."""


@dataclass(frozen=True)
class HeadInjury:
    """Head injury criterion: value [-] (meaning g^2.5 s), start and end of its window [s]."""

    value: float
    start: float
    end: float


@dataclass(frozen=True, eq=False)
class Injury:
    """Of one body, taken as a head, each found when it is asked for.

    times: [s], (samples,), evenly spaced; acceleration: resultant of its centre, filtered to CFC 1000 [m/s^2],
    (samples,)
    """

    times: np.ndarray
    acceleration: np.ndarray

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Injury) and all(
            np.array_equal(one, two)
            for one, two in ((self.times, other.times), (self.acceleration, other.acceleration))
        )

    @cached_property
    def hic15(self) -> HeadInjury:
        """Head injury criterion over up to 15 ms."""
        return head_injury(self.times, self.acceleration, 0.015)

    @cached_property
    def hic36(self) -> HeadInjury:
        """Head injury criterion over up to 36 ms."""
        return head_injury(self.times, self.acceleration, 0.036)

    @cached_property
    def clip(self) -> float:
        """3 ms clip, summed [m/s^2]."""
        return clip(self.times, self.acceleration, contiguous=False)

    @cached_property
    def contiguous_clip(self) -> float:
        """3 ms clip, without interruption [m/s^2]."""
        return clip(self.times, self.acceleration, contiguous=True)

    @property
    def peak(self) -> float:
        """[m/s^2]"""
        return float(self.acceleration.max())

    @property
    def peak_time(self) -> float:
        """[s]"""
        return float(self.times[self.acceleration.argmax()])


def head_injury(times: np.ndarray, acceleration: np.ndarray, longest: float) -> HeadInjury:
    """HIC = max (t2 - t1) [mean of a/g from t1 to t2]^2.5 over windows up to `longest` (49 CFR 571.208, S6.2).

    times: [s], (samples,), evenly spaced; acceleration: resultant [m/s^2], (samples,), filtered to CFC 1000; longest:
    [s], 0.015 for HIC15, 0.036 for HIC36

    The curve is linear between samples and windows begin and end anywhere: the best window between samples is found at
    first, then those of the longest length in closed form, then the shorter ones that are best among their neighbours
    are refined. So the answer is that of the curve and not of its sampling. Raises InputError E-INJ-001.
    """
    interval, a = sample_interval(times, acceleration), np.asarray(acceleration, float) / GRAVITY
    parts = -(-FEWEST_SAMPLES // len(a))
    a = np.interp(np.arange(parts * (len(a) - 1) + 1) / parts, np.arange(len(a)), a)
    curve = _Velocity(a, interval / parts)
    length = curve.interval * (curve.samples - 1)
    starts, ends = curve.best_between_samples(longest * (1.0 + FITS))
    first = curve.refined(starts, ends, min(longest, length))
    last = curve.best_of_length(min(longest, length))
    value, start, end = max(first, last)
    return HeadInjury(value, float(times[0]) + start, float(times[0]) + end)


class _Velocity:
    """Cumulated acceleration a [g] of evenly spaced samples; times count from the first sample."""

    def __init__(self, a: np.ndarray, interval: float):
        self.a, self.interval, self.samples = a, interval, len(a)
        self.v = np.concatenate([[0.0], np.cumsum(0.5 * interval * (a[1:] + a[:-1]))])

    def at(self, times: np.ndarray) -> np.ndarray:
        i = np.clip((times / self.interval).astype(int), 0, self.samples - 2)
        u = times - i * self.interval
        return self.v[i] + u * (self.a[i] + 0.5 * u / self.interval * (self.a[i + 1] - self.a[i]))

    def value(self, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """HIC of windows; zero where nothing is gained."""
        return _value(self.at(ends) - self.at(starts), ends - starts)

    def best(self, starts: np.ndarray, ends: np.ndarray) -> tuple[float, float, float]:
        """Value, start and end of the best of some windows."""
        values = self.value(starts, ends)
        k = int(values.argmax())
        return float(values[k]), float(starts[k]), float(ends[k])

    def best_between_samples(self, longest: float) -> tuple[np.ndarray, np.ndarray]:
        """Windows from sample to sample that are no worse than those one sample longer, shorter, earlier or later."""
        within = min(self.samples - 1, int(longest / self.interval))
        rows = [np.full(self.samples + 2, -1.0) for _ in range(3)]  # one sample shorter, this length, one longer
        found: list[tuple[float, int, int]] = []
        for steps in range(1, within + 2):
            if steps <= within:
                rows[2][1 : self.samples - steps + 1] = _value(self.v[steps:] - self.v[:-steps], steps * self.interval)
            shorter, here, longer = rows
            peaks = here[1:-1] > 0.0
            for other in (shorter[1:-1], shorter[2:], longer[1:-1], longer[:-2], here[:-2], here[2:]):
                peaks &= here[1:-1] >= other
            found += [(here[i + 1], i, i + steps - 1) for i in np.flatnonzero(peaks).tolist()]
            rows = [here, longer, np.full(self.samples + 2, -1.0)]
        best = sorted(found, reverse=True)[:MOST_REFINED] or [(0.0, 0, 1)]
        windows = self.interval * np.array([window for _, *window in best])
        return windows[:, 0], windows[:, 1]

    def best_of_length(self, length: float) -> tuple[float, float, float]:
        """The gain of a window that slides is quadratic between two moments at which an end passes a sample."""
        end, passing = self.interval * (self.samples - 1), self.interval * np.arange(self.samples)
        starts = np.concatenate([passing, passing - length, [end - length]])
        starts = np.unique(starts[(starts >= 0.0) & (starts <= end - length)])
        rate = np.interp(starts + length, passing, self.a) - np.interp(starts, passing, self.a)
        turns = (rate[:-1] > 0.0) & (rate[1:] < 0.0)
        drop = rate[:-1][turns] / (rate[:-1] - rate[1:])[turns]
        starts = np.concatenate([starts, starts[:-1][turns] + drop * np.diff(starts)[turns]])
        return self.best(starts, np.minimum(starts + length, end))

    def refined(self, starts: np.ndarray, ends: np.ndarray, longest: float) -> tuple[float, float, float]:
        """The best of these windows, each moved to the best one around it (a search on grids that get finer)."""
        end, step = self.interval * (self.samples - 1), self.interval
        one, other = (grid.ravel() for grid in np.meshgrid([-1.0, -0.5, 0.0, 0.5, 1.0], [-1.0, -0.5, 0.0, 0.5, 1.0]))
        rows = np.arange(len(starts))
        while step > FINEST * self.interval:
            s = np.clip(starts[:, None] + step * one, 0.0, end)
            e = np.clip(ends[:, None] + step * other, s, np.minimum(s + longest, end))
            best = self.value(s, e).argmax(axis=1)
            starts, ends = s[rows, best], e[rows, best]
            step *= 0.6
        return self.best(starts, ends)


def _value(gain, window):
    mean = np.divide(gain, window, out=np.zeros_like(gain), where=np.asarray(window) > 0.0)
    return window * np.maximum(mean, 0.0) ** 2.5


def clip(times: np.ndarray, acceleration: np.ndarray, *, contiguous: bool) -> float:
    """Highest level that lasts for `CLIP`: [m/s^2]; 0 if the curve is shorter (SAE J885; ECE R94 for the head).

    times: [s], (samples,), evenly spaced; acceleration: resultant [m/s^2], (samples,), not negative
    contiguous: without interruption (the chest, 49 CFR 571.208 S6.3), else summed over all times above (the head)
    Raises InputError E-INJ-001.
    """
    interval = sample_interval(times, acceleration)
    a = np.asarray(acceleration, float)
    low, high = 0.0, float(a.max())
    if interval * (len(a) - 1) < CLIP * (1.0 - FITS) or high <= 0.0:
        return 0.0
    while high - low > 1e-9 * high:  # time above a level never grows with the level
        middle = 0.5 * (low + high)
        above = _seconds_above(a, middle, interval)
        lasted = _longest_run(above, a > middle) if contiguous else above.sum()
        low, high = (middle, high) if lasted >= CLIP * (1.0 - FITS) else (low, middle)
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
    return assess_acceleration(*mean_acceleration(times, velocity))


def assess_acceleration(times: np.ndarray, acceleration: np.ndarray) -> Injury:
    """Injury metrics of a body from its acceleration as a test measures it: [m/s^2], (samples, components), at times
    [s], (samples,). Errors as `assess`."""
    return Injury(times, np.linalg.norm(channel_filter(times, acceleration, HEAD_CLASS), axis=1))


def assess_run(result) -> dict[str, Injury]:
    """Injury metrics of every free obstacle of a `Result`, from its histories. Raises InputError E-INJ-005 if the run
    has none, and the errors of `assess`."""
    bodies = result.free_obstacles
    if not bodies:
        raise NO_FREE_OBSTACLE(folder=result.folder)
    return {name: assess(result.histories.time, result.body(name).velocity) for name in bodies}
