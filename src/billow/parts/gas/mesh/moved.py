"""The gas of one chamber in a step of the structure: its parts, and in each what happens to every cluster."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from billow.base.compiled import scalar
from billow.base.errors import NumericalStop
from billow.base.scratch import Scratch
from billow.geometry.cut_cells import CutCells, neighbours, unite
from billow.geometry.lattice_clipping import NORMAL
from billow.parts.gas.mesh.balance import add_fluxes, forget_slopes, gather, share_out
from billow.parts.gas.mesh.cell_maps import blend, find_pace, geometry, spread, through
from billow.parts.gas.mesh.clusters import NOBODY, Clusters, find_clusters
from billow.parts.gas.mesh.film import Drag, brake, find_drag, pull_along
from billow.parts.gas.mesh.fluxes import face_fluxes
from billow.parts.gas.mesh.passages import gas_before, gas_leaving
from billow.parts.gas.mesh.patches import Patches
from billow.parts.gas.mesh.sheet import Sheet, Walls
from billow.parts.gas.mesh.slopes import HALF, VALUES, find_slopes
from billow.parts.gas.mesh.thermodynamics import P, Y
from billow.parts.gas.mesh.walls import BOOKS, add_walls, load
from billow.parts.gas.mesh.work import debts, settle

MOST_TRIES = 50
"""To find clusters that all hold gas; in each, those that do not are adopted."""

NEGATIVE = NumericalStop.declare(
    "E-NUM-021",
    "the mesh gas has run out of internal energy",
    where="chamber {chamber}, cell at ({x:.4g}, {y:.4g}, {z:.4g}) m, t = {time:.4f} ms",
    why="{volume:.3g} cells of gas there would keep {energy:.3g} J, whatever the scheme",
    cause="fabric that moves faster than the gas can follow, or a bag that collapsed",
    remedy="reduce run.dt_scale; look at the last frames",
)


@dataclass
class Moved:
    """A chamber in a step of the structure: its cells, those of the surface before and after together."""

    walls: Walls
    scratch: Scratch
    table: np.ndarray
    h: float
    origin: np.ndarray
    old: CutCells
    new: CutCells
    velocity: np.ndarray
    is_link: np.ndarray
    second_order: bool
    film_friction: bool
    key: np.ndarray
    in_old: np.ndarray
    in_new: np.ndarray
    beside: np.ndarray
    patches: Patches
    held: np.ndarray
    temperature: np.ndarray
    sound: np.ndarray
    adopted: int = 0
    lost: int = 0
    donors: int = 0
    drag: Drag | None = None

    @classmethod
    def begin(
        cls, walls: Walls, sheet: Sheet, scratch: Scratch, table: np.ndarray, h: float, origin: np.ndarray,
        cuts: tuple[CutCells, CutCells], velocity: np.ndarray, is_link: np.ndarray, second_order: bool,
        film_friction: bool,
    ) -> Moved:  # fmt: skip
        """h, origin: of the lattice [m]. cuts: the surface before and after; velocity: of the nodes in between [m/s];
        is_link: (triangles,) bool, triangles through which gas passes freely."""
        old, new = cuts
        with_gas, at_sheet, at_old = unite(sheet.key, old.key)
        key, at_both, in_new = unite(with_gas, new.key)
        in_sheet, in_old = through(at_both, at_sheet), through(at_both, at_old)
        n, species = len(key), len(table)
        held, temperature, sound = cls._room(scratch, n, species)
        spread(n, in_sheet, sheet.held, sheet.temperature, sheet.sound, held, temperature, sound)
        return cls(
            walls, scratch, table, h, origin, old, new, velocity, is_link, second_order, film_friction, key, in_old,
            in_new,
            neighbours(key), Patches.find(in_old, in_new, old, new, walls.triangles, velocity, scratch), held,
            temperature, sound,
        )  # fmt: skip

    @staticmethod
    def _room(scratch: Scratch, n: int, species: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Memory for what n cells hold, their temperature and speed of sound; what was taken before is still there."""
        scratch.pass_on()
        return (
            scratch.takes_turns("held", n, species + 4),
            scratch.takes_turns("temperature", n),
            scratch.takes_turns("sound", n),
        )

    def parts(self, sheet: Sheet, positions: np.ndarray, dt: float, parts: int, time: float) -> Iterator[float]:
        """Advance by dt [s] from `time` in equal parts; positions [m]: of the nodes at the start. Stops in each, once
        the state at its start is known: sources, passages and openings add to `gained`, say which clusters are `fed`
        and how fast [m/s] gas leaves `through` the patches of holes. Yields the time [s] in its middle."""
        n, species, dt = len(self.key), len(self.table), dt / parts
        take = self.scratch.take
        whole = take("whole", 2, n)
        self.volume = volume = whole if parts == 1 else take("volume", 2, n)
        # What is of use at different times only lies in the same memory: centroids and then fluxes, speeds and then
        # states half a step later, scratch of clusters and then slopes.
        aperture, centroid, pace = take("aperture", n, 3), take("passing", n, 3), take("half", n, 3)
        patches, doors = self.patches, self._doors()
        flux, owed = take("passing", n, 3, VALUES), take("owed", len(self.walls.index))
        debts(len(owed), self.walls.triangles, positions, self.h**2, sheet.owed, owed)
        for part in range(parts):
            begin, end = part / parts, (part + 1) / parts
            self.middle = middle = 0.5 * (begin + end)
            geometry(
                n, self.key, self.in_old, self.in_new, self.old.volume, self.new.volume, self.old.centroid,
                self.new.centroid, whole, centroid,
            )  # fmt: skip
            blend(
                n, self.beside, self.in_old, self.in_new, self.old.aperture, self.new.aperture, whole, begin, end,
                volume, aperture,
            )  # fmt: skip
            if parts > 1:
                patches.turn(self.old, self.new, middle)
            find_pace(n, self.held, self.sound, pace)
            clusters = self._gather(volume, aperture, centroid, pace, doors, dt, time + part * dt)
            count, special = len(clusters.before), clusters.special
            self.gained, self.fed = self.scratch.zeros("gained", special, species + 4), np.empty(0, np.int32)
            self.through = self.scratch.zeros("through", len(patches.old))
            self.door, self.beyond = np.full(len(patches.old), -1, np.int32), np.empty((0, 3 + VALUES))
            yield time + (part + 0.5) * dt
            if self.film_friction:
                self._brake(sheet.owed, dt)
            slope, half = take("slope", count, 3, VALUES), take("half", count, HALF)
            find_slopes(
                count, clusters.start, clusters.members, clusters.of, self.beside, aperture, patches.start,
                patches.rows, self.through, self.door, self.beyond, self.state, self.place, dt / self.h,
                self.second_order, slope, half,
            )  # fmt: skip
            self._finish(flux, slope, half, owed, dt, time + part * dt)
            settle(patches.triangle, self.booked, sheet.owed)
            owed.fill(0.0)

    def _gather(
        self, volume: np.ndarray, aperture: np.ndarray, centroid: np.ndarray, pace: np.ndarray, doors: np.ndarray,
        dt: float, time: float,
    ) -> Clusters:  # fmt: skip
        """The clusters of a part, what they hold, and their states. Cells that are inside out hold less than nothing,
        so that with cells of thinner gas they may be a cluster that has room and no gas: it is adopted."""
        n, species, take, starved = len(self.key), len(self.table), self.scratch.take, NOBODY
        for tries in range(MOST_TRIES):
            self.clusters = clusters = find_clusters(
                self.key, self.beside, volume, aperture, self.patches.start, pace, doors, dt / self.h, self.scratch,
                starved,
            )  # fmt: skip
            count, special = len(clusters.before), clusters.special
            self.total, self.state = take("total", special, species + 4), take("state", count, Y + species)
            self.place, bad = take("place", count, 3), np.empty(count, np.bool_)
            gather(
                count, special, clusters.start, clusters.members, clusters.before, clusters.after, self.table,
                self.held, self.temperature, self.sound, volume[1], centroid, self.h**3, self.total, self.state,
                self.place, bad,
            )  # fmt: skip
            if not bad.any():
                break
            first = int(bad.argmax())
            if tries + 1 == MOST_TRIES:
                alone = self.held[clusters.members[clusters.start[first]]]
                raise self._negative(self.total[first] if first < special else alone, first, time)
            starved = bad[clusters.of] | (starved if len(starved) else np.zeros(n, np.bool_))
        self.of, self.aperture = clusters.of, aperture
        self.door_area = np.bincount(clusters.of, doors, count) if self.is_link.any() else doors
        self.adopted, self.lost = self.adopted + clusters.adopted, self.lost + clusters.lost
        return clusters

    def _finish(
        self, flux: np.ndarray, slope: np.ndarray, half: np.ndarray, owed: np.ndarray, dt: float, time: float
    ) -> None:  # fmt: skip
        """Fluxes and walls; where a cluster would run out of energy, again with it as a donor cell."""
        half[self.fed, :VALUES] = self.state[self.fed, :VALUES]  # the half step knows nothing of sources
        n, clusters, patches, aperture = len(self.key), self.clusters, self.patches, self.aperture
        count, special, start, members = len(clusters.before), clusters.special, clusters.start, clusters.members
        held, temperature, sound = self._room(self.scratch, n, len(self.table))
        state = self.scratch.take("new_state", special, self.state.shape[1])
        bad, face, room = np.empty(count, np.bool_), self.h**2, self.h**3
        self.booked = self.scratch.take("booked", len(patches.old), BOOKS)
        while True:
            face_fluxes(
                n, self.key, self.beside, aperture, clusters.of, half, slope, self.place, self.second_order, flux
            )
            add_fluxes(
                count, special, start, members, self.beside, aperture, clusters.of, clusters.after, self.table,
                self.held, self.total, self.gained, self.state, flux, face, dt, held, temperature, sound, bad,
            )  # fmt: skip
            add_walls(
                special, start, members, clusters.after, patches.start,
                patches.triangle, patches.rows, self.is_link, self.through, self.table, self.state, half, slope,
                self.place, self.total, self.gained, owed, face, room, dt, held, temperature, sound, state, bad,
                self.booked,
            )  # fmt: skip
            if not bad.any():
                break
            hopeless, first = forget_slopes(bad, self.state, slope, half)
            if hopeless == bad.sum():
                raise self._negative(held[members[start[first]]], first, time)
            self.donors += int(bad.sum()) - hopeless
        share_out(
            count, start, members, self.in_old, self.in_new, self.new.volume, self.old.centroid, self.new.centroid,
            self.place, slope, clusters.after, self.volume[1], self.table, held, temperature, sound,
        )  # fmt: skip
        self.held, self.temperature, self.sound, self.state = held, temperature, sound, state

    def _brake(self, owed: np.ndarray, dt: float) -> None:
        """Friction in films; owed: work [J] that triangles got and the gas did not give yet."""
        patches = self.patches
        cluster = self.of[np.repeat(np.arange(len(self.key)), np.diff(patches.start))]
        is_wall = ~self.is_link[patches.triangle] & (self.through == 0.0)
        self.drag = find_drag(cluster, patches.rows, is_wall, self.state, self.clusters.before, self.h, dt)
        brake(self.drag, cluster, patches.triangle, patches.rows, dt * self.h**2, self.gained, owed)

    def push(
        self, sheet: Sheet, before: np.ndarray, after: np.ndarray, ambient: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """New forces on the fabric. before, after: positions of the nodes [m]; ambient: pressure [Pa]. Returns the work
        [J] of the gas on each triangle, and of the ambient pressure against it."""
        walls, patches, n, fragments = self.walls, self.patches, len(self.walls.index), self.new.fragments
        work, against = np.empty(n), np.empty(n)
        load(
            n, walls.triangles, before, after, fragments.first, fragments.number, fragments.levers, patches.of_new,
            self.booked, self.is_link, walls.sign, walls.outer, ambient, sheet.force, work, against,
        )  # fmt: skip
        if self.drag is not None:
            added = pull_along(
                self.drag, len(patches.old), patches.of_new, fragments.triangle, fragments.rows, self.h**2, sheet.force
            )
            work += 0.5 * (added * (after - before)[walls.triangles]).sum(axis=(1, 2))
        self.scratch.keep()
        sheet.owed += work
        cells = _close_up(self.key, self.held, self.temperature, self.sound)
        sheet.key, sheet.held = self.key[:cells], self.held[:cells]
        sheet.temperature, sheet.sound = self.temperature[:cells], self.sound[:cells]
        return work, against

    def _negative(self, held: np.ndarray, cluster: int, time: float) -> NumericalStop:
        x, y, z = self.origin + self.place[cluster] * self.h
        m, momentum = held[:-4].sum(), held[-4:-1]
        energy = held[-1] - 0.5 * float(momentum @ momentum) / m
        volume = self.clusters.after[cluster]
        return NEGATIVE(chamber=self.walls.name, x=x, y=y, z=z, time=1e3 * time, volume=volume, energy=energy)

    def _doors(self) -> np.ndarray:
        """Openings to other rooms in each cell [faces], the larger of those before and after, (cells,)."""
        free = np.flatnonzero(self.is_link)
        if not len(free):
            return np.zeros(len(self.key))
        both = []
        for old in (True, False):
            mine, (rows, _) = self.fragments_of(free, old), self.fragments(old)
            size = np.sqrt((rows[mine, NORMAL : NORMAL + 3] ** 2).sum(axis=1))
            both.append(np.bincount(self.cells_of(mine, old), size, len(self.key)))
        return np.maximum(*both)

    def open_door(self, patches: np.ndarray, other: Moved, cluster: np.ndarray) -> None:
        """Let slopes see the clusters of another room behind openings, which are these patches."""
        some = other.state[cluster, P] > 0.0
        patches, cluster = patches[some], cluster[some]
        self.door[patches] = len(self.beyond) + np.arange(len(patches))
        behind = np.hstack([other.place[cluster], other.state[cluster, :VALUES]])
        self.beyond = np.concatenate([self.beyond, behind])

    def about(self, cluster: np.ndarray) -> tuple[np.ndarray, float]:
        """The gas that comes to a hole, (5,), and what leaves it, as from `gas_leaving`; cluster: of each of its
        fragments."""
        found = self.clusters
        where = cluster, found.start, found.members, found.of, self.beside, self.aperture, self.state
        return gas_before(*where), gas_leaving(*where)

    def fragments(self, old: bool) -> tuple[np.ndarray, np.ndarray]:
        """Fragments of the old surface or the new one: rows, and the triangle of each."""
        cut = self.old if old else self.new
        return cut.fragments.rows, cut.fragments.triangle

    def cells_of(self, fragments: np.ndarray, old: bool = False) -> np.ndarray:
        """Cell here of some fragments of the new surface, or the old one, (m,) int64."""
        cut = self.old if old else self.new
        return np.searchsorted(self.key, cut.key[np.searchsorted(cut.start, fragments, side="right") - 1])

    def fragments_of(self, triangles: np.ndarray, old: bool = False) -> np.ndarray:
        """Fragments of the new surface, or the old one, on some triangles, in their order, (m,) int64."""
        return (self.old if old else self.new).fragments.on(triangles)


@scalar
def _close_up(key, held, temperature, sound):
    """Move the cells that hold gas together; returns their number."""
    n = 0
    for i in range(len(key)):
        some = False
        for s in range(held.shape[1] - 4):
            some = some or held[i, s] != 0.0
        if some:
            if n != i:
                key[n], temperature[n], sound[n] = key[i], temperature[i], sound[i]
                for k in range(held.shape[1]):
                    held[n, k] = held[i, k]
            n += 1
    return n
