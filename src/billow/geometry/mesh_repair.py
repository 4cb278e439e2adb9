"""Meshes as other programs leave them, made fit for a bag: duplicate nodes along seams merged, cells turned so that all
normals point out, open edges found and closed.

Cells are (cells, 4) node indices, -1 last for triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.geometry.components import components


@dataclass(frozen=True)
class Edges:
    """Edges of cells: ends (n, 2) in the sense of their cell, cell (n,)."""

    ends: np.ndarray
    cell: np.ndarray

    @classmethod
    def of(cls, cells: np.ndarray) -> Edges:
        triangle = cells[:, 3] < 0
        following = np.roll(cells, -1, axis=1)
        following[triangle, 2] = cells[triangle, 0]
        used = np.ones(cells.shape, dtype=bool)
        used[triangle, 3] = False
        owner = np.broadcast_to(np.arange(len(cells))[:, None], cells.shape)
        return cls(np.column_stack([cells[used], following[used]]), owner[used])

    def uses(self) -> tuple[np.ndarray, np.ndarray]:
        """For each edge, the index of the undirected edge it lies on, and how many cells each of those has."""
        ends = np.sort(self.ends, axis=1)
        key = ends[:, 0] * (int(ends.max(initial=0)) + 1) + ends[:, 1]
        _, which, count = np.unique(key, return_inverse=True, return_counts=True)
        return which, count


def crowded(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Ends (2,) and cells (n,) of the first edge that more than two cells share; None if there is none."""
    edges = Edges.of(cells)
    which, count = edges.uses()
    if not (count > 2).any():
        return None
    mine = np.flatnonzero(count[which] > 2)
    mine = mine[which[mine] == which[mine[0]]]
    return edges.ends[mine[0]], edges.cell[mine]


def free_edges(cells: np.ndarray) -> np.ndarray:
    """Ends (n, 2), in the sense of their cell, of edges with one cell."""
    edges = Edges.of(cells)
    which, count = edges.uses()
    return edges.ends[count[which] == 1]


def merged(points: np.ndarray, cells: np.ndarray, tolerance: float) -> tuple[np.ndarray, int]:
    """New node of each node, (nodes,), and how many were merged: nodes on free edges that lie within the tolerance
    [unit of the points] of each other become the one with the lowest number.

    ValueError, with a sentence, if a cell would lose an edge.
    """
    from scipy.spatial import cKDTree

    rim = np.unique(free_edges(cells))
    if not len(rim):
        return np.arange(len(points)), 0
    pairs = cKDTree(points[rim]).query_pairs(tolerance, output_type="ndarray")
    target = components(len(points), rim[pairs]) if len(pairs) else np.arange(len(points))
    real = Edges.of(cells)
    lost = target[real.ends[:, 0]] == target[real.ends[:, 1]]
    if lost.any():
        at = ", ".join(f"{v:.4g}" for v in points[real.ends[np.argmax(lost), 0]])
        raise ValueError(f"nodes of one cell at ({at}) lie within {tolerance:g} of each other")
    return target, int((target != np.arange(len(points))).sum())


def seam_tolerance(points: np.ndarray, cells: np.ndarray) -> float:
    """A thousandth of the shortest free edge, 0 if there is none: what nodes of one place differ by in a file."""
    ends = free_edges(cells)
    if not len(ends):
        return 0.0
    return 1e-3 * float(np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1).min())


def to_flip(cells: np.ndarray) -> np.ndarray:
    """Whether each cell must be turned so that neighbours agree, (cells,) bool; of each connected piece the fewer cells
    are turned.

    ValueError, with a sentence, if a piece has one side only, as a Moebius strip.
    """
    edges = Edges.of(cells)
    which, count = edges.uses()
    order = np.argsort(which, kind="stable")
    shared = order[count[which[order]] == 2].reshape(-1, 2)
    one, other = edges.cell[shared[:, 0]], edges.cell[shared[:, 1]]
    same = edges.ends[shared[:, 0], 0] == edges.ends[shared[:, 1], 0]  # both run the same way: one is turned
    n = len(cells)
    # In the double cover a cell and its image, the turned cell, are connected only if the piece has one side.
    links = np.concatenate(
        [
            np.column_stack([one, np.where(same, other + n, other)]),
            np.column_stack([one + n, np.where(same, other, other + n)]),
        ]
    )
    root = components(2 * n, links)
    if (root[:n] == root[n:]).any():
        raise ValueError("its surface has one side only, as a Moebius strip")
    piece = np.minimum(root[:n], root[n:])
    turned = root[:n] > root[n:]
    total, against = np.bincount(piece, minlength=n), np.bincount(piece, turned, n)
    return turned ^ (against > 0.5 * total)[piece]


