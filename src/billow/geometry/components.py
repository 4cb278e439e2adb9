"""Connected components of a graph in NumPy; to load SciPy's would take as long as to start the compiler."""

from __future__ import annotations

import numpy as np


def components(count: int, ends: np.ndarray) -> np.ndarray:
    """The smallest node of the component of each of `count` nodes, (count,) int64, for edges (n, 2).

    Trees of links to smaller nodes: each round hangs the root of one end below that of the other, then lets every node
    point to its root.
    """
    root = np.arange(count)
    while True:
        one, other = root[ends[:, 0]], root[ends[:, 1]]
        apart = one != other
        if not apart.any():
            return root
        one, other = one[apart], other[apart]
        np.minimum.at(root, np.maximum(one, other), np.minimum(one, other))
        while not np.array_equal(further := root[root], root):
            root = further
