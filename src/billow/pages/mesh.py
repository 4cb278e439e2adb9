"""What pages know of a mesh: whether it is closed, which triangles are holes, and the colours of its fields."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from billow.pictures.deployment import COLOURS, HOLES


def closed(triangles: np.ndarray) -> bool:
    """Whether each edge is one of exactly two triangles, so that the mesh encloses a volume. triangles: (n, 3)."""
    if not len(triangles):
        return False
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())


def holes(part: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """1 for triangles of vents and mouths, which are no fabric: (triangles,) uint8."""
    return np.array([name.startswith(HOLES) for name in names], np.uint8)[part]


def colours() -> np.ndarray:
    """Of the colour bar, as in pictures: (256, 3) uint8."""
    return np.rint(255.0 * COLOURS(np.linspace(0.0, 1.0, 256))[:, :3]).astype(np.uint8)
