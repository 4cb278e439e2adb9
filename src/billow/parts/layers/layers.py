"""Fabric against fabric: layers lie on each other, slide and part, and never pass through each other (docs/theory.md,
Layers)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel
from billow.base.errors import NumericalStop
from billow.base.quality import SMALLER_STEPS, Criterion, criterion
from billow.geometry.surface import Surface
from billow.parts.layers.carry import carry_over
from billow.parts.layers.cushion import STIFFNESS, press
from billow.parts.layers.mesh import TouchMesh
from billow.parts.layers.new_paths import find_pairs_of, splice
from billow.parts.layers.pairs import NEW, Pairs, Room
from billow.parts.layers.parting import Limits, Parting, Rows, Step, measure_awake
from billow.parts.layers.search import Found, Paths, find_pairs
from billow.parts.layers.velocity_filter import APPROACH
from billow.parts.part import FRICTION, LOST, RECEIVED, STORED, Account, Booking, Loads, Moment, Part

SELF_CONTACT = Account("self_contact", STORED, renewed=True)
"""Energy in the cushion between layers of fabric."""
LAYER_IMPACT = Account("layer_impact", LOST, renewed=False)
"""Heat of layers that meet: their impulses are inelastic."""
GAP_WORK = Account("gap_work", RECEIVED, renewed=False)
"""Work that parts layers which start nearer than their gap, while the reference moves in."""

FLOOR, FLOOR_OF_OWN = 1.0 / 3.0, 0.33
"""Distance that the filter keeps: in full gaps at most, and the part of a pair's own gap that it is."""

EDGES_NEAR = 0.4
"""Distance at which two edges begin to matter, in gaps: a little more than their floor. What lies on each other is kept
apart by its nodes; edges only have to be kept from passing through each other between them."""

LEAST_FLOOR = 1e-8
"""Of pairs that start in one place [m]."""

TOLERANCE = 1.0 / 150.0
"""Largest error of position that the filter leaves, in gaps."""

SKIN, MOST_SKIN, WIDER = 0.5, 0.2, 1.4
"""How far a node may stray from its path before the list is spent: in gaps at least, in mean edges at most; and the
factor by which it changes from list to list. More where impulses throw nodes off."""

WORK_OF_SEARCH, WORK_IN_STEP = 2.0, 0.5
"""Of each triangle in a search, whatever is near it, and of each pair in a step, in looks at two triangles whose boxes
meet. The skin is widened as long as the first outweighs all looks and pairs for which a list is made and used: with a
skin twice as wide a list serves half as long again, and has three or four times as many of both."""

USUAL, UNUSUAL = 1.5, 4.0
"""Stray of a node, in means of all, from which on its skin is wider, and the most times by which it is."""

CALMING = 0.7
"""Factor by which the skin of a node that was thrown off narrows from list to list."""

READY = 0.1
"""Change of a node's way in a step, by impulses, that sleeping pairs are ready for, in gaps."""

MOST_STEPS, LEAST_STEPS, LONGER = 100.0, 6.0, 1.3
"""For which a list is made, at most and at least, and the times by which that is more than the last list served: boxes
around longer paths are larger, and lists end when a node has used its skin."""

FARTHEST_WAY, MOST_WAY = 0.2, 0.8
"""Way at the usual speed, beyond the mean, for which a list is made at most, in mean edges: with the narrowest skin,
more in proportion to a wider one, and at most."""

STRAYED, MOST_STRAYED, SKIN_AGAIN = 0.4, 0.05, 2.0
"""Share of its skin that a node has used when it gets a new path because another has used all of its own; the most
nodes, of all, for which this is done instead of a new list; and the times by which their skins are wider then."""

GROWTH = 0.15
"""Speed [m/s] at which own gaps are let out while the reference moves in."""

THROWN_OFF = NumericalStop.declare(
    "E-NUM-011",
    "impulses between layers would throw node {node} {way:.3g} m off its way in one step",
    where="contact of layers, {when}",
    why="that is more than {most:g} elements: nothing was found that keeps the layers there apart",
    cause="layers that have crossed, or steps too long for how fast they meet",
    remedy="reduce run.dt_scale, after a look for crossings at the start: billow check CASE.toml",
)

