"""Birth ramp: fabric whose start shape is stretched against its flat cut is released slowly (docs/theory.md, Birth
ramp). At s = 0 nothing is strained, at s = 1 the flat cut holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel
from billow.parts.fabric.membrane import ENERGY, Membrane


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
        self, moved: Sequence[Membrane], fraction: float, triangles: np.ndarray, positions: np.ndarray,
        histories: Sequence[np.ndarray],
    ) -> float:  # fmt: skip
        """dE/ds [J] of the strain energy at fixed positions [m] (nodes, 3), from the forces of the membranes `moved` to
        this fraction: they do as much work as if the corners moved and the reference stood."""
        total, at_rest = 0.0, np.zeros_like(positions)
        for membrane, excess, history in zip(moved, self.stretch, histories, strict=True):
            n = len(membrane.elements)
            forces, _ = membrane.by_itself(triangles, positions, at_rest, history)
            work = np.empty(-(-n // CHUNK))
            _reference_work(
                n, 1.0 - fraction, membrane.reference_inverse, excess, membrane.elements, triangles, positions, forces,
                work,
            )  # fmt: skip
            total += float(work.sum())
        return total


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


@kernel
def _reference_work(n, left, inverse, excess, elements, triangles, positions, forces, work_out):
    """Work [J] of the reference per whole way, by chunks: forces [N] (n, 3, 3) on the corners of elements with the
    inverse flat edges D [1/m], (4, n).

    D goes with the rate D X M^-1, M = I + left X (excess X). Edges Ds that moved at the rate Ds K, K = D X M^-1 D^-1,
    would strain the element alike, and forces are minus the gradient of the energy.
    """
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        total = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            x11, x12, x22 = excess[0, i], excess[1, i], excess[2, i]
            m11, m12, m22 = 1.0 + left * x11, left * x12, 1.0 + left * x22
            d11, d12, d21, d22 = inverse[0, i], inverse[1, i], inverse[2, i], inverse[3, i]
            per = 1.0 / ((m11 * m22 - m12 * m12) * (d11 * d22 - d12 * d21))
            y11, y12, y22 = x11 * m22 - x12 * m12, x12 * m11 - x11 * m12, x22 * m11 - x12 * m12
            p11, p12 = d11 * y11 + d12 * y12, d11 * y12 + d12 * y22
            p21, p22 = d21 * y11 + d22 * y12, d21 * y12 + d22 * y22
            k11, k12 = per * (p11 * d22 - p12 * d21), per * (p12 * d11 - p11 * d12)
            k21, k22 = per * (p21 * d22 - p22 * d21), per * (p22 * d11 - p21 * d12)
            t = elements[i]
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            for k in range(3):
                u, w = positions[b, k] - positions[a, k], positions[c, k] - positions[a, k]
                total -= forces[i, 1, k] * (u * k11 + w * k21) + forces[i, 2, k] * (u * k12 + w * k22)
        work_out[chunk] = total
