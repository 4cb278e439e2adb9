"""What comes into the chambers, leaves them and passes between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.geometry.chambers import OUTSIDE
from billow.geometry.surface import Surface
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh.moved import Moved
from billow.parts.gas.mesh.openings import link
from billow.parts.gas.mesh.passages import Side, flow_through, lose_heat, mean_lead, surroundings
from billow.parts.gas.mesh.sheet import Walls
from billow.parts.gas.mesh.sources import blow
from billow.parts.gas.mesh.state import MeshState
from billow.parts.gas.mesh.thermodynamics import P
from billow.parts.gas.supply.passages import FABRIC, OPENING, Passage
from billow.parts.gas.supply.supply import Supply


@dataclass(frozen=True)
class Ways:
    """All ways into the rooms, out of them and between them, as they lie in their walls.

    supply: its chambers are the rooms. surface: of the bag. walls: of the rooms. cell: edge of a cell [m]. origin: of
    each passage its number in the bag, below zero for one that is always open."""

    supply: Supply
    surface: Surface
    walls: tuple[Walls, ...]
    cell: float
    origin: tuple[int, ...]

    @cached_property
    def through_walls(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Of each passage, its triangles as numbers among the walls of the chamber behind and of the one ahead."""
        found = []
        for row in self.supply.passages.rows:
            sides = []
            for chamber, sign in ((row.behind, 1.0), (row.ahead, -1.0)):
                none = np.empty(0, np.int64)
                sides.append(none if chamber == OUTSIDE else self.walls[chamber].local(row.triangles, sign))
            found.append(tuple(sides))
        return found

    @cached_property
    def mouths(self) -> list[np.ndarray]:
        """Of each source, its mouth as numbers among the walls of its chamber."""
        found = []
        for source in self.supply.sources:
            walls = self.walls[source.inflator.chamber]
            at_mouth = np.isin(walls.triangles, source.jets.mouth_nodes).all(axis=1)
            is_mouth = np.isin(walls.index, self.surface.triangles_of_kind("mouth"))
            found.append(np.flatnonzero(at_mouth & is_mouth if (at_mouth & is_mouth).any() else at_mouth))
        return found

    @cached_property
    def cooling_walls(self) -> list[np.ndarray]:
        """Of each chamber, the outer fabric as numbers among its walls."""
        fabric = self.surface.triangles_of_kind("fabric")
        return [np.flatnonzero(walls.outer & np.isin(walls.index, fabric)) for walls in self.walls]

    def links(self, chamber: int, is_open: np.ndarray) -> np.ndarray:
        """Walls of a room that gas passes freely, (triangles,) bool."""
        name = is_open.tobytes()
        if name not in self._links:
            self._links.clear()
            self._links[name] = [np.zeros(len(walls.index), np.bool_) for walls in self.walls]
            for k, row in enumerate(self.supply.passages.rows):
                if self.is_link(k, is_open):
                    for side, own in zip((row.behind, row.ahead), self.through_walls[k], strict=True):
                        self._links[name][side][own] = True
        return self._links[name][chamber]

    @cached_property
    def _links(self) -> dict[bytes, list[np.ndarray]]:
        """By what is open."""
        return {}

    def is_link(self, k: int, is_open: np.ndarray) -> bool:
        row = self.supply.passages.rows[k]
        between = OUTSIDE not in (row.behind, row.ahead)
        return row.kind == OPENING and between and row.coefficient > 0.0 and self.is_open(k, is_open)

    def is_open(self, k: int, is_open: np.ndarray) -> bool:
        """is_open: of the bag's passages."""
        return self.origin[k] < 0 or bool(is_open[self.origin[k]])


@dataclass(frozen=True)
class Place:
    """Where a passage lies in the surface before a step (`old`) or after it. main: the chamber that its geometry is
    read from; fragments: its fragments there; both: those in the chambers behind and ahead (None: surroundings);
    share: of each, what contact leaves open."""

    old: bool
    main: int
    fragments: np.ndarray
    both: tuple[np.ndarray | None, np.ndarray | None]
    share: np.ndarray

    @classmethod
    def find(
        cls, row: Passage, walls: tuple[np.ndarray, np.ndarray], chambers: dict[int, Moved], corners: np.ndarray | None,
        old: bool,
    ) -> Place:  # fmt: skip
        """walls: its triangles in both chambers. corners: share of each triangle's corners that is touched."""
        both = tuple(
            None if c == OUTSIDE else chambers[c].fragments_of(own, old)
            for c, own in zip((row.behind, row.ahead), walls, strict=True)
        )
        main = row.behind if row.behind != OUTSIDE else row.ahead
        fragments = both[0] if both[0] is not None else both[1]
        share = np.ones(len(fragments))
        if corners is not None and row.through_blocked < 1.0:
            _, triangle = chambers[main].fragments(old)
            share -= (1.0 - row.through_blocked) * corners[chambers[main].walls.index[triangle[fragments]]]
        return cls(old, main, fragments, both, share)


