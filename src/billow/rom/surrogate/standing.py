"""Where a question stands among the designs a surrogate has learned from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.results.dataset_files import Parameter
from billow.rom.surrogate.question import BOUND_TOLERANCE


@dataclass(frozen=True)
class Standing:
    """One design among the trained ones; distances with every parameter's range scaled to [0, 1].

    outside: names of parameters beyond their trained range; nearest: [-], distance to the nearest training design
    usual, largest: [-], mean and largest distance of a training design to its nearest neighbour
    """

    outside: tuple[str, ...]
    nearest: float
    usual: float
    largest: float

    @property
    def lonely(self) -> bool:
        """True if the design is farther from all training designs than any of them is from its neighbour."""
        return self.nearest > self.largest

    def sentences(self) -> list[str]:
        """Warnings for people; none if the design lies among the trained ones."""
        told = []
        if self.outside:
            told.append(f"{', '.join(self.outside)} outside the trained range: nothing vouches for this answer")
        if self.lonely:
            told.append(
                f"the nearest training design is {self.nearest / self.usual:.1f} times as far away as training designs "
                "are from each other on average, farther than any of them: the answer is less certain than its interval"
            )
        return told


def standing(design: np.ndarray, designs: np.ndarray, parameters: tuple[Parameter, ...]) -> Standing:
    """Where `design` (parameters,) stands among `designs` (runs, parameters), at least two of them."""
    known, asked = to_unit(designs, parameters), to_unit(design, parameters)
    between = neighbour_distances(known)
    nearest = float(np.linalg.norm(known - asked, axis=1).min())
    beyond = (asked < -BOUND_TOLERANCE) | (asked > 1.0 + BOUND_TOLERANCE)
    outside = tuple(p.name for p, out in zip(parameters, beyond, strict=True) if out)
    return Standing(outside, nearest, float(between.mean()), float(between.max()))


def to_unit(designs: np.ndarray, parameters: tuple[Parameter, ...]) -> np.ndarray:
    """Designs with every parameter's range scaled to [0, 1]: (..., parameters)."""
    low, high = (np.array([getattr(p, side) for p in parameters]) for side in ("low", "high"))
    return (designs - low) / (high - low)


def neighbour_distances(points: np.ndarray) -> np.ndarray:
    """Distance of each point to its nearest neighbour: (points,). points: (points, dimensions), at least two."""
    squares = np.square(points).sum(axis=1)
    distance = squares[:, None] + squares[None] - 2.0 * points @ points.T
    np.fill_diagonal(distance, np.inf)
    return np.sqrt(np.maximum(distance.min(axis=1), 0.0))
