"""Rooms: what the gas keeps apart. A room is a chamber, or a strip of a folded chamber.

Gas goes from strip to strip through the walls at fold lines, which are openings. Two strips become one room when no
cell holds fabric of both of them except at their opening: the lattice then knows the way from one to the other. They
become one, too, when fabric has gone so far through the wall between them that much of one is inside out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.cut_cells import CutCells
from billow.geometry.folding.strips import Strips
from billow.geometry.lattice_clipping import COLUMNS, Fragments
from billow.geometry.surface import Surface
from billow.parts.gas.mesh.exchange import Ways
from billow.parts.gas.mesh.sheet import Sheet, Walls
from billow.parts.gas.supply.mixture import mixture_gamma, mixture_gas_constant, mixture_temperature
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import OPENING, Passage, Passages
from billow.parts.gas.supply.supply import Supply

FOLD = -1
"""Instead of the number of a passage: an opening at a fold line."""
TURNED = 0.1
"""Of a strip's volume, that may lie inside out behind fabric that went through a wall at a fold line."""

NO_CELLS = CutCells(
    np.empty(0, np.int64), np.empty(0), np.empty((0, 3)), np.empty((0, 3)),
    Fragments(
        np.empty((0, COLUMNS)), np.empty(0, np.int32), np.zeros(1, np.int64), np.empty(0, np.int32), np.empty((0, 3)),
    ),
    np.zeros(1, np.int32), 0.0,
)  # fmt: skip
"""Of a room that has joined another."""


@dataclass(frozen=True)
class Rooms:
    """triangles: (n, 3), those of the bag and then virtual ones. chambers: which room lies on either side of each.
    walls: of each room, none of one that has joined another. ways: into them, out of them and between them.
    of_chamber: the rooms of each chamber."""

    triangles: np.ndarray
    chambers: Chambers
    walls: tuple[Walls, ...]
    ways: Ways
    of_chamber: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, supply: Supply, surface: Surface, cell: float, strips: Strips | None, joined: np.ndarray) -> Rooms:
        """joined: of each strip the number of its room, which is that of one of its strips. Without strips every
        chamber is a room. cell: edge of a cell [m]."""
        triangles, chambers, own = surface.triangles, supply.chambers, surface.triangle_count
        fed, origin = supply, tuple(range(len(supply.passages.rows)))
        of_chamber = tuple((c,) for c in range(chambers.count))
        if strips is not None:
            triangles, chambers = strips.triangles, _joined(strips.chambers, joined)
            fed, origin = _shared_out(supply, surface, strips, chambers)
            of_chamber = (tuple(np.unique(joined).tolist()),)
        walls = tuple(Walls.of(triangles, chambers, room, own) for room in range(chambers.count))
        return cls(triangles, chambers, walls, Ways(fed, surface, walls, cell, origin), of_chamber)

    @property
    def lived_in(self) -> tuple[int, ...]:
        return tuple(room for rooms in self.of_chamber for room in rooms)

    def joining(self, cuts: tuple[CutCells, ...]) -> list[tuple[int, int]]:
        """Rooms that are to join now, by pairs, lower number first; no room is in two pairs."""
        pairs = [
            (min(row.behind, row.ahead), max(row.behind, row.ahead), k)
            for k, row in enumerate(self.ways.supply.passages.rows)
            if self.ways.origin[k] == FOLD
        ]
        turned = [(a, b) for a, b, _ in pairs if any(_turned(cuts[r], cuts[o]) for r, o in ((a, b), (b, a)))]
        found, taken = [], set()
        for pair in [*turned, *self._meeting(cuts, pairs)]:
            if not taken & set(pair):
                found.append(pair)
                taken |= set(pair)
        return found

    def _meeting(self, cuts: tuple[CutCells, ...], pairs: list[tuple[int, int, int]]) -> Iterator[tuple[int, int]]:
        """Rooms whose fabric shares no cell but at their opening; pairs: rooms, and the number of their opening."""
        fabric = {
            r: np.unique(cut.key[cut.cell[cut.fragments.on(np.arange(self.walls[r].own))]])
            for r, cut in enumerate(cuts)
        }
        for one, other, k in pairs:
            shared = np.intersect1d(fabric[one], fabric[other], assume_unique=True)
            behind = self.ways.supply.passages.rows[k].behind
            cut, door = cuts[behind], self.ways.through_walls[k][0]
            if np.isin(shared, cut.key[cut.cell[cut.fragments.on(door)]]).all():
                yield one, other


def inside_out(cuts: Sequence[CutCells]) -> float:
    """Volume [cells] of some rooms together that is inside out, which is not above nothing: where fabric lies in
    itself. Walls between them count for nothing: what one lacks behind them the other has."""
    keys = np.unique(np.concatenate([cut.key[cut.volume < 0.0] for cut in cuts]))
    return float(np.minimum(sum(_volume(cut, keys) for cut in cuts), 0.0).sum())