MOST_THROWN = 5.0
"""Way that impulses may throw a node off in a step, in mean edges. Lists for more would hold pairs without end."""

FARTHEST, FASTEST = 1e3, 1e4
"""Distance of a node from the origin [m], and speed [m/s], from which on there is no bag any more."""

SECONDS_PER_NODE = 180e-9
"""Rough cost of a node in a step, searches included."""


@dataclass(frozen=True)
class Layers(Part):
    """What never changes.

    surface: of the whole bag; its vents and openings cannot be touched. mass, inverse_mass: of the nodes [kg], [1/kg],
    (nodes,); the latter zero for those that are fixed. edge: mean length of the edges [m]. gap: thickness of the fabric
    [m]. stable_dt: of the fabric at rest [s]. ramp: time until which own gaps grow, without friction [s]. friction:
    coefficient between layers.
    """

    surface: Surface
    mass: np.ndarray
    inverse_mass: np.ndarray
    edge: float
    gap: float
    stable_dt: float
    ramp: float = 0.0
    friction: float = 0.0

    @property
    def accounts(self) -> tuple[Account, ...]:
        ramp, rub = [GAP_WORK] if self.ramp else [], [FRICTION] if self.friction else []
        return (SELF_CONTACT, LAYER_IMPACT, *ramp, *rub)

    @cached_property
    def _mesh(self) -> TouchMesh:
        return TouchMesh.of(self.surface, self.inverse_mass > 0.0)

    @cached_property
    def _limits(self) -> Limits:
        near, floor = (self.gap, EDGES_NEAR * self.gap), (FLOOR_OF_OWN, FLOOR * self.gap, LEAST_FLOOR)
        spring = STIFFNESS[0] / self.stable_dt**2, STIFFNESS[1] / self.stable_dt**2
        return Limits(self.friction, spring, self.gap, near, floor, TOLERANCE * self.gap, READY * self.gap)

    def start(self, bag) -> Pairs:
        mesh = self._mesh
        return Pairs.none(self.surface.node_count, len(mesh.nodes), len(mesh.edges), SKIN * self.gap)

    # --- in a step -------------------------------------------------------------------------------------------------

    def part_layers(
        self, pairs: Pairs, positions: np.ndarray, velocities: np.ndarray, rows: Rows, time: float, dt: float
    ) -> list[Booking]:
        """Change velocities [m/s] (nodes, 3) before a drift from `time` over dt [s], so that layers stay apart; books
        the heat. Raises NumericalStop E-NUM-011.

        rows: of the bodies, which push on the same nodes and are solved in the same sweeps.
        """
        if len(pairs.distance) != len(pairs):
            pairs.make_room()
        (stray, way), ahead = np.empty((2, len(positions))), dt / APPROACH
        used = float(
            _way_used(
                len(positions), positions, velocities, pairs.path_start, pairs.path_velocity, pairs.skin, pairs.age,
                ahead, stray, way,
            )
        )  # fmt: skip
        if not used < np.inf:
            return [Booking(LAYER_IMPACT, math.nan)]  # the guards say what became of the bag
        if used > 1.0 or pairs.age + ahead > pairs.horizon:
            used = self._follow(pairs, positions, velocities, dt, stray, way)
        before = velocities.copy()
        thrown, limits = np.zeros(len(positions)), self._limits
        if time < self.ramp:
            limits = limits._replace(friction=0.0)
        pull = rows.pull() if limits.friction else None
        while True:
            step = Step(positions, velocities, before, self.mass, self.inverse_mass, stray, dt)
            parting = Parting(pairs, step, rows, limits, used)
            if parting.run():
                break
            thrown = np.maximum(thrown, 2.0 * parting.thrown())
            if not thrown.max() < MOST_THROWN * self.edge:
                node = int(np.argmax(thrown))
                stop = THROWN_OFF(node=node, way=thrown[node], when=f"after {1e3 * time:.4g} ms", most=MOST_THROWN)
                stop.nodes = (node,)
                raise stop
            rows.restart()
            used = self._follow(pairs, positions, velocities, dt, stray, way, thrown)
        pairs.age += dt
        pairs.moment += 1
        if not len(pairs.awake):
            return []
        heat = self._heat(rows.before_others(), velocities, rows.pull(), pairs.push, dt)
        if parting.rubbed is None:
            return [Booking(LAYER_IMPACT, heat)]
        rubbed = self._heat(before, parting.rubbed, pull, parting.rubbed_push, dt)
        return [Booking(LAYER_IMPACT, heat - rubbed), Booking(FRICTION, rubbed)]

    def _heat(self, before: np.ndarray, after: np.ndarray, pull: np.ndarray, push: np.ndarray, dt: float) -> float:
        """Of the impulses that changed velocities [m/s] (nodes, 3) from `before` to `after`, and pushed on nodes that
        do not yield [N s] (nodes, 3), which someone moves [J]."""
        heat = np.empty(-(-len(before) // CHUNK))
        _heat(len(before), self.inverse_mass, before, after, pull, push, dt, heat)
        return float(heat.sum())

    def add_forces(
        self, pairs: Pairs, positions: np.ndarray, velocities: np.ndarray, time: float, dt: float,
        loads: Loads,
    ) -> list[Booking]:  # fmt: skip
        """Add the forces of the cushion to the nodes after a step of dt [s] from `time`; books what it holds."""
        if pairs.horizon < 0.0:
            if not _sound(positions, velocities):
                return [Booking(SELF_CONTACT, math.nan)]
            self._search(pairs, positions, velocities, self.stable_dt, np.zeros(len(positions)))
            pairs.awake = np.arange(len(pairs))
        if not len(pairs.awake):
            return []
        measure_awake(pairs, positions)
        force, sums = np.zeros_like(positions), np.empty(2)
        press.serial(
            len(pairs.awake), pairs.awake, pairs.edges_from, pairs.nodes, pairs.weight, pairs.normal, pairs.distance,
            self._limits.near, self.gap, GROWTH if time < self.ramp else 0.0, self.mass, self.inverse_mass,
            self._limits.spring, dt, pairs.gap, force, sums,
        )  # fmt: skip
        loads.node_force[...] += force
        work = [Booking(GAP_WORK, float(sums[1]))] if self.ramp else []
        return [Booking(SELF_CONTACT, float(sums[0])), *work]

    def _follow(
        self, pairs: Pairs, positions: np.ndarray, velocities: np.ndarray, dt: float, stray: np.ndarray,
        way: np.ndarray, thrown: np.ndarray | float = 0.0,
    ) -> float:  # fmt: skip
        """New paths for the nodes that strayed, in a new list if they are many; how much of its skin the node has used
        that used most. stray, way: of the nodes, from `_way_used`, which are put right in place; thrown: how far
        impulses may throw nodes off their paths in the coming step [m]; all (nodes,)."""
        strayed = way + thrown > STRAYED * pairs.skin
        few = np.count_nonzero(strayed) <= MOST_STRAYED * len(strayed)
        if few and pairs.age + dt / APPROACH <= pairs.horizon:
            widest = np.maximum(pairs.skin, UNUSUAL * pairs.width)
            skin = np.maximum(thrown, np.minimum(SKIN_AGAIN * pairs.skin, widest))
            self._renew_paths(pairs, positions, velocities, strayed, skin[strayed])
        else:
            self._search(pairs, positions, velocities, dt, way, thrown)
            strayed[:] = True
        stray[strayed], way[strayed] = 0.0, 0.0
        return float((way / pairs.skin).max())

    def _search(
        self, pairs: Pairs, positions: np.ndarray, velocities: np.ndarray, dt: float, way: np.ndarray,
        thrown: np.ndarray | float = 0.0,
    ) -> None:  # fmt: skip
        """A new list for the coming steps of about dt [s]. way: that each node used of its skin in the last list
        [m]; thrown: how far impulses may throw nodes off their paths in the first step [m]; both (nodes,)."""
        of_width = pairs.looked_at + WORK_IN_STEP * max(1.0, pairs.age / dt) * len(pairs)
        of_search = WORK_OF_SEARCH * len(self._mesh.triangles)
        wider = WIDER * pairs.width if of_width < of_search else pairs.width / WIDER
        pairs.width = max(SKIN * self.gap, min(MOST_SKIN * self.edge, wider))
        speed = math.sqrt(float(np.ascontiguousarray(velocities.T).var(axis=1).sum()))
        farthest = min(MOST_WAY, FARTHEST_WAY * pairs.width / (SKIN * self.gap)) * self.edge
        time = max(1.01 * dt, min(MOST_STEPS * dt, farthest / max(speed, 1e-9)))
        if pairs.horizon > 0.0:
            time = min(time, LONGER * max(pairs.age, LEAST_STEPS * dt))
        time += dt / APPROACH
        # Who strayed far will do so again: with a wider skin it does not spend the list for all others.
        skin = pairs.width * np.clip(way / max(USUAL * float(way.mean()), 1e-12), 1.0, UNUSUAL)
        np.maximum(skin, CALMING * pairs.skin, out=skin)
        np.maximum(skin, thrown, out=skin)
        paths = Paths(positions, velocities, skin, *self._limits.near, time, 2.0 * self._limits.ready)
        found = find_pairs(self._mesh, paths, pairs.room)
        gap, impulse = self._known(pairs, found, pairs.room)
        pairs.key, pairs.nodes, pairs.normal, pairs.begin = found.key, found.nodes, found.normal, found.begin
        pairs.level, pairs.gap, pairs.impulse = found.level, gap, impulse
        pairs.path_start, pairs.path_velocity, pairs.skin = positions.copy(), velocities.copy(), skin
        pairs.age, pairs.horizon = 0.0, time
        pairs.looked_at = found.looked_at
        self._first_sight(pairs, positions)

    def _renew_paths(
        self, pairs: Pairs, positions: np.ndarray, velocities: np.ndarray, strayed: np.ndarray, skin: np.ndarray
    ) -> None:
        """New paths for the few nodes that strayed, (nodes,) bool, with skins of theirs [m], and the pairs that these
        make necessary: for all others the list goes on."""
        pairs.path_start[strayed] = positions[strayed] - pairs.age * velocities[strayed]
        pairs.path_velocity[strayed], pairs.skin[strayed] = velocities[strayed], skin
        now, time = pairs.path_start + pairs.age * pairs.path_velocity, pairs.horizon - pairs.age
        paths = Paths(now, pairs.path_velocity, pairs.skin, *self._limits.near, time, 2.0 * self._limits.ready)
        found = find_pairs_of(self._mesh, paths, strayed, pairs.room)
        gap, impulse = self._known(pairs, found, pairs.room.beside("few"))
        old = pairs.key, pairs.nodes, pairs.normal, pairs.level, pairs.gap, pairs.impulse
        new = found.key, found.nodes, found.normal, found.level, gap, impulse
        arrays = tuple(
            pairs.room.other(name, len(pairs) + len(gap), array.shape[1] if array.ndim > 1 else 0, array.dtype.type)
            for name, array in zip(("key", "nodes", "normal", "level", "gap", "impulse"), old, strict=True)
        )
        begin = np.empty_like(pairs.begin)
        total = splice(len(begin) - 1, pairs.begin, old, strayed, found.begin, new, begin, arrays)
        pairs.begin = begin
        pairs.key, pairs.nodes, pairs.normal, pairs.level, pairs.gap, pairs.impulse = (a[:total] for a in arrays)
        self._first_sight(pairs, positions)

    def _known(self, pairs: Pairs, found: Found, room: Room) -> tuple[np.ndarray, np.ndarray]:
        """Gap [m] and last impulse [N s] of pairs that were found, and in place their normals, as far as they are in
        the present list."""
        gap, impulse = (room.other(name, len(found.key)) for name in ("gap", "impulse"))
        gap[:], impulse[:] = NEW, 0.0
        carry_over(
            len(found.begin) - 1, found.begin, found.key, pairs.begin, pairs.key, pairs.gap, pairs.impulse,
            pairs.normal, gap, impulse, found.normal,
        )  # fmt: skip
        return gap, impulse

    def _first_sight(self, pairs: Pairs, positions: np.ndarray) -> None:
        """The own gaps of new pairs."""
        gap, impulse = pairs.gap, pairs.impulse
        pairs.make_room()
        asleep = (pairs.level > 0) & (gap == NEW)
        gap[asleep], impulse[asleep] = self.gap, 0.0
        pairs.awake = np.flatnonzero(gap == NEW)
        measure_awake(pairs, positions)
        apart = pairs.distance[pairs.awake]
        near = np.where(pairs.awake < pairs.edges_from, *self._limits.near)
        gap[pairs.awake] = np.where(apart < near, apart, self.gap)

    # --- what a run says of it -------------------------------------------------------------------------------------

    def books(self, pairs: Pairs, moment: Moment, history) -> dict[str, float]:
        heat = history.energy(LAYER_IMPACT.name)
        return {
            "self_contact_energy_joule": float(history.energy("self_contact").max()),
            "layer_impact_joule": float(heat[-1]),
            "layer_impact_of_gas_work": float(heat[-1]) / max(float(history.energy("gas_work").max()), 1e-300),
            "layer_impact_created_joule": float((np.maximum.accumulate(heat) - heat).max()),
        }

    def verdicts(self, books: Mapping[str, float], history) -> Iterator[Criterion]:
        largest = max(books["penalty_scale_joule"], 1e-300)
        share = books["self_contact_energy_joule"] / largest
        finer = "a smaller bag.element_size or run.dt_scale"
        yield criterion("penalty energy of self-contact, of peak internal", 100.0 * share, 5, 20, "%", finer)
        created = books["layer_impact_created_joule"] / largest
        yield criterion(
            "energy created by layers that meet, of peak internal", 100.0 * created, 0.1, 1, "%", SMALLER_STEPS
        )

    def remarks(self, pairs: Pairs) -> list[str]:
        if not pairs.last_resorts:
            return []
        return [f"layers: nodes had to move together in {pairs.last_resorts} steps, where impulses did not part them"]

    def seconds_per_step(self, pairs: Pairs, dt: float, end: float) -> float:
        return SECONDS_PER_NODE * len(self.mass)


def _sound(positions: np.ndarray, velocities: np.ndarray) -> bool:
    return bool(np.abs(positions).max() < FARTHEST and np.abs(velocities).max() < FASTEST)


@kernel
def _way_used(n, positions, velocities, path_start, path_velocity, skin, age, ahead, stray_out, way_out):
    """How much of its skin the node used that used most, `ahead` [s] looked ahead [-]; infinite for a bag that has
    left. stray_out: how far each node is off its path, and way_out: what it used [m], (nodes,)."""
    largest = np.empty((n + CHUNK - 1) // CHUNK)
    for chunk in prange(len(largest)):
        worst = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            stray, off = 0.0, 0.0
            for k in range(3):
                if not (abs(positions[i, k]) < FARTHEST and abs(velocities[i, k]) < FASTEST):
                    worst = np.inf
                stray += (positions[i, k] - path_start[i, k] - age * path_velocity[i, k]) ** 2
                off += (velocities[i, k] - path_velocity[i, k]) ** 2
            stray_out[i] = math.sqrt(stray)
            way_out[i] = stray_out[i] + ahead * math.sqrt(off)
            worst = max(worst, way_out[i] / skin[i])
        largest[chunk] = worst
    worst = 0.0
    for chunk in range(len(largest)):
        worst = max(worst, largest[chunk])
    return worst


@kernel
def _heat(n, inverse_mass, before, after, pull, push, dt, heat_out):
    """Heat of impulses, by chunks [J]: impulse times the mean of the velocities of two successive half steps, without
    which layers at rest under pressure would seem to burn energy."""
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        total = 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            if inverse_mass[i] <= 0.0:
                for k in range(3):
                    total -= push[i, k] * after[i, k]
                continue
            done = 0.0
            for k in range(3):
                done += (after[i, k] - before[i, k]) * (before[i, k] + after[i, k] - dt * pull[i, k])
            total -= 0.5 * done / inverse_mass[i]
        heat_out[chunk] = total
