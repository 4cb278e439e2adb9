"""Pairs of fabric that may touch: a node and a triangle, or two edges, with what is known of each."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from billow.parts.part import VARYING

EDGES = 1 << 61
"""Added to the key of a pair of edges."""

FIRST = 1 << 31
"""Factor of the first number in a key."""

NEW = -1.0
"""Gap of a pair whose distance has not been measured."""


@dataclass
class Room:
    """For what slices find, of both kinds, kept from search to search: one and other, (2, slices, room) int32, the two
    nodes, triangles or edges of each; normal: (2, slices, room, 3)."""

    one: np.ndarray
    other: np.ndarray
    normal: np.ndarray

    @classmethod
    def of(cls, slices: int, room: int) -> Room:
        one, other = np.empty((2, 2, slices, room), np.int32)
        return cls(one, other, np.empty((2, slices, room, 3)))


@dataclass
class Pairs:
    """Candidates, and how long they serve. A list may hold more than it must: pairs
    that cannot touch change nothing, so that no result depends on when and how widely was searched.

    key: (pairs,) int64, node times FIRST plus triangle, or EDGES plus lower edge times FIRST plus higher edge. begin:
    (2 triangles + 1,) int64, of the pairs of nodes with triangles that belong to each triangle, then of the pairs of
    edges, each in the order of their keys. nodes:
    (pairs, 4) int32, the node and the triangle's corners, or the ends of both edges. normal: from the second to the
    first at the last look, (pairs, 3). gap: at which the cushion begins [m], (pairs,). impulse: of the last step [N s],
    (pairs,).

    path_start [m], path_velocity [m/s]: (nodes, 3), of all nodes when the list was made; skin: how far each may stray
    from this path [m], (nodes,). age: of the list; horizon: age at which it is spent [s]; width: of the skin where
    nothing is thrown off [m]. looked_at: of the search, as in `search.Found`. last_resorts: steps so far in which nodes
    had to move together.

    What follows is known of the present positions only, and measured again where it is missing. awake: indices of
    pairs that can matter in a step, ascending. weight: of their nodes, (pairs, 4); distance: [m], (pairs,); measured:
    number of the moment at which, (pairs,) int64; moment: number of the present positions. slot: number of the
    constraint that a pair is in a step, -1 if none, (pairs,) int32. touched: nodes within the thickness
    of another layer when the step began, (nodes,) bool. room: for searches.
    """

    key: np.ndarray = field(metadata=VARYING)
    begin: np.ndarray
    nodes: np.ndarray = field(metadata=VARYING)
    normal: np.ndarray = field(metadata=VARYING)
    gap: np.ndarray = field(metadata=VARYING)
    impulse: np.ndarray = field(metadata=VARYING)
    path_start: np.ndarray
    path_velocity: np.ndarray
    skin: np.ndarray
    age: float
    horizon: float
    width: float
    looked_at: int
    last_resorts: int
    awake: np.ndarray = field(metadata={"constant": True})
    weight: np.ndarray = field(metadata={"constant": True})
    distance: np.ndarray = field(metadata={"constant": True})
    measured: np.ndarray = field(metadata={"constant": True})
    slot: np.ndarray = field(metadata={"constant": True})
    touched: np.ndarray = field(metadata={"constant": True})
    moment: int = field(default=0, metadata={"constant": True})
    room: Room | None = field(default=None, metadata={"constant": True})

    @classmethod
    def none(cls, nodes: int, triangles: int, width: float) -> Pairs:
        """No pairs yet, and a list that is spent."""
        return cls(
            np.zeros(0, np.int64), np.zeros(2 * triangles + 1, np.int64), np.zeros((0, 4), np.int32), np.zeros((0, 3)),
            np.zeros(0), np.zeros(0), np.zeros((nodes, 3)), np.zeros((nodes, 3)), np.zeros(nodes), 0.0, -1.0, width,
            0, 0,
            np.zeros(0, np.int64), np.zeros((0, 4)), np.zeros(0), np.zeros(0, np.int64), np.zeros(0, np.int32),
            np.zeros(nodes, np.bool_),
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.key)

    @property
    def edges_from(self) -> int:
        """Number of the first pair of edges."""
        return int(self.begin[len(self.begin) // 2])

    def make_room(self) -> None:
        """Room for what is known of the present positions, with nothing in it; after a search or a restart."""
        m = len(self)
        self.awake = np.zeros(0, np.int64)
        self.weight, self.distance = np.empty((m, 4)), np.empty(m)
        self.measured, self.moment = np.full(m, -1, np.int64), 0
        self.slot = np.full(m, -1, np.int32)
