"""From triangles to nodes (assembly, in the words of finite elements), in an order that depends on no thread: each
chunk of triangles adds to entries of its own, and each node adds up its entries in order (docs/theory.md, Assembly).

Between entries only nodes at the rim of a chunk are shared, so that there are hardly more entries than nodes if the
triangles of a chunk lie together (`in_neighbourhoods`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from billow.base.compiled import CHUNK
from billow.geometry.chambers import Chambers

COLUMNS = 6
"""Of the sums of an entry: a force [N], and a third of the area vectors [m^2] of the triangles that meet there."""


class Corners(NamedTuple):
    """Of a list of n triangles. node: of each corner, (n, 3) uint32. entry: to which each corner adds, (n, 3) uint32.
    first: entry at which each chunk of triangles begins, (chunks + 1,) int64."""

    node: np.ndarray
    entry: np.ndarray
    first: np.ndarray

    @classmethod
    def apart(cls, node: np.ndarray) -> Corners:
        """With an entry for each corner: entry 3 i + k for corner k of triangle i."""
        n = len(node)
        ends = np.minimum(np.arange(-(-n // CHUNK) + 1) * CHUNK, n)
        return cls(node, np.arange(3 * n, dtype=np.uint32).reshape(n, 3), 3 * ends)


@dataclass(frozen=True)
class Assembly:
    """corners: of each list of triangles. start: (nodes + 1,) int64 and entry: (entries,) uint32, the entries of each
    node in ascending order. sides: chambers behind and ahead of triangles, every pair that there is, (pairs, 2) int32;
    pair: that of all triangles of an entry, (entries,) uint32."""

    corners: tuple[Corners, ...]
    start: np.ndarray
    entry: np.ndarray
    sides: np.ndarray
    pair: np.ndarray

    @classmethod
    def build(cls, lists: Sequence[np.ndarray], triangles: np.ndarray, chambers: Chambers, node_count: int) -> Assembly:
        """lists: triangles (n,) that are passed over together, in their order; triangles: (triangles, 3)."""
        sides = np.stack([chambers.behind, chambers.ahead], axis=1)
        pairs, pair = np.unique(sides, axis=0, return_inverse=True)
        keys, corners, count = [], [], 0
        for listed in lists:
            entry, first = np.empty((len(listed), 3), np.uint32), [count]
            for begin in range(0, len(listed), CHUNK):
                chunk = listed[begin : begin + CHUNK]
                key = triangles[chunk].astype(np.int64) * len(pairs) + pair.reshape(-1, 1)[chunk]
                own, at = np.unique(key, return_inverse=True)
                entry[begin : begin + CHUNK] = count + at.reshape(-1, 3)
                keys.append(own)
                count += len(own)
                first.append(count)
            corners.append(Corners(triangles[listed], entry, np.array(first, np.int64)))
        node, side = np.divmod(np.concatenate([np.empty(0, np.int64), *keys]), len(pairs))
        start = np.zeros(node_count + 1, np.int64)
        np.cumsum(np.bincount(node, minlength=node_count), out=start[1:])
        entry = np.argsort(node, kind="stable").astype(np.uint32)
        return cls(tuple(corners), start, entry, pairs.astype(np.int32).reshape(-1, 2), side.astype(np.uint32))


def in_neighbourhoods(points: np.ndarray) -> np.ndarray:
    """Order (n,) of points [m] (n, 3) along Morton's curve, which keeps together what lies together."""
    low = points.min(axis=0, initial=np.inf)
    across = max(float(np.ptp(points, axis=0).max()), 1e-300) if len(points) else 1.0
    cell = ((points - low) / across * 1023.0).astype(np.int64)
    key = np.zeros(len(points), np.int64)
    for bit in range(10):
        for axis in range(3):
            key |= ((cell[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(key, kind="stable")
