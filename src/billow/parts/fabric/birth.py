"""Birth ramp: fabric whose start shape is stretched against its flat cut is released slowly (docs/theory.md, Birth
ramp). At s = 0 nothing is strained, at s = 1 the flat cut holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from billow.parts.fabric.membrane import ENERGY, Membrane

NUDGE = 1e-4
"""Step of s in the central difference for dE/ds."""


@dataclass(frozen=True)
class Birth:
    """time: at which the flat cut is reached [s]. stretch: U - I of each membrane's elements, its entries 11, 12 and 22
    [-], (3, n)."""

    time: float
    stretch: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, time: float, membranes: Sequence[Membrane], triangles: np.ndarray, start: np.ndarray) -> Birth:
        """start: positions at time zero, [m], (nodes, 3); triangles: (triangles, 3)."""
        return cls(time, tuple(_excess(m, triangles, start) for m in membranes))

    def fraction(self, time: float) -> float:
        """How far the reference has moved at a time [s], 0 to 1."""
        return min(1.0, time / self.time)

    def membranes(self, membranes: Sequence[Membrane], fraction: float) -> tuple[Membrane, ...]:
        """The membranes with the reference at a fraction of the way."""
        if fraction == 1.0:
            return tuple(membranes)
        return tuple(_against(m, (1.0 - fraction) * u) for m, u in zip(membranes, self.stretch, strict=True))

    def energy_slope(
        self, membranes: Sequence[Membrane], fraction: float, triangles: np.ndarray, positions: np.ndarray,
        histories: Sequence[np.ndarray],
    ) -> float:  # fmt: skip
        """dE/ds [J] of the strain energy at fixed positions [m] (nodes, 3)."""
        above, below = (
            strain_energy(self.membranes(membranes, fraction + side * NUDGE), triangles, positions, histories)
            for side in (1.0, -1.0)
        )
        return (above - below) / (2.0 * NUDGE)


def strain_energy(
    membranes: Sequence[Membrane], triangles: np.ndarray, positions: np.ndarray, histories: Sequence[np.ndarray]
) -> float:
    """Recoverable energy [J] of membranes; their history stays as it is."""
    total = 0.0
    at_rest = np.zeros_like(positions)
    for membrane, history in zip(membranes, histories, strict=True):
        _, sums = membrane.by_itself(triangles, positions, at_rest, history)
        total += float(sums[:, ENERGY].sum())
    return total


def _excess(membrane: Membrane, triangles: np.ndarray, start: np.ndarray) -> np.ndarray:
    """U - I with the eigenvalues of U at least one."""
    c11, c22, c12 = membrane.cauchy_green(triangles, start)
    squared, axes = np.linalg.eigh(np.stack([c11, c12, c12, c22], axis=1).reshape(-1, 2, 2))
    excess = np.maximum(np.sqrt(np.maximum(squared, 0.0)), 1.0) - 1.0
    tensor = np.einsum("nik,nk,njk->nij", axes, excess, axes)
    return np.ascontiguousarray([tensor[:, 0, 0], tensor[:, 0, 1], tensor[:, 1, 1]])


def _against(membrane: Membrane, excess: np.ndarray) -> Membrane:
    """The membrane with flat edges (I + excess) Dm."""
    m11, m12, m22 = 1.0 + excess[0], excess[1], 1.0 + excess[2]
    determinant = m11 * m22 - m12 * m12
    d11, d12, d21, d22 = membrane.reference_inverse
    inverse = np.array(
        [d11 * m22 - d12 * m12, d12 * m11 - d11 * m12, d21 * m22 - d22 * m12, d22 * m11 - d21 * m12]
    ) / determinant  # fmt: skip
    return replace(membrane, reference_inverse=inverse, yarn_inverse=membrane.fabric.along_yarns(inverse))
