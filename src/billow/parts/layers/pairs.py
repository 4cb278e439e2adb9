"""Pairs of fabric that may touch: a node and a triangle, or two edges, with what is known of each."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from billow.parts.layers.rings import Shapes
from billow.parts.part import VARYING

EDGES = 1 << 61
"""Added to the key of a pair of edges."""

FIRST = 1 << 31
"""Factor of the first number in a key."""

SPARE = 1.3
"""Times by which an array of a room is longer than was asked for."""

LEVELS = 8
"""In which pairs are looked at, the more of their skins nodes have used."""

NEW = -1.0
"""Gap of a pair whose distance has not been measured."""


class Room:
    """Memory that is used again and again: to get it anew would cost more than what is done with it. needed: places of
    each slice in the last search, (slices,) int64, by kinds of pairs. shapes: of rings, when they were
    measured."""

    def __init__(self):
        self.needed: dict[int, np.ndarray] = {}
        self.shapes: Shapes | None = None
        self._arrays: dict[str, np.ndarray] = {}
        self._beside: dict[str, Room] = {}

    def __deepcopy__(self, memo) -> Room:
        """Nothing in it is worth a copy."""
        return Room()

    def beside(self, name: str) -> Room:
        """Another room, for lists that are made while those in this one are needed."""
        return self._beside.setdefault(name, Room())

    def array(self, name: str, rows: int, columns: int = 0, kind: type = float) -> np.ndarray:
        """An array (rows,) or (rows, columns); what is in it is not known."""
        array = self._arrays.get(name)
        if array is None or len(array) < rows:
            array = self._arrays[name] = np.empty((int(SPARE * rows), columns) if columns else int(SPARE * rows), kind)
        return array[:rows]

    def zeros(self, name: str, rows: int, kind: type) -> np.ndarray:
        """Likewise, of zeros, provided that whoever changes them puts them back."""
        if name not in self._arrays or len(self._arrays[name]) < rows:
            self._arrays[name] = np.zeros(int(SPARE * rows), kind)
        return self._arrays[name][:rows]

    def other(self, name: str, rows: int, columns: int = 0, kind: type = float) -> np.ndarray:
        """Likewise, another one than the last time: for a list that is made while the one before is needed."""
        last = self._arrays.pop(name, None)
        if (before := self._arrays.pop(f"{name} before", None)) is not None:
            self._arrays[name] = before
        if last is not None:
            self._arrays[f"{name} before"] = last
        return self.array(name, rows, columns, kind)


@dataclass
class Pairs:
    """Candidates, and how long they serve. A list may hold more than it must: pairs
    that cannot touch change nothing, so that no result depends on when and how widely was searched.

    key: (pairs,) int64, node times FIRST plus triangle, or EDGES plus lower edge times FIRST plus higher edge. begin:
    (touching nodes + edges + 1,) int64, of the pairs of each node, then of those of each edge with higher ones, in the
    order of their keys. nodes:
    (pairs, 4) int32, the node and the triangle's corners, or the ends of both edges. normal: from the second to the
    first at the last look, (pairs, 3). level: share of their skins that nodes have to use until a pair can matter, in
    LEVELS, (pairs,) uint8. gap: at which the cushion begins [m], (pairs,). impulse: of the last step [N s],
    (pairs,).

    path_start [m], path_velocity [m/s]: (nodes, 3), of all nodes when the list was made; skin: how far each may stray
    from this path [m], (nodes,). age: of the list; horizon: age at which it is spent [s]; width: of the skin where
    nothing is thrown off [m]. looked_at: of the search, as in `search.Found`. last_resorts: steps so far in which nodes
    had to move together.

    What follows is known of the present positions only, and measured again where it is missing. awake: indices of
    pairs that can matter in a step, ascending. weight: of their nodes, (pairs, 4); distance: [m], (pairs,); measured:
    number of the moment at which, (pairs,) int64; moment: number of the present positions. slot: number of the
    constraint that a pair is in a step, -1 if none, (pairs,) int32. touched: nodes within the thickness
    of another layer when the step began, (nodes,) bool. push: impulses of the step on nodes that do not yield [N s],
    (nodes, 3). touching: number of nodes
    that have pairs. room: for searches.
    """

    key: np.ndarray = field(metadata=VARYING)
    begin: np.ndarray
    nodes: np.ndarray = field(metadata=VARYING)
    normal: np.ndarray = field(metadata=VARYING)
    level: np.ndarray = field(metadata=VARYING)
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
    push: np.ndarray = field(metadata={"constant": True})
    touching: int = field(metadata={"constant": True})
    moment: int = field(default=0, metadata={"constant": True})
    room: Room = field(default_factory=Room, metadata={"constant": True})

    @classmethod
    def none(cls, nodes: int, touching: int, edges: int, width: float) -> Pairs:
        """No pairs yet, and a list that is spent."""
        return cls(
            np.zeros(0, np.int64), np.zeros(touching + edges + 1, np.int64), np.zeros((0, 4), np.int32),
            np.zeros((0, 3)), np.zeros(0, np.uint8), np.zeros(0), np.zeros(0), np.zeros((nodes, 3)),
            np.zeros((nodes, 3)), np.zeros(nodes),
            0.0, -1.0, width, 0, 0,
            np.zeros(0, np.int64), np.zeros((0, 4)), np.zeros(0), np.zeros(0, np.int64), np.zeros(0, np.int32),
            np.zeros(nodes, np.bool_), np.zeros((nodes, 3)), touching,
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.key)

    @property
    def edges_from(self) -> int:
        """Number of the first pair of edges."""
        return int(self.begin[self.touching])

    def make_room(self) -> None:
        """Room for what is known of the present positions, with nothing in it; after a search or a restart."""
        m = len(self)
        self.awake = np.zeros(0, np.int64)
        self.weight, self.distance = self.room.array("weight", m, 4), self.room.array("distance", m)
        self.measured, self.moment = self.room.array("measured", m, 0, np.int64), 0
        self.slot = self.room.array("slot", m, 0, np.int32)
        self.measured[:], self.slot[:] = -1, -1
