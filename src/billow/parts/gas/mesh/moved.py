"""The gas of one chamber in a step of the structure: its parts, and in each what happens to every cluster."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.base.errors import NumericalStop
from billow.geometry.cut_cells import CutCells, neighbours, unite
from billow.geometry.lattice_clipping import NORMAL
from billow.parts.gas.mesh.balance import add_fluxes, add_walls, forget_slopes, gather, hand_back, new_states
from billow.parts.gas.mesh.cell_maps import blend, cell_here, geometry, spread, through, triangle_of
from billow.parts.gas.mesh.clusters import Clusters, find_clusters
from billow.parts.gas.mesh.fluxes import face_fluxes
from billow.parts.gas.mesh.passages import gas_before
from billow.parts.gas.mesh.scratch import Scratch
from billow.parts.gas.mesh.sheet import Sheet, Walls, pace_of
from billow.parts.gas.mesh.slopes import VALUES, find_slopes
from billow.parts.gas.mesh.thermodynamics import Y

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
    key: np.ndarray
    in_old: np.ndarray
    in_new: np.ndarray
    beside: np.ndarray
    held: np.ndarray
    temperature: np.ndarray
    sound: np.ndarray
    adopted: int = 0
    lost: int = 0
    donors: int = 0

    @classmethod
    def begin(
        cls, walls: Walls, sheet: Sheet, scratch: Scratch, table: np.ndarray, h: float, origin: np.ndarray,
        cuts: tuple[CutCells, CutCells], velocity: np.ndarray, is_link: np.ndarray, second_order: bool,
    ) -> Moved:  # fmt: skip
        """h, origin: of the lattice [m]. cuts: the surface before and after; velocity: of the nodes in between [m/s];
        is_link: (triangles,) bool, triangles through which gas passes freely."""
        old, new = cuts
        with_gas, at_sheet, at_old = unite(sheet.key, old.key)
        key, at_both, in_new = unite(with_gas, new.key)
        in_sheet, in_old = through(at_both, at_sheet), through(at_both, at_old)
        n, species = len(key), len(table)
        scratch.turn += 1
        held, temperature = scratch.takes_turns("held", n, species + 4), scratch.takes_turns("temperature", n)
        sound = scratch.takes_turns("sound", n)
        spread(n, in_sheet, sheet.held, sheet.temperature, sheet.sound, held, temperature, sound)
        return cls(
            walls, scratch, table, h, origin, old, new, velocity, is_link, second_order, key, in_old, in_new,
            neighbours(key),
            held, temperature, sound,
        )  # fmt: skip

    def parts(self, dt: float, parts: int, time: float) -> Iterator[float]:
        """Advance by dt [s] from `time` in equal parts. Stops in each, once the state at its start is known: sources,
        passages and openings add to `gained`, say which clusters are `fed` and how fast [m/s] gas leaves `through`
        the fragments of holes. Yields the time [s] in its middle."""
        n, species, dt = len(self.key), len(self.table), dt / parts
        take = self.scratch.take
        whole, volume = take("whole", 2, n), take("volume", 2, n)
        aperture, centroid = take("aperture", n, 3), take("centroid", n, 3)
        geometry(
            n, self.key, self.in_old, self.in_new, self.old.volume, self.new.volume, self.old.centroid,
            self.new.centroid, whole, centroid,
        )  # fmt: skip
        self.booked = np.zeros(len(self.walls.triangles))
        flux, doors = take("flux", n, 3, VALUES), self._doors()
        for part in range(parts):
            begin, end = part / parts, (part + 1) / parts
            self.middle = middle = 0.5 * (begin + end)
            blend(
                n, self.beside, self.in_old, self.in_new, self.old.aperture, self.new.aperture, whole, begin, end,
                volume, aperture,
            )  # fmt: skip
            pace = pace_of(self.held, self.sound)
            clusters = find_clusters(self.key, self.beside, volume, aperture, pace, doors, dt / self.h)
            self.of, self.clusters, self.aperture = clusters.of, clusters, aperture
            self.adopted, self.lost = self.adopted + clusters.adopted, self.lost + clusters.lost
            count = len(clusters.before)
            self.total, self.state = take("total", count, species + 4), take("state", count, Y + species)
            self.place, bad = take("place", count, 3), np.empty(count, np.bool_)
            gather(
                count, clusters.start, clusters.members, clusters.before, clusters.after, self.table, volume[0],
                self.held, self.temperature, volume[1], centroid, self.h**3, self.total, self.state, self.place, bad,
            )  # fmt: skip
            if bad.any():
                raise self._negative(clusters, int(bad.argmax()), self.total, time + part * dt)
            self.gained, self.fed = self.scratch.zeros("gained", count, species + 4), np.empty(0, np.int32)
            self.through = (
                self.scratch.zeros("old_through", len(self.old.cell)),
                self.scratch.zeros("new_through", len(self.new.cell)),
            )
            yield time + (part + 0.5) * dt
            self.slope, half = take("slope", count, 3, VALUES), take("half", count, VALUES)
            find_slopes(
                count, clusters.start, clusters.members, clusters.of, self.beside, aperture, self.in_new,
                self.new.start, self.new.order, self.new.fragments.rows, self.fragment_triangle,
                self.walls.triangles, self.velocity, self.through[1], self.state, self.place, dt / self.h,
                self.second_order, self.slope, half,
            )  # fmt: skip
            self._finish(clusters, volume[1], aperture, flux, half, dt, middle, time + part * dt)

    def _finish(
        self, clusters: Clusters, volume: np.ndarray, aperture: np.ndarray, flux: np.ndarray, half: np.ndarray,
        dt: float, middle: float, time: float,
    ) -> None:  # fmt: skip
        """Fluxes and walls; where a cluster would run out of energy, again with it as a donor cell."""
        half[self.fed] = self.state[self.fed, :VALUES]  # the half step knows nothing of sources
        n, count, new = len(self.key), len(clusters.before), self.new
        scratch = self.scratch
        total, state = scratch.take("new_total", *self.total.shape), scratch.take("new_state", *self.state.shape)
        work = scratch.zeros("old_work", len(self.old.cell)), scratch.zeros("new_work", len(new.cell))
        bad, walled, second_order = np.empty(count, np.bool_), np.empty(count, np.bool_), self.second_order
        while True:
            face_fluxes(
                n, self.key, self.beside, aperture, clusters.of, self.state, half, self.slope, self.place, second_order,
                flux,
            )  # fmt: skip
            add_fluxes(
                count, clusters.start, clusters.members, self.beside, aperture, clusters.of, self.in_old, self.in_new,
                self.old.start, new.start, self.total, self.gained, self.state, flux, self.h**2, dt, total, walled,
            )  # fmt: skip
            with_walls = np.flatnonzero(walled)
            add_walls(
                len(with_walls), with_walls, clusters.start, clusters.members,
                (self.in_old, self.old.start, self.old.order, *self.fragments(True), self.through[0]),
                (self.in_new, new.start, new.order, *self.fragments(False), self.through[1]),
                self.walls.triangles, self.velocity, self.is_link, self.total, self.state, half, self.slope,
                self.place, self.h**2, dt, middle, total, *work,
            )  # fmt: skip
            new_states(count, clusters.after, self.table, total, self.h**3, self.state, state, bad)
            if not bad.any():
                break
            hopeless, first = forget_slopes(bad, self.state, self.slope, half)
            if hopeless == bad.sum():
                raise self._negative(clusters, first, total, time)
            self.donors += int(bad.sum()) - hopeless
        for cut, done in zip((self.old, new), work, strict=True):
            _add_up(len(self.booked), cut.fragments.first, done, self.booked)
        hand_back(
            n, clusters.of, clusters.start, clusters.after, volume, total, state, self.held, self.temperature,
            self.sound,
        )  # fmt: skip
        self.state, self.after = state, clusters.after

    def _negative(self, clusters: Clusters, first: int, total: np.ndarray, time: float) -> NumericalStop:
        x, y, z = self.origin + self.place[first] * self.h
        m, momentum = total[first, :-4].sum(), total[first, -4:-1]
        energy = total[first, -1] - 0.5 * float(momentum @ momentum) / m
        return NEGATIVE(
            chamber=self.walls.name, x=x, y=y, z=z, time=1e3 * time, volume=clusters.after[first], energy=energy
        )

    def _doors(self) -> np.ndarray:
        """Openings to other rooms in each cell [faces], the larger of those before and after, (cells,)."""
        free = np.flatnonzero(self.is_link)
        if not len(free):
            return np.zeros(len(self.key))
        both = []
        for old, of in ((True, self.old_cell_of_fragment), (False, self.cell_of_fragment)):
            mine, (rows, _) = self.fragments_of(free, old), self.fragments(old)
            size = np.sqrt((rows[mine, NORMAL : NORMAL + 3] ** 2).sum(axis=1))
            both.append(np.bincount(of[mine], size, len(self.key)))
        return np.maximum(*both)

    def before(self, cluster: np.ndarray) -> np.ndarray:
        """The gas that comes to a hole, (5,); cluster: of each of its fragments."""
        found = self.clusters
        return gas_before(cluster, found.start, found.members, found.of, self.beside, self.aperture, self.state)

    def fragments(self, old: bool) -> tuple[np.ndarray, np.ndarray]:
        """Fragments of the old surface or the new one: rows, and the triangle of each."""
        cut = self.old if old else self.new
        return cut.fragments.rows, self.old_triangle if old else self.fragment_triangle

    @cached_property
    def fragment_triangle(self) -> np.ndarray:
        """Triangle of each fragment of the new surface, (fragments,) int32."""
        return triangle_of(self.new)

    @cached_property
    def old_triangle(self) -> np.ndarray:
        return self.fragment_triangle if self.old is self.new else triangle_of(self.old)

    @cached_property
    def cell_of_fragment(self) -> np.ndarray:
        """Cell here of each fragment of the new surface, (fragments,) int32."""
        return cell_here(self.in_new, self.new)

    @cached_property
    def old_cell_of_fragment(self) -> np.ndarray:
        return cell_here(self.in_old, self.old)

    def fragments_of(self, triangles: np.ndarray, old: bool = False) -> np.ndarray:
        """Fragments of the new surface, or the old one, on some triangles, in their order, (m,) int64."""
        first = (self.old if old else self.new).fragments.first
        count = first[triangles + 1] - first[triangles]
        return np.repeat(first[triangles] - np.cumsum(count) + count, count) + np.arange(count.sum())

    def write(self, sheet: Sheet) -> None:
        """Keep what cells hold after the step."""
        n = _close_up(self.key, self.held, self.temperature, self.sound)
        sheet.key, sheet.held = self.key[:n], self.held[:n]
        sheet.temperature, sheet.sound = self.temperature[:n], self.sound[:n]


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


@kernel
def _add_up(n, first, of_fragment, of_triangle):
    for t in prange(n):
        for f in range(first[t], first[t + 1]):
            of_triangle[t] += of_fragment[f]