def flipped(cells: np.ndarray, which: np.ndarray) -> np.ndarray:
    """The cells with some of them, (cells,) bool, run through the other way; the first node stays the first."""
    out = cells.copy()
    triangle = cells[:, 3] < 0
    three, four = which & triangle, which & ~triangle
    out[three, 1], out[three, 2] = cells[three, 2], cells[three, 1]
    out[four, 1], out[four, 3] = cells[four, 3], cells[four, 1]
    return out


def pieces(cells: np.ndarray, node_count: int) -> np.ndarray:
    """A number for each cell that is the same for cells joined by nodes, (cells,)."""
    ends = Edges.of(cells).ends
    return components(node_count, ends)[cells[:, 0]]


def volumes(points: np.ndarray, cells: np.ndarray, piece: np.ndarray) -> dict[int, tuple[float, float]]:
    """Signed volume enclosed by each piece, and the volume of a ball with its area; 0 for flat ones."""
    out = {}
    for one in np.unique(piece):
        mine = cells[piece == one]
        corners = points[np.where(mine < 0, mine[:, :1], mine)] - points[mine[0, 0]]
        a, b, c, d = corners[:, 0], corners[:, 1], corners[:, 2], corners[:, 3]
        six = np.einsum("ij,ij->i", a, np.cross(b, c)) + np.einsum("ij,ij->i", a, np.cross(c, d))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) + np.linalg.norm(np.cross(c - a, d - a), axis=1)
        ball = (0.5 * area.sum()) ** 1.5 / (6.0 * np.sqrt(np.pi))
        out[int(one)] = float(six.sum()) / 6.0, float(ball)
    return out


def loops(cells: np.ndarray) -> list[np.ndarray]:
    """Closed chains of free edges, longest first, each as nodes (n,) against the sense of its cells, so that what is
    filled in agrees with them.

    ValueError, with a sentence, if a node has more than one free edge going out.
    """
    ends = free_edges(cells)
    following = dict(zip(ends[:, 1].tolist(), ends[:, 0].tolist(), strict=True))
    if len(following) != len(ends):
        nodes, count = np.unique(ends[:, 1], return_counts=True)
        raise ValueError(f"two open edges meet in node {nodes[np.argmax(count)]}")
    found = []
    while following:
        start, node = next(iter(following.items()))
        loop = [start]
        del following[start]
        while node != start:
            loop.append(node)
            if node not in following:
                raise ValueError(f"the open edge ends in node {node}")
            node = following.pop(node)
        found.append(np.array(loop, dtype=np.int64))
    return sorted(found, key=len, reverse=True)


def filling(points: np.ndarray, loop: np.ndarray) -> np.ndarray:
    """Triangles (n - 2, 3) that close a loop of nodes (n,), by cutting off ears in its mean plane."""
    corners = points[loop] - points[loop].mean(axis=0)
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    size = np.linalg.norm(normal)
    if size > 0.0:
        _, _, axes = np.linalg.svd(normal[None] / size)
        u = axes[1]
        flat = np.column_stack([corners @ u, corners @ np.cross(normal / size, u)])
    else:
        flat = corners[:, :2]
    left, found = list(range(len(loop))), []
    while len(left) > 3:
        k = max(range(len(left)), key=lambda k: _ear(flat, left, k))
        found.append([left[k - 1], left[k], left[(k + 1) % len(left)]])
        del left[k]
    return loop[np.array([*found, left])]


def _ear(flat: np.ndarray, left: list[int], k: int) -> float:
    """How good it is to cut off a corner: the smallest share of a side in the height above it; -1 if that is not
    inside."""
    a, b, c = flat[left[k - 1]], flat[left[k]], flat[left[(k + 1) % len(left)]]
    twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    longest = max(((p - q) ** 2).sum() for p, q in ((a, b), (b, c), (c, a)))
    if not twice > 0.0:
        return -1.0
    others = flat[[i for i in left if i not in (left[k - 1], left[k], left[(k + 1) % len(left)])]]
    inside = np.ones(len(others), dtype=bool)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= (q[0] - p[0]) * (others[:, 1] - p[1]) - (q[1] - p[1]) * (others[:, 0] - p[0]) > 0.0
    return -0.5 if inside.any() else float(twice / longest)
