"""How an obstacle moved and what pushed it: from a run's histories, or from a coupled model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.injury.filters import channel_filter
from billow.injury.motion import body_velocity, mean_acceleration
from billow.results.result import Result

FORCE_CLASS = 180
"""Channel frequency class of the forces that are learned."""


@dataclass(frozen=True, eq=False)
class ImpactorMotion:
    """times: [s], (times,); centre: [m], (times, 3); velocity: [m/s], (times, 3)."""

    times: np.ndarray
    centre: np.ndarray
    velocity: np.ndarray

    @classmethod
    def of_run(cls, result: Result, name: str) -> ImpactorMotion:
        """The free obstacle `name` of a finished run."""
        histories = result.histories
        centre = np.stack([histories[f"{name}_centre_{axis} [m]"] for axis in "xyz"], axis=1)
        return cls(histories["time [s]"], centre, body_velocity(histories, name))

    @property
    def displacement(self) -> np.ndarray:
        """From the start: [m], (times, 3)."""
        return self.centre - self.centre[0]

    def acceleration(self, channel_class: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Middles of the intervals [s], (times - 1,), and mean accelerations over them [m/s^2], (times - 1, 3),
        filtered if a channel frequency class is given."""
        middles, acceleration = mean_acceleration(self.times, self.velocity)
        if channel_class is not None:
            acceleration = channel_filter(middles, acceleration, channel_class)
        return middles, acceleration


def filtered_force(motion: ImpactorMotion, mass: float, gravity: np.ndarray) -> np.ndarray:
    """Contact force on a body from how it moved, filtered to `FORCE_CLASS`: [N], (times - 1, 3). mass: [kg]; gravity:
    [m/s^2], (3,)."""
    return mass * (motion.acceleration(FORCE_CLASS)[1] - gravity)


def recorded_force(result: Result, name: str) -> np.ndarray:
    """Contact force on the free obstacle `name` as the solver recorded it, filtered to `FORCE_CLASS`: [N],
    (times - 1, 3), mean of the two ends of each interval of the histories."""
    force = np.stack([result.histories[f"{name}_force_{axis} [N]"] for axis in "xyz"], axis=1)
    times = result.histories["time [s]"]
    return channel_filter(0.5 * (times[1:] + times[:-1]), 0.5 * (force[1:] + force[:-1]), FORCE_CLASS)
