"""A measured curve: values at evenly spaced times, and the check that it is one."""

from __future__ import annotations

import numpy as np

from billow.base.errors import InputError

UNUSABLE_CURVE = InputError.declare(
    "E-INJ-001",
    "the curve cannot be used",
    where="injury metrics",
    cause="values that are not finite, times that are not evenly spaced, or lengths that differ",
    remedy="give one finite value for each of at least two evenly spaced times",
)

EVEN = 1e-3
"""Part of the interval by which a time may be off before times count as uneven."""


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
