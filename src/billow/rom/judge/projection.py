"""Unseen runs seen through a basis: what each number of modes loses, and what predicted coefficients add to it.

The basis is orthonormal, so that sums of squares over nodes are sums of squares over modes: errors of any number of
modes follow from coefficients alone, once every shape has been projected.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from billow.rom.learn.basis import Basis


@dataclass(frozen=True, eq=False)
class Projection:
    """Some runs in a basis.

    known: [m], (runs, times, 3, modes) float32, the best coefficients
    outside: [m2], (runs, times, 3) float64, sum over nodes of the squares that all modes leave
    nodes: number of them
    """

    known: np.ndarray
    outside: np.ndarray
    nodes: int

    def truncation(self, modes: int) -> np.ndarray:
        """RMSE over nodes with the first `modes` modes and the best coefficients: [m], (runs, times, 3)."""
        cut = np.square(self.known[..., modes:], dtype=float).sum(axis=3)
        return np.sqrt((self.outside + cut) / self.nodes)

    def regression(self, learned: np.ndarray, modes: int) -> np.ndarray:
        """RMSE over nodes that wrong coefficients alone make: [m], (runs, times, 3).

        learned: [m], (runs, times, 3, at least modes), predicted coefficients; the RMSE of the prediction is the root
        of truncation^2 + regression^2
        """
        wrong = np.square(learned[..., :modes] - self.known[..., :modes], dtype=float).sum(axis=3)
        return np.sqrt(wrong / self.nodes)


def project(shapes: Iterable[np.ndarray], bases: tuple[Basis, ...]) -> Projection:
    """shapes: [m], displacement (times, nodes, 3) of each run, read one at a time."""
    known, outside = [], []
    for shape in shapes:
        components = [np.ascontiguousarray(shape[:, :, c].T) for c in range(3)]  # (nodes, times)
        pairs = list(zip(bases, components, strict=True))
        found = [basis.coefficients(component) for basis, component in pairs]
        rests = [c - basis.fields(a) for (basis, c), a in zip(pairs, found, strict=True)]
        known.append(np.stack([a.T for a in found], axis=1))
        outside.append(np.stack([np.square(rest).sum(axis=0, dtype=float) for rest in rests], axis=1))
    return Projection(np.stack(known), np.stack(outside), bases[0].modes.shape[1])
