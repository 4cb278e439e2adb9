"""A closed bag parted into rooms by lines on its flat cut.

A triangle belongs to the side of a line on which its middle lies. Where the fabric goes on in another room, its edges
are the rim of a virtual wall that reaches from the one panel to the other. Lines across y part the walls of lines
across x too, so that four rooms meet in one row of edges.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator

import numpy as np

from billow.geometry.chambers import OUTSIDE, Chambers

Corners = tuple[int, int, int]


def parted(
    triangles: np.ndarray, bag: Chambers, flat: np.ndarray, lines: tuple[list[float], list[float]]
) -> tuple[np.ndarray, Chambers] | None:
    """Triangles (n, 3), of the bag and then of walls, and which room lies on either side of each; None where a room
    would not be closed.

    triangles: (bag, 3) int64. flat: where nodes lie on the flat bag [m], (nodes, 2). lines: places across x and across
    y [m], ascending.
    """
    behind, ahead = bag.behind.astype(np.int64), bag.ahead.astype(np.int64)
    for axis, places in enumerate(lines):
        index, each = np.searchsorted(places, flat[triangles].mean(axis=1)[:, axis]), len(places) + 1
        walls, sides = [], []
        for room in range(int(max(behind.max(), ahead.max())) + 1):
            for (lower, higher), rim in _rims(triangles, behind == room, ahead == room, index):
                corners = _wall(rim, flat[:, 1 - axis])
                walls += corners
                sides += [(room * each + lower, room * each + higher)] * len(corners)
        behind, ahead = (np.where(side == OUTSIDE, OUTSIDE, side * each + index) for side in (behind, ahead))
        triangles = np.concatenate([triangles, np.array(walls, np.int64).reshape(-1, 3)])
        behind, ahead = np.concatenate([[behind, ahead], np.array(sides, np.int64).reshape(-1, 2).T], axis=1)
        numbers = np.unique(np.concatenate([behind, ahead, [OUTSIDE]]))
        behind, ahead = (np.searchsorted(numbers, side) - 1 for side in (behind, ahead))  # OUTSIDE, -1, stays
    names = tuple(f"strip_{k + 1}" for k in range(int(max(behind.max(), ahead.max())) + 1))
    rooms = Chambers(names, behind.astype(np.int32), ahead.astype(np.int32))
    return (triangles, rooms) if _is_closed(triangles, rooms) else None


def _rims(
    triangles: np.ndarray, behind: np.ndarray, ahead: np.ndarray, index: np.ndarray
) -> Iterator[tuple[tuple[int, int], list[int]]]:
    """The loops of edges at which the boundary of a room goes from triangles of a lower index to those of a higher one:
    both indices, and the nodes of the loop as the boundary of the lower part goes round it. behind, ahead: which
    triangles have the room there."""
    owner = {}
    for t in np.flatnonzero(behind):
        owner.update(dict.fromkeys(_edges(triangles[t]), index[t]))
    for t in np.flatnonzero(ahead):
        owner.update(dict.fromkeys(_edges(triangles[t][::-1]), index[t]))
    onwards: dict[tuple[int, int], dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
    for (a, b), part in owner.items():
        other = owner.get((b, a), part)
        if part < other:
            onwards[int(part), int(other)][a].append(b)
    for pair, following in sorted(onwards.items()):
        while following:
            first = next(iter(following))
            loop, node = [], first
            while node in following:
                loop.append(node)
                after = following[node].pop()
                if not following[node]:
                    del following[node]
                node = after
                if node == first:
                    break
            yield pair, loop


def _wall(rim: list[int], at: np.ndarray) -> list[Corners]:
    """Triangles that close a rim, with normals out of the part that goes round it. at: place of each node along the
    line [m]."""
    first, last = int(np.argmin(at[rim])), int(np.argmax(at[rim]))
    turned = rim[first:] + rim[:first]
    end = (last - first) % len(rim)
    forth, back = turned[: end + 1], [turned[0], *turned[: end - 1 : -1]]
    return [(a, c, b) for a, b, c in _between(forth, back, at)]


def _edges(corners: np.ndarray) -> list[tuple[int, int]]:
    a, b, c = corners.tolist()
    return [(a, b), (b, c), (c, a)]


def _between(above: list[int], below: list[int], at: np.ndarray) -> list[Corners]:
    """Triangles between two rows of nodes in about ascending order of `at`, which may share their ends."""
    found, i, j = [], 0, 0
    while i + 1 < len(above) or j + 1 < len(below):
        forth = j + 1 == len(below) or (i + 1 < len(above) and at[above[i + 1]] <= at[below[j + 1]])
        found.append((above[i], above[i + 1], below[j]) if forth else (above[i], below[j + 1], below[j]))
        i, j = i + forth, j + (not forth)
    return [corners for corners in found if len(set(corners)) == 3]


def _is_closed(triangles: np.ndarray, chambers: Chambers) -> bool:
    for room in range(chambers.count):
        edges = Counter(edge for corners in chambers.boundary(room, triangles) for edge in _edges(corners))
        if any(count != edges[edge[::-1]] for edge, count in edges.items()):  # two walls may touch in an edge
            return False
    return True
