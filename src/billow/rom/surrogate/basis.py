"""A reduced basis: a few shapes whose weighted sums represent all displacements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

COMPONENTS = ("x", "y", "z")
"""Index 0, 1, 2 of every array with a component axis."""

Z = 2
"""Index of the component along the bag's axis, by which a deployment is judged first."""


def by_axis(values: np.ndarray) -> dict[str, float]:
    """Three numbers, one of each component, as plain JSON."""
    return dict(zip(COMPONENTS, values.tolist(), strict=True))


@dataclass(frozen=True)
class Basis:
    """Reduced basis of one displacement component.

    modes: [-], (modes, nodes) float32, orthonormal rows; the largest entry of each is positive
    singular_values: [m], (values,) float64, falling; at least as many as modes (the extra ones show the decay)
    energy: [m2], squared Frobenius norm of all snapshots
    """

    modes: np.ndarray
    singular_values: np.ndarray
    energy: float

    def coefficients(self, snapshots: np.ndarray) -> np.ndarray:
        """U^T Y of paper equation 2: [m], (nodes, columns) -> (modes, columns) float32."""
        return self.modes @ snapshots

    def fields(self, coefficients: np.ndarray) -> np.ndarray:
        """Paper equation 1: [m], (modes, columns) -> (nodes, columns) float32. Fewer modes than stored are allowed."""
        return self.modes[: len(coefficients)].T @ coefficients

    @property
    def energy_fraction(self) -> np.ndarray:
        """Part of the snapshots' energy that the first 1, 2, ... modes hold: [-], (modes,) float64."""
        if self.energy == 0.0:  # a component that never moved is represented completely
            return np.ones(len(self.modes))
        return np.cumsum(self.singular_values[: len(self.modes)] ** 2) / self.energy
