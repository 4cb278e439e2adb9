"""Which chamber of a bag lies on either side of each triangle (docs/theory.md, Chambers and openings)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel

OUTSIDE = -1
"""Stands for the surroundings where a chamber is named."""


@dataclass(frozen=True)
class Chambers:
    """names: of the chambers. behind, ahead: (triangles,) int32, index of the chamber on the inner and on the outer
    side of each triangle, or OUTSIDE."""

    names: tuple[str, ...]
    behind: np.ndarray
    ahead: np.ndarray

    @classmethod
    def single(cls, triangle_count: int) -> Chambers:
        """One chamber behind every triangle."""
        return cls(("bag",), np.zeros(triangle_count, np.int32), np.full(triangle_count, OUTSIDE, np.int32))

    @property
    def count(self) -> int:
        return len(self.names)

    def joined(self, group: np.ndarray) -> Chambers:
        """Groups of chambers as if each was one; group: (chambers,), number of the group of each."""
        names = tuple(" and ".join(np.array(self.names)[group == k]) for k in range(int(group.max(initial=-1)) + 1))
        number = np.append(group, OUTSIDE).astype(np.int32)  # OUTSIDE, -1, is the last entry
        return Chambers(names, number[self.behind], number[self.ahead])

    def boundary(self, chamber: int, triangles: np.ndarray) -> np.ndarray:
        """Triangles (n, 3) around a chamber, with normals out of it; or, of one number per triangle (triangles,), those
        of the same triangles in the same order."""
        behind, ahead = triangles[self.behind == chamber], triangles[self.ahead == chamber]
        return np.concatenate([behind, ahead[:, ::-1] if ahead.ndim == 2 else ahead])

    def volumes(self, triangles: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Volume of each chamber [m^3], (chambers,), by Gauss' theorem; positions: [m], (nodes, 3)."""
        n = len(triangles)
        partial = np.empty((-(-n // CHUNK), self.count + 1))
        _signed_volumes(n, triangles, positions, self.behind, self.ahead, partial)
        return partial.sum(axis=0)[:-1]


@kernel
def _signed_volumes(n, triangles, positions, behind, ahead, partial_out):
    chunks = (n + CHUNK - 1) // CHUNK
    # Measured from a point of the surface itself, so that far-away bags lose no digits.
    ox, oy, oz = positions[0, 0], positions[0, 1], positions[0, 2]
    for chunk in prange(chunks):
        for k in range(partial_out.shape[1]):
            partial_out[chunk, k] = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
            ax, ay, az = positions[a, 0] - ox, positions[a, 1] - oy, positions[a, 2] - oz
            bx, by, bz = positions[b, 0] - ox, positions[b, 1] - oy, positions[b, 2] - oz
            cx, cy, cz = positions[c, 0] - ox, positions[c, 1] - oy, positions[c, 2] - oz
            volume = (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)) / 6.0
            partial_out[chunk, behind[i]] += volume  # OUTSIDE, -1, is the last column
            partial_out[chunk, ahead[i]] -= volume
