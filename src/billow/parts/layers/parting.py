"""One step of the filter: who is awake, sweeps until no pair comes too near, and the last resort."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from billow.base.compiled import CHUNK
from billow.parts.layers.clusters import join_short, move_together, push_held
from billow.parts.layers.distance import (
    gather,
    gather_marked,
    look_ahead,
    measure,
    put_to_sleep,
    touch,
    wake,
    wake_struck,
)
from billow.parts.layers.friction import rub
from billow.parts.layers.pairs import LEVELS, Pairs
from billow.parts.layers.sweeps import CONVERGED, SWEEPS, Constraints
from billow.parts.layers.velocity_filter import (
    APPROACH,
    SCANS,
    admit,
    allowance,
    note,
    scan,
    warm_start,
)  # fmt: skip

MOST_PASSES = 30
"""Of the last resort."""


class Limits(NamedTuple):
    """friction: coefficient. spring: stiffness of the cushion for each mass, of a node
    and a triangle and of two edges [1/s^2]. gap: the full one [m]. near: up to
    which distance a node and a triangle touch, and two edges [m]. floor: the part of a pair's own gap that is its
    floor, the highest and the least floor [m]. tolerance: error of position that may be left [m]. ready: change of a
    node's way in a step that sleepers are ready for [m]."""

    friction: float
    spring: tuple[float, float]
    gap: float
    near: tuple[float, float]
    floor: tuple[float, float, float]
    tolerance: float
    ready: float


class Step(NamedTuple):
    """Nodes over a drift of dt [s]: positions [m], velocities [m/s] now and before any impulse, (nodes, 3);
    mass [kg], inverse_mass [1/kg], stray from their paths so far [m]: (nodes,)."""

    positions: np.ndarray
    velocities: np.ndarray
    before: np.ndarray
    mass: np.ndarray
    inverse_mass: np.ndarray
    stray: np.ndarray
    dt: float


class Rows(Protocol):
    """What else pushes on the nodes, and is solved in the same sweeps: rigid bodies."""

    def __len__(self) -> int:
        """How many there are, of any of its kinds: without any, there is nothing to settle."""

    def settle(self) -> float:
        """Solve anew for nodes that something else has changed; the largest change of a velocity [m/s]."""

    def restart(self) -> None:
        """Take back whatever changed velocities, and solve for these rows alone."""

    def before_others(self) -> np.ndarray:
        """Velocities [m/s] with these pushes as they are and nothing else, (nodes, 3)."""

    def pull(self) -> np.ndarray:
        """Accelerations of the half kick and of these pushes [m/s^2], (nodes, 3)."""