def _volume(cut: CutCells, keys: np.ndarray) -> np.ndarray:
    """Volume [cells] of a room in some cells, (n,)."""
    at = np.minimum(np.searchsorted(cut.key, keys), max(len(cut.key) - 1, 0))
    return np.where(cut.key[at] == keys, cut.volume[at], 0.0) if len(cut.key) else np.zeros(len(keys))


def _turned(cut: CutCells, other: CutCells) -> bool:
    """Whether more than `TURNED` of a room is inside out where another one has as much too much."""
    negative = cut.volume < 0.0
    lacks, has = -cut.volume[negative], _volume(other, cut.key[negative])
    return float(np.minimum(lacks, np.maximum(has, 0.0)).sum()) > TURNED * cut.total


def _joined(chambers: Chambers, joined: np.ndarray) -> Chambers:
    """Rooms instead of strips; walls within a room are none."""
    behind, ahead = (
        np.where(s == OUTSIDE, OUTSIDE, joined[s]).astype(np.int32) for s in (chambers.behind, chambers.ahead)
    )
    within = behind == ahead
    behind[within], ahead[within] = OUTSIDE, OUTSIDE
    return Chambers(chambers.names, behind, ahead)


def _shared_out(supply: Supply, surface: Surface, strips: Strips, rooms: Chambers) -> tuple[Supply, tuple[int, ...]]:
    """The supply of a single chamber as its rooms have it, and of each passage the number it had, or FOLD."""
    own, area = surface.triangle_count, strips.area
    room = np.where(rooms.behind[:own] != OUTSIDE, rooms.behind[:own], rooms.ahead[:own])
    rows, origin = [], []
    for k, row in enumerate(supply.passages.rows):
        for r in np.unique(room[row.triangles]):
            part = row.triangles[room[row.triangles] == r]
            share = area[part].sum() / area[row.triangles].sum()
            sides = {side: r for side in ("behind", "ahead") if getattr(row, side) != OUTSIDE}
            rows.append(replace(row, triangles=part, area=share * row.area, **sides))
            origin.append(k)
    behind, ahead = rooms.behind[own:], rooms.ahead[own:]
    for pair in sorted(set(zip(behind.tolist(), ahead.tolist(), strict=True)) - {(OUTSIDE, OUTSIDE)}):
        wall = own + np.flatnonzero((behind == pair[0]) & (ahead == pair[1]))
        rows.append(Passage("fold", OPENING, ORIFICE, *pair, triangles=wall, area=1.0))
        origin.append(FOLD)
    sources = []
    for source in supply.sources:
        mouth = np.isin(surface.triangles, source.jets.mouth_nodes).all(axis=1)
        where = int(np.bincount(room[mouth & (room != OUTSIDE)]).argmax())
        sources.append(replace(source, inflator=replace(source.inflator, chamber=where)))
    cooling = supply.heat_conductance
    if cooling is not None:
        cloth = surface.triangles_of_kind("fabric")
        cloth = cloth[room[cloth] != OUTSIDE]
        share = np.bincount(room[cloth], area[cloth], rooms.count)
        cooling = cooling[0] * share / share.sum()
    fed = replace(
        supply, chambers=rooms, passages=Passages(tuple(rows)), sources=tuple(sources), heat_conductance=cooling
    )
    return fed, tuple(origin)


def join_sheets(table: np.ndarray, a: Sheet, b: Sheet, of_a: Walls, of_b: Walls, walls: Walls) -> Sheet:
    """The gas of two rooms as that of one, whose walls these are."""
    key = np.union1d(a.key, b.key)
    in_a, in_b = np.searchsorted(key, a.key), np.searchsorted(key, b.key)
    held, temperature, sound = np.zeros((len(key), a.held.shape[1])), np.zeros(len(key)), np.zeros(len(key))
    for sheet, at in ((a, in_a), (b, in_b)):
        held[at] += sheet.held
        temperature[at], sound[at] = sheet.temperature, sheet.sound
    for i in np.intersect1d(in_a, in_b):
        masses, momentum = held[i, :-4], held[i, -4:-1]
        thermal = held[i, -1] - 0.5 * float(momentum @ momentum) / masses.sum()
        temperature[i] = t = mixture_temperature(table, masses, thermal, temperature[i])
        sound[i] = np.sqrt(mixture_gamma(table, masses, t) * mixture_gas_constant(table, masses) / masses.sum() * t)
    n = walls.own
    force, owed = np.zeros((len(walls.index), 3, 3)), np.zeros(len(walls.index))
    order = np.argsort(np.concatenate([of_a.index[: of_a.own], of_b.index[: of_b.own]]))
    force[:n] = np.concatenate([a.force[: of_a.own], b.force[: of_b.own]])[order]
    owed[:n] = np.concatenate([a.owed[: of_a.own], b.owed[: of_b.own]])[order]
    return Sheet(key, held, temperature, sound, force, owed)