@dataclass
class Exchange:
    """A step of the structure. chambers: by the number of their room. present: area of each passage [m^2]. places: of
    each passage, where it lies in the surface before and after the step, which count as the time says; fabric counts as
    after it, and nowhere if nothing passes it. mouths, cooling: fragments of each source's mouth, and of the outer
    fabric of each room if it loses heat."""

    ways: Ways
    gas: MeshState
    chambers: dict[int, Moved]
    positions: np.ndarray
    velocity: np.ndarray
    present: list[float]
    places: list[tuple[Place, ...]]
    mouths: list[np.ndarray]
    cooling: dict[int, np.ndarray]

    @classmethod
    def begin(cls, ways: Ways, gas: MeshState, chambers: dict[int, Moved], bag: Bag, velocity: np.ndarray) -> Exchange:
        """Look up the fragments, and how much of every passage is blocked."""
        supply, triangles = ways.supply, bag.surface.triangles
        passages = supply.passages
        areas, first = passages.measure(triangles, bag.positions, bag.touched), passages.table.first_chunk
        sums = [areas[first[k] : first[k + 1]].sum(axis=0) for k in range(len(passages.rows))]
        blocked = (a[1] for a, row in zip(sums, passages.rows, strict=True) if row.through_blocked < 1.0)
        gas.blocked_area = float(sum(blocked))
        sealed = [r.coefficient == 0.0 and ways.is_open(k, gas.is_open) for k, r in enumerate(passages.rows)]
        blocks = any(r.through_blocked < 1.0 and not shut for r, shut in zip(passages.rows, sealed, strict=True))
        touched = bag.touched is not None and blocks
        corners = bag.touched.any(axis=0)[triangles].mean(axis=1) if touched else None
        places = []
        for walls, row, shut in zip(ways.through_walls, passages.rows, sealed, strict=True):
            times = () if shut else (False,) if row.kind == FABRIC else (True, False)
            places.append(tuple(Place.find(row, walls, chambers, corners, old) for old in times))
        mouths = zip(supply.sources, ways.mouths, strict=True)
        losing = {} if supply.heat_conductance is None else chambers
        return cls(
            ways, gas, chambers, bag.positions, velocity, [float(a[0]) for a in sums], places,
            [chambers[source.inflator.chamber].fragments_of(own) for source, own in mouths],
            {c: chamber.fragments_of(ways.cooling_walls[c]) for c, chamber in losing.items()},
        )  # fmt: skip

    def flow(self, middle: float, dt: float) -> None:
        """What flows in a part of dt [s] about the time `middle` [s], into `gained` of the chambers and the books."""
        for k, row in enumerate(self.ways.supply.passages.rows):
            if row.coefficient > 0.0 and self.ways.is_open(k, self.gas.is_open):
                self._pass(k, middle, dt)
        self._blow(middle, dt)
        self._cool(dt)

    def _pass(self, k: int, middle: float, dt: float) -> None:
        gas, table, row = self.gas, self.ways.supply.table, self.ways.supply.passages.rows[k]
        if self.ways.is_link(k, gas.is_open):
            self._link(k, dt)
            return
        books = np.zeros((2, len(table) + 1))
        sign = 1.0 if row.behind != OUTSIDE else -1.0
        for place in self.places[k]:
            chamber = self.chambers[place.main]
            rows, triangle = chamber.fragments(place.old)
            weight = 1.0 - chamber.middle if place.old else chamber.middle
            behind, ahead = self._both(k, place)
            flow_through(
                table, self.ways.supply.passages.table, k, self.present[k], tuple(behind), tuple(ahead), rows,
                place.fragments, triangle, chamber.walls.triangles, self.velocity, self.ways.cell**2, place.share, sign,
                middle, dt, 1.0 if row.kind == FABRIC else weight, books,
            )  # fmt: skip
        gas.passed[self.ways.origin[k]] += books[:, :-1].sum(axis=1)
        if OUTSIDE in (row.behind, row.ahead):
            out, back = (0, 1) if row.ahead == OUTSIDE else (1, 0)
            gas.out += books[out, :-1]
            gas.drawn += books[back, :-1]
            gas.enthalpy_out += float(books[out, -1])
            gas.enthalpy_in += float(books[back, -1])

    def _link(self, k: int, dt: float) -> None:
        """Free flow; fragments before and after the step count as the time says, as those of walls do."""
        row = self.ways.supply.passages.rows[k]
        a, b = self.chambers[row.behind], self.chambers[row.ahead]
        sides = (
            (a.old, a.patches.of_old, b.patches.of_old, 1.0 - a.middle),
            (a.new, a.patches.of_new, b.patches.of_new, a.middle),
        )
        for place, (cut, patch_a, patch_b, share) in zip(self.places[k], sides, strict=True):
            fragments, there = place.both
            cluster_a, cluster_b = a.of[a.cells_of(fragments, place.old)], b.of[b.cells_of(there, place.old)]
            a.open_door(patch_a[fragments], b, cluster_b)
            b.open_door(patch_b[there], a, cluster_a)
            passed = link(
                a.state, b.state, a.total, b.total, a.gained, b.gained, cluster_a, cluster_b,
                a.door_area, b.door_area, cut.fragments.rows, fragments, cut.fragments.triangle, a.walls.triangles,
                self.velocity, self.ways.cell**2, dt, share, len(self.ways.supply.table),
            )  # fmt: skip
            if self.ways.origin[k] >= 0:
                self.gas.passed[self.ways.origin[k]] += passed

    def _blow(self, middle: float, dt: float) -> None:
        times = middle - 0.5 * dt, middle + 0.5 * dt
        for source, fragments in zip(self.ways.supply.sources, self.mouths, strict=True):
            chamber = self.chambers[source.inflator.chamber]
            cluster = chamber.of[chamber.cells_of(fragments)]
            energy, impulse = blow(
                source, self.ways.supply.table, self.positions, self.velocity[source.jets.mouth_nodes].mean(axis=0),
                self.gas.origin, self.ways.cell, chamber.new.fragments.rows, fragments, cluster, chamber.state, times,
                chamber.gained,
            )  # fmt: skip
            if energy:
                chamber.fed = np.append(chamber.fed, cluster)
            self.gas.enthalpy_in += energy
            self.gas.jet_impulse += impulse

    def _cool(self, dt: float) -> None:
        supply = self.ways.supply
        for c, fragments in self.cooling.items():
            if self.ways.supply.heat_conductance[c] == 0.0:
                continue
            chamber = self.chambers[c]
            self.gas.heat_lost += lose_heat(
                supply.table, chamber.state, chamber.total, chamber.of[chamber.cells_of(fragments)],
                chamber.new.fragments.rows, fragments, supply.ambient.temperature, float(supply.heat_conductance[c]),
                dt, chamber.gained,
            )  # fmt: skip

    def _both(self, k: int, place: Place) -> tuple[Side, Side]:
        """The gas on both sides of passage k."""
        supply, found = self.ways.supply, []
        row = supply.passages.rows[k]
        for c, own in zip((row.behind, row.ahead), place.both, strict=True):
            if own is None:
                found.append(surroundings(supply.table, supply.ambient, len(place.fragments)))
            else:
                moved = self.chambers[c]
                mass, cluster = moved.total[:, :-4].sum(axis=1), moved.of[moved.cells_of(own, place.old)]
                coming, leaving = (np.zeros(P + 1), 0.0) if row.kind == FABRIC else moved.about(cluster)
                patch = (moved.patches.of_old if place.old else moved.patches.of_new)[own]
                found.append(Side(moved.state, moved.gained, mass, cluster, coming, leaving, patch, moved.through))
        return found[0], found[1]

    def _pressures(self, chamber: int, own: np.ndarray | None, fragments: int) -> np.ndarray:
        """Pressure [Pa] on fragments in a chamber at the end of the step, of the surroundings for None."""
        if own is None:
            return np.full(fragments, self.ways.supply.ambient.pressure)
        moved = self.chambers[chamber]
        return moved.state[moved.of[moved.cells_of(own)], P]

    def open_passages(self, time: float, dt: float) -> None:
        """Open what opens by the pressures on its own area at `time` [s], or bursts in the step after it."""
        for k, row in enumerate(self.ways.supply.passages.rows):
            if not self.ways.is_open(k, self.gas.is_open):
                place = self.places[k][-1]
                behind, ahead = (
                    self._pressures(c, own, len(place.fragments))
                    for c, own in zip((row.behind, row.ahead), place.both, strict=True)
                )
                rows, _ = self.chambers[place.main].fragments(False)
                lead = mean_lead(behind, ahead, rows, place.fragments)
                self.gas.is_open[self.ways.origin[k]] = lead >= row.opens_at or time + dt >= row.bursts_at
