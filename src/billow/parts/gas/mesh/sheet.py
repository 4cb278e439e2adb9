"""The gas of one room between steps, and the walls around it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.parts.part import VARYING


@dataclass(frozen=True)
class Walls:
    """What is about a room. index: (n,) int64, its triangles, of which the first `own` are the bag's, the others
    virtual; triangles: (n, 3) uint32; sign: (n,), 1.0 where their normals point out of the room, else -1.0; outer:
    (n,) bool, whether the surroundings are on the other side."""

    name: str
    index: np.ndarray
    triangles: np.ndarray
    sign: np.ndarray
    outer: np.ndarray
    own: int

    @classmethod
    def of(cls, triangles: np.ndarray, rooms: Chambers, room: int, bag: int) -> Walls:
        """triangles: (all, 3), `bag` of them the bag's; rooms: on either side of each."""
        behind, ahead = np.flatnonzero(rooms.behind == room), np.flatnonzero(rooms.ahead == room)
        real, virtual = (behind[behind < bag], ahead[ahead < bag]), (behind[behind >= bag], ahead[ahead >= bag])
        index = np.concatenate([*real, *virtual])
        sign = np.concatenate([way * np.ones(len(some)) for some, way in zip(real + virtual, (1, -1) * 2, strict=True)])
        other = np.where(sign > 0.0, rooms.ahead[index], rooms.behind[index])
        own = len(real[0]) + len(real[1])
        return cls(rooms.names[room], index, np.ascontiguousarray(triangles[index]), sign, other == OUTSIDE, own)

    def local(self, triangles: np.ndarray, sign: float) -> np.ndarray:
        """Numbers here of triangles of the bag, (m,), seen from the side that `sign` says."""
        mine = np.flatnonzero(self.sign == sign)
        return mine[np.searchsorted(self.index[mine], triangles)]


@dataclass
class Sheet:
    """The gas of a room between steps.

    Of the cells that hold gas, in order of their keys: key (cells,) int64; held (cells, species + 4), masses [kg],
    momentum [kg m/s] and energy [J]; temperature [K] and speed of sound [m/s], (cells,). force: of the gas on corners
    of its triangles [N], (triangles, 3, 3). owed: work [J] that each triangle got and the gas beside it did
    not give yet, (triangles,).
    """

    key: np.ndarray = field(metadata=VARYING)
    held: np.ndarray = field(metadata=VARYING)
    temperature: np.ndarray = field(metadata=VARYING)
    sound: np.ndarray = field(metadata=VARYING)
    force: np.ndarray = field(metadata=VARYING)
    owed: np.ndarray = field(metadata=VARYING)

    @classmethod
    def empty(cls, species: int) -> Sheet:
        """Of a room that has joined another."""
        none = np.empty(0)
        held, force = np.empty((0, species + 4)), np.empty((0, 3, 3))
        return cls(np.empty(0, np.int64), held, none, none.copy(), force, none.copy())

    @property
    def species(self) -> int:
        return self.held.shape[1] - 4

    # Sums over the cells, and what they are of: made anew when the cells are others.
    summed = None

    def sums(self) -> np.ndarray:
        """Sums of `held` over the cells, (species + 4,)."""
        if self.summed is None or self.summed[0] is not self.held:
            n, columns = self.held.shape
            parts = np.empty((-(-n // CHUNK), columns))
            _sum_up(n, self.held, parts)
            self.summed = self.held, parts.sum(axis=0)
        return self.summed[1]

    @property
    def masses(self) -> np.ndarray:
        """[kg], (species,)."""
        return self.sums()[: self.species].copy()

    @property
    def energy(self) -> float:
        """Energy [J], less what is owed."""
        return float(self.sums()[-1] - self.owed.sum())


@kernel
def _sum_up(n, held, sums_out):
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        for k in range(held.shape[1]):
            sums_out[chunk, k] = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            for k in range(held.shape[1]):
                sums_out[chunk, k] += held[i, k]
