"""Ratings of a body's motion against the solver, and how far the curves of a motion may be off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from billow.injury.rating import Rating, rate
from billow.rom.coupled.impactor import ImpactorMotion
from billow.rom.surrogate.basis import Z
from billow.rom.surrogate.judgement import Comparison

QUANTITIES: dict[str, Callable[[ImpactorMotion], tuple[np.ndarray, np.ndarray]]] = {
    "acceleration CFC 60": lambda motion: motion.acceleration(60),
    "acceleration CFC 180": lambda motion: motion.acceleration(180),
    "velocity": lambda motion: (motion.times, motion.velocity),
    "displacement": lambda motion: (motion.times, motion.displacement),
}
"""What is rated: name -> times [s], (samples,), and values, (samples, 3)."""

CURVES: dict[str, Callable[[ImpactorMotion], np.ndarray]] = {
    "centre": lambda motion: motion.centre,
    "velocity": lambda motion: motion.velocity,
    "acceleration": lambda motion: at_times(motion.acceleration()[1]),
    "acceleration CFC 60": lambda motion: at_times(motion.acceleration(60)[1]),
}
"""What of a motion has intervals: name -> values at all times, (times, 3)."""

MEAN_MOTION = "mean motion"


def at_times(means: np.ndarray) -> np.ndarray:
    """Means over intervals (times - 1, 3) at the end of each; the first row repeats the second: (times, 3)."""
    return np.vstack([means[:1], means])


def mean_motion(motions: list[ImpactorMotion]) -> ImpactorMotion:
    """The mean of motions, whatever their designs."""
    means = (np.mean([getattr(motion, name) for motion in motions], axis=0) for name in ("centre", "velocity"))
    return ImpactorMotion(motions[0].times, *means)


def rate_motion(moved: ImpactorMotion, truth: ImpactorMotion) -> dict[str, Rating]:
    """Ratings of `QUANTITIES` along z, the axis of the bag, by ISO/TS 18571."""
    found = {}
    for quantity, curve in QUANTITIES.items():
        times, reference = curve(truth)
        found[quantity] = rate(times, curve(moved)[1][:, Z], reference[:, Z])
    return found


def compare_ratings(own: list[dict[str, Rating]], mean: list[dict[str, Rating]]) -> tuple[Comparison, ...]:
    """Median overall ratings of a model and of the mean motion. own, mean: as `rate_motion`, of each run."""

    def median(ratings, quantity):
        return float(np.median([of_run[quantity].overall for of_run in ratings]))

    return tuple(
        Comparison(f"rating of {quantity}", MEAN_MOTION, median(own, quantity), median(mean, quantity), True, True)
        for quantity in QUANTITIES
    )
