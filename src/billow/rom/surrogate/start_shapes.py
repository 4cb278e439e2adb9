"""Start shapes of designs whose sizes differ: each node's place as a polynomial of the design.

A mesh moved to other sizes is nearly linear in them (`billow.geometry.morph`), so that least squares on few terms do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.results.dataset_files import Parameter
from billow.rom.surrogate.design_space import to_unit

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
        terms = _terms(unit, quadratic=len(unit) >= ENOUGH * _count(len(parameters), True))
        away = (starts.astype(float) - reference).reshape(len(starts), -1)
        weights = np.linalg.lstsq(terms, away, rcond=1e-10)[0]
        return cls(weights.reshape(-1, *reference.shape).astype(np.float32))

    def __call__(self, rows: np.ndarray, reference: np.ndarray, parameters: tuple[Parameter, ...]) -> np.ndarray:
        """Start shapes [m], (runs, nodes, 3) float32, of designs (runs, parameters)."""
        quadratic = len(self.weights) == _count(len(parameters), True)
        terms = _terms(to_unit(rows, parameters), quadratic)
        return reference + np.tensordot(terms.astype(np.float32), self.weights, 1)

    @staticmethod
    def fits(weights: np.ndarray, parameters: int) -> bool:
        """Whether so many terms belong to so many parameters."""
        return len(weights) in (_count(parameters, False), _count(parameters, True))


def _count(parameters: int, quadratic: bool) -> int:
    return 1 + parameters + quadratic * parameters * (parameters + 1) // 2


def _terms(unit: np.ndarray, quadratic: bool) -> np.ndarray:
    """Constant, linear, and with `quadratic` squares and products, (runs, terms)."""
    centred = 2.0 * unit - 1.0
    one, other = np.triu_indices(unit.shape[1])
    further = [centred[:, one] * centred[:, other]] if quadratic else []
    return np.column_stack([np.ones(len(unit)), centred, *further])
