"""Start shapes of designs whose sizes differ: each node's place as a polynomial of the design.

A mesh moved to other sizes is nearly linear in them (`billow.geometry.morph`), so that least squares on few terms do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.results.dataset_files import Parameter
from billow.rom.surrogate.design_space import to_unit
from billow.rom.surrogate.polynomial import count, terms

ENOUGH = 1.5
"""Runs for each term from which squares and products are fitted, too."""


@dataclass(frozen=True, eq=False)
class StartShapes:
    """weights: (terms, nodes, 3) float32, [m]: the start shape less the surrogate's reference, for each term."""

    weights: np.ndarray

    @classmethod
    def learn(cls, designs: np.ndarray, starts: np.ndarray, reference: np.ndarray, parameters) -> StartShapes:
        """designs: (runs, parameters); starts: [m], (runs, nodes, 3); reference: [m], (nodes, 3)."""
        unit = to_unit(designs, parameters)
        rows = terms(2.0 * unit - 1.0, quadratic=len(unit) >= ENOUGH * count(len(parameters), True))
        away = (starts.astype(float) - reference).reshape(len(starts), -1)
        weights = np.linalg.lstsq(rows, away, rcond=1e-10)[0]
        return cls(weights.reshape(-1, *reference.shape).astype(np.float32))

    def __call__(self, rows: np.ndarray, reference: np.ndarray, parameters: tuple[Parameter, ...]) -> np.ndarray:
        """Start shapes [m], (runs, nodes, 3) float32, of designs (runs, parameters)."""
        quadratic = len(self.weights) == count(len(parameters), True)
        found = terms(2.0 * to_unit(rows, parameters) - 1.0, quadratic)
        return reference + np.tensordot(found.astype(np.float32), self.weights, 1)

    @staticmethod
    def fits(weights: np.ndarray, parameters: int) -> bool:
        """Whether so many terms belong to so many parameters."""
        return len(weights) in (count(parameters, False), count(parameters, True))