class Parting:
    """A try to part layers with the list at hand, of whose skins nodes have used a share, 0 to 1. rubbed: velocities
    after friction [m/s], and rubbed_push: what it pushed on nodes that do not yield [N s], (nodes, 3); None without."""

    def __init__(self, pairs: Pairs, step: Step, rows: Rows, limits: Limits, used: float):
        self.pairs, self.step, self.rows, self.limits = pairs, step, rows, limits
        m, n = len(pairs), len(step.positions)
        self.ahead = step.dt / APPROACH
        self.reach = tuple(apart + 2.0 * limits.ready for apart in (*limits.near, limits.floor[1]))
        self.ways = np.empty((n, 6))
        self.found = pairs.room.array("found", 2 * m, 0, np.int64).reshape(2, m)
        look_ahead.serial(n, step.positions, step.velocities, self.ahead, self.ways)
        self.used = used
        until = _level(used)
        mark = pairs.room.zeros("mark", -(-m // 8) * 8, np.uint8)
        wake(
            m,
            pairs.level,
            until,
            pairs.edges_from,
            pairs.nodes,
            pairs.normal,
            self.ways,
            self.reach,
            pairs.impulse,
            mark,
        )
        restless = pairs.awake
        if not pairs.moment:  # a new list
            restless = np.flatnonzero((pairs.gap != limits.gap) | (pairs.impulse > 0.0))
        put_to_sleep.serial(len(restless), restless, mark, limits.gap, pairs.gap, pairs.impulse)
        awake, able = np.empty((2, m), np.int64)
        counts = gather_marked.serial(len(mark) // 8, mark, mark.view(np.uint64), awake, able)
        pairs.awake, self.able = awake[: counts[0]], able[: counts[1]]
        self.struck, self.is_found = np.zeros(n, np.bool_), None
        self.rubbed = self.rubbed_push = None

    def run(self) -> bool:
        """Whether the list is wide enough for what the impulses did; if it is not, nothing of the pairs has changed."""
        pairs, step, limits = self.pairs, self.step, self.limits
        pairs.touched[:], pairs.push[:] = False, 0.0
        if not len(pairs.awake):
            return True
        self.changed, self.seen = np.empty(len(pairs.touched), np.bool_), np.full_like(step.velocities, np.nan)
        self.looked_with = step.before.copy()
        self._measure()
        touch.serial(
            len(pairs.awake), pairs.awake, pairs.edges_from, pairs.nodes, pairs.distance, limits.gap, pairs.touched
        )
        if limits.friction:
            rub.serial(
                len(pairs.awake), pairs.awake, pairs.edges_from, pairs.nodes, pairs.weight, pairs.normal,
                pairs.distance, pairs.gap, limits.near, pairs.impulse, limits.friction, step.mass, step.inverse_mass,
                limits.spring, step.dt, step.velocities, pairs.push,
            )  # fmt: skip
            self.rubbed, self.rubbed_push = step.velocities.copy(), pairs.push.copy()
        slot = pairs.slot
        index = pairs.room.array("index", len(pairs), 0, np.int64)
        aim, per, total = (pairs.room.array(name, len(pairs)) for name in ("aim", "per", "total"))
        constraints = index, aim, per, total
        m = warm_start.serial(
            len(self.able), self.able, pairs.edges_from, pairs.nodes, pairs.weight, pairs.normal, pairs.distance,
            pairs.gap, limits.near, limits.floor, pairs.impulse, step.inverse_mass, step.dt, step.velocities, slot,
            *constraints,
        )  # fmt: skip
        if m or self.rubbed is not None:  # last impulses along normals that have turned may throw nodes anywhere
            self._sweep(Constraints(m, *constraints, pairs, limits, step))
        short = 0.0
        for _ in range(SCANS):
            if not self._allow():
                return False
            goal, chunks = np.empty(len(self.able)), np.zeros((-(-len(self.able) // CHUNK) or 1, 3))
            scan(
                len(self.able), self.able, pairs.edges_from, pairs.nodes, pairs.weight, pairs.normal,
                pairs.distance, pairs.gap, limits.near, limits.floor, limits.tolerance, step.positions,
                step.velocities, step.dt, self.changed, slot, aim, goal, chunks,
            )  # fmt: skip
            short = chunks[:, 2].sum()
            if chunks[:, 1].max() == 0.0 and short == 0.0:
                break
            m = admit.serial(
                len(self.able), self.able, goal, chunks, pairs.nodes, pairs.weight, step.inverse_mass, m, slot,
                *constraints,
            )  # fmt: skip
            self._sweep(Constraints(m, *constraints, pairs, limits, step))
        if not self._allow() or (short and not self._join()):
            return False
        note.serial(
            len(pairs.awake), pairs.awake, m, index, total, pairs.nodes, pairs.weight, pairs.normal, step.inverse_mass,
            pairs.impulse, slot, pairs.push,
        )  # fmt: skip
        return True

    def _sweep(self, constraints: Constraints) -> None:
        """Solve for the constraints, and for what else pushes on the nodes."""
        if not self.rows:
            constraints.sweep(SWEEPS)
            return
        for _ in range(SWEEPS):
            moved = constraints.sweep(1)
            before = self.step.velocities.copy()
            # Last, so that the springs of bodies are solved for the motion that comes.
            moved = max(moved, self.rows.settle() * self.step.dt / self.limits.tolerance)
            if moved < CONVERGED:
                break
            constraints.note_others(before)

    def thrown(self) -> np.ndarray:
        """How far impulses throw each node off its way, twice as far ahead as a pair may come in a step [m]."""
        return self.ahead * np.linalg.norm(self.step.velocities - self.step.before, axis=1)

    def _allow(self) -> bool:
        """Wake whoever was struck; whether the list is wide enough for the velocities as they are."""
        pairs, step = self.pairs, self.step
        most, any_struck = allowance.serial(
            len(step.positions), step.before, step.velocities, pairs.path_velocity, step.stray, pairs.skin, self.ahead,
            self.limits.ready / self.ahead, self.seen, self.looked_with, self.struck, self.changed,
        )  # fmt: skip
        if most > 1.0:
            return False
        if any_struck:
            if self.is_found is None:
                self.is_found = np.zeros((2, len(pairs)), np.bool_)
                self.is_found[0, pairs.awake] = self.is_found[1, self.able] = True
            look_ahead.serial(len(step.positions), step.positions, step.velocities, self.ahead, self.ways)
            counts = np.empty((2, -(-len(pairs) // CHUNK)), np.int64)
            until = _level(max(self.used, most))
            wake_struck(
                len(pairs), pairs.level, until, pairs.edges_from, pairs.nodes, pairs.normal, self.ways, self.struck,
                self.is_found, self.reach, self.found, counts,
            )  # fmt: skip
            awake, able = self._gathered(counts)
            if len(able):
                self.is_found[1, able] = True
                self.able = np.flatnonzero(self.is_found[1])
            if len(awake):
                self.is_found[0, awake] = True
                pairs.awake = np.flatnonzero(self.is_found[0])
                self._measure()
        return True

    def _join(self) -> bool:
        """The last resort; whether the list is wide enough for it."""
        pairs, step = self.pairs, self.step
        pairs.last_resorts += 1
        parent, before = np.arange(len(step.positions)), step.velocities.copy()
        for _ in range(MOST_PASSES):
            look_ahead.serial(len(step.positions), step.positions, step.velocities, step.dt, self.ways)
            short = join_short.serial(
                len(self.able), self.able, pairs.edges_from, pairs.nodes, pairs.normal, pairs.distance, pairs.gap,
                self.limits.floor, self.ways, step.positions, step.velocities, step.dt, parent,
            )  # fmt: skip
            if not short:
                break
            move_together.serial(len(step.positions), parent, step.inverse_mass, before, step.velocities)
            if not self._allow():
                return False
        push_held.serial(len(parent), parent, step.inverse_mass, before, step.velocities, pairs.push)
        return True

    def _gathered(self, all_counts: np.ndarray) -> list[np.ndarray]:
        """Indices that chunks found, of both kinds."""
        both = []
        for found, counts in zip(self.found, all_counts, strict=True):
            both.append(np.empty(int(counts.sum()), np.int64))
            gather.serial(len(counts), found, counts, both[-1])
        return both

    def _measure(self) -> None:
        measure_awake(self.pairs, self.step.positions)


def _level(used: float) -> int:
    """The last level of pairs that can matter when nodes have used this share of their skins."""
    return min(int(LEVELS * used), LEVELS - 1)


def measure_awake(pairs: Pairs, positions: np.ndarray) -> None:
    """Distances of the pairs awake, where they are not known yet."""
    measure(
        len(pairs.awake), pairs.awake, pairs.edges_from, pairs.nodes, positions, pairs.moment, pairs.normal,
        pairs.weight, pairs.distance, pairs.measured,
    )  # fmt: skip
