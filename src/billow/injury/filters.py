"""Curves of evenly spaced samples, and the low pass every crash signal goes through: the channel frequency classes of
SAE J211-1 and ISO 6487 (docs/theory.md, Injury metrics)."""

from __future__ import annotations

import math

import numpy as np

from billow.base.errors import InputError

UNUSABLE_CURVE = InputError.declare(
    "E-INJ-001",
    "the curve cannot be used",
    where="injury metrics",
    cause="values that are not finite, times that are not evenly spaced, or lengths that differ",
    remedy="give one finite value for each of at least two evenly spaced times",
)
UNKNOWN_CLASS = InputError.declare(
    "E-INJ-002",
    "there is no channel frequency class {channel_class!r}",
    where="channel filter",
    why="SAE J211 defines the classes {known}",
    cause="a cut-off frequency in hertz instead of a class",
    remedy="choose one of them: 1000 for heads, 600 for forces of the neck, 180 for the chest",
)
SAMPLED_TOO_SLOWLY = InputError.declare(
    "E-INJ-003",
    "{rate:.4g} samples per second are too few for CFC {channel_class}",
    where="channel filter",
    why="the class needs at least {needed} per second (ISO 6487)",
    cause="a long run, or few histories per frame",
    remedy="raise run.histories_per_frame and run again, or choose a lower class",
)

EVEN = 1e-3
"""Part of the interval by which a time may be off before times count as uneven."""

CLASSES = (60, 180, 600, 1000)
SAMPLES_PER_CLASS = 10
"""Lowest sample rate over class (ISO 6487): 10 kHz for CFC 1000."""
PADDING = 2.0
"""Length of the mirrored ends in periods of the corner frequency 2.0775 CFC: what is left of a step there is 1e-4."""


def sample_interval(times: np.ndarray, curve: np.ndarray) -> float:
    """Interval of a curve: [s].

    times: [s], (samples,); curve: any unit, (samples, ...)
    Raises InputError E-INJ-001 if there are fewer than two samples, lengths differ, a value is not finite, or times are
    not evenly spaced and rising.
    """
    times, curve = np.asarray(times, float), np.asarray(curve, float)
    if times.ndim != 1 or len(times) < 2 or curve.shape[:1] != times.shape:
        raise UNUSABLE_CURVE(why=f"times have shape {times.shape}, values {curve.shape}")
    if not (np.isfinite(times).all() and np.isfinite(curve).all()):
        raise UNUSABLE_CURVE(why="a time or a value is not a finite number")
    steps = np.diff(times)
    interval = float(times[-1] - times[0]) / len(steps)
    if not interval > 0.0 or np.abs(steps - interval).max() > EVEN * interval:
        raise UNUSABLE_CURVE(why=f"times are not evenly spaced: steps from {steps.min():.3g} to {steps.max():.3g} s")
    return interval


def require_samples(channel_class: int, interval: float) -> None:
    """Raises InputError E-INJ-003 if samples at this interval [s] are too few for a channel class."""
    if interval * SAMPLES_PER_CLASS * channel_class > 1.0 + 1e-6:
        raise SAMPLED_TOO_SLOWLY(
            rate=1.0 / interval, channel_class=channel_class, needed=SAMPLES_PER_CLASS * channel_class
        )


def channel_filter(times: np.ndarray, curve: np.ndarray, channel_class: int) -> np.ndarray:
    """A curve filtered to a channel frequency class: same unit and shape.

    times: [s], (samples,), evenly spaced; curve: (samples,) or (samples, components); channel_class: one of `CLASSES`

    Before it starts and after it ends the curve is continued by its mirror image through its end point, so that a
    constant or a straight line passes unchanged.
    Raises InputError E-INJ-001 (no curve), E-INJ-002 (no such class), E-INJ-003 (sampled too slowly for it).
    """
    interval = sample_interval(times, curve)
    if channel_class not in CLASSES:
        raise UNKNOWN_CLASS(channel_class=channel_class, known=", ".join(map(str, CLASSES)))
    require_samples(channel_class, interval)
    from scipy.signal import filtfilt  # half a second to load, for those who filter

    forward, backward = coefficients(channel_class, interval)
    padding = min(len(times) - 1, math.ceil(PADDING / (2.0775 * channel_class * interval) - 1e-6))
    return filtfilt(forward, backward, np.asarray(curve, float), axis=0, padtype="odd", padlen=padding)


def coefficients(channel_class: int, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """(a0, a1, a2) and (1, -b1, -b2) of one pass: [-], as `scipy.signal` takes them. interval: [s]."""
    w = math.tan(math.pi * 2.0775 * channel_class * interval)
    whole = 1.0 + math.sqrt(2.0) * w + w * w
    a0 = w * w / whole
    b1, b2 = -2.0 * (w * w - 1.0) / whole, (-1.0 + math.sqrt(2.0) * w - w * w) / whole
    return np.array([a0, 2.0 * a0, a0]), np.array([1.0, -b1, -b2])
