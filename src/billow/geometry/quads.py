"""Quads split into triangles with alternating diagonals, so that no direction is preferred."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


def diagonals(cells: np.ndarray, node_count: int) -> np.ndarray:
    """Corner, 0 or 1, from which each quad's diagonal runs, (cells,); cells: (cells, 4), -1 last for triangles.

    The diagonals join nodes of one colour of a checkerboard, so that on a grid their directions alternate. A node with
    two edges is a corner where two panels meet; there the diagonal runs into the corner, because two panels must not
    share a diagonal that cuts the corner off.
    """
    quads = cells[cells[:, 3] >= 0]
    first, second = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    # In the double cover of the graph of edges a node and its image are connected unless the graph has two colours.
    rows = np.concatenate([first, second, first + node_count, second + node_count])
    columns = np.concatenate([second + node_count, first + node_count, second, first])
    graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(2 * node_count, 2 * node_count))
    _, label = connected_components(graph, directed=False)
    colour = (label[:node_count] > label[node_count:]).astype(np.int64)
    edges = np.unique(np.sort(np.column_stack([first, second]), axis=1), axis=0)
    corner = np.bincount(edges.ravel(), minlength=node_count) == 2
    diagonal = np.zeros(len(cells), dtype=np.int64)
    sharp = corner[quads]
    diagonal[cells[:, 3] >= 0] = np.where(sharp.any(axis=1), sharp.argmax(axis=1) % 2, colour[quads[:, 0]])
    return diagonal


def split(cells: np.ndarray, diagonal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (n, 3) in the order of their cells, and the cell of each, (n,)."""
    turned = np.where(diagonal[:, None] == 1, np.roll(cells, -1, axis=1), cells)
    quad = cells[:, 3] >= 0
    first, second = np.where(quad[:, None], turned, cells)[:, [0, 1, 2]], turned[quad][:, [0, 2, 3]]
    owner = np.concatenate([np.arange(len(cells)), np.flatnonzero(quad)])
    order = np.argsort(owner, kind="stable")
    return np.concatenate([first, second])[order], owner[order]
