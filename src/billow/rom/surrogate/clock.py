"""The clock of a design: by it, the phases of all designs come at the same times.

A bag that fills faster, or swings at a higher pressure, does the same things sooner. At one time, fields of two designs
then differ although the motion is the same, and no sum of modes that is smooth in the design tells the one from the
other. In common time they differ by what the design really changes (docs/theory.md, The clock of a design).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.rom.surrogate.polynomial import terms

FARTHEST = 1.5
"""Common time ends at so many times the last own time: later it stands still, as few designs get there."""
LARGEST = math.log(4.0)
"""Logarithm of the highest rate of a clock; the lowest is its inverse."""


@dataclass(frozen=True, eq=False)
class Clock:
    """Common time of a design: the integral of its rate, which is constant in each of some equal parts of own time.

    weights: [-], (terms, parts) float64: the logarithm of the rate as a polynomial of second degree of the design
    last: [s], the last trained own time; the last part has no end
    reach: [s], common time that the learned runs got to: beyond, networks would guess, and common time stands still
    """

    weights: np.ndarray
    last: float
    reach: float = math.inf

    @property
    def end(self) -> float:
        """[s], of common time; no run may get farther."""
        return FARTHEST * self.last

    @property
    def latest(self) -> float:
        """[s], at which common time stands still."""
        return min(self.end, self.reach)

    def __call__(self, centred: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Common times [s], (runs, times), of own times [s], (times,). centred: (runs, parameters), every range from -1
        to 1."""
        rates = np.exp(np.minimum(np.maximum(terms(centred, True) @ self.weights, -LARGEST), LARGEST))
        return np.minimum(np.maximum(rates @ self.spent(times), 0.0), self.latest)

    def spent(self, times: np.ndarray) -> np.ndarray:
        """Own time spent in each part until some times: [s], (parts, times)."""
        begins, longest = self._parts
        return np.minimum(np.maximum(times - begins, 0.0), longest)

    @cached_property
    def _parts(self) -> tuple[np.ndarray, np.ndarray]:
        """When each part begins, and how long it is: [s], (parts, 1)."""
        count = self.weights.shape[1]
        longest = np.append(np.full(count - 1, self.last / count), np.inf)
        return self.last / count * np.arange(count)[:, None], longest[:, None]
