"""Gauss-Seidel sweeps over the pairs that are too slow, in a fixed order, until no impulse changes any more.

A sweep visits only those pairs of which a node has moved since their last visit by more than matters to any pair of
that node. Where layers are pressed into a thick stack most pairs are settled after a few sweeps, and the few that are
not need a hundred more.
"""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import inlined, kernel
from billow.parts.layers.pairs import Pairs

SWEEPS = 150
"""Most sweeps between two scans. Sweeps that break off leave pairs short which impulses would have parted: their nodes
then move together, and a folded bag sticks."""

CONVERGED = 0.5
"""Largest change in a sweep, in tolerances, at which it has converged."""

TOLERANCE = 0.2
"""Of a pair's floor, or of its distance if that is less: error of position at which a sweep has converged; at most
`Limits.tolerance`. Layers that start nearer than they may would cross within an error that is small for others."""

QUIET = 0.5 * CONVERGED
"""Way of a node by changes of its velocity, in the least tolerance of its pairs, up to which they need no visit."""


@inlined
def error_allowed(distance, floor, least, tolerance):
    """Error of position that may be left in a pair [m]."""
    return min(tolerance, TOLERANCE * max(least, min(floor, distance)))


class Constraints:
    """The first m pairs of `index` (m,), whose speeds have to reach `aim` [m/s] by impulses that add up to `total`
    [N s]; per: impulse for a unit of speed [kg]; all (m,). What a visit needs is copied, so that it lies together."""

    def __init__(self, m: int, index, aim, per, total, pairs: Pairs, limits, step):
        self._m, self._solved, self._step = m, (aim, per, total), step
        n = len(step.positions)
        self._nodes, self._geometry = np.empty((m, 4), np.int32), np.empty((m, 8))
        self._begin, self._of = np.zeros(n + 2, np.int64), np.empty(4 * m, np.int32)
        self._quiet, self._drift = np.full(n, np.inf), np.zeros(n)
        self._waiting = np.zeros(-(-m // 8) * 8, np.uint8)
        _collect.serial(
            m, index, pairs.nodes, pairs.weight, pairs.normal, pairs.distance, pairs.gap, limits.floor,
            limits.tolerance, self._nodes, self._geometry, self._begin, self._of, self._quiet, self._waiting,
        )  # fmt: skip

    def sweep(self, most: int) -> float:
        """At most so many sweeps; the largest change in the last one, in tolerances."""
        step = self._step
        return _sweep.serial(
            self._m, most, self._nodes, self._geometry, *self._solved, self._begin, self._of, self._quiet,
            step.inverse_mass, step.dt, step.velocities, self._drift, self._waiting, self._waiting.view(np.uint64),
        )  # fmt: skip

    def note_others(self, before: np.ndarray) -> None:
        """Something else has changed velocities, which were as `before` [m/s], (nodes, 3): whose pairs have to be
        visited."""
        step = self._step
        _note_others.serial(
            len(before), before, step.velocities, step.dt, self._begin, self._of, self._quiet, self._drift,
            self._waiting,
        )  # fmt: skip


@kernel
def _collect(
    m, index, nodes, weight, normal, distance, gap, floor_of, tolerance, nodes_out, geometry_out, begin_out, of_out,
    quiet_out, waiting_out,
):  # fmt: skip
    """Of each constraint its nodes, and its normal, weights and tolerance [m], (m, 8); of each node the constraints
    that have it, from its begin on, (nodes + 2,), and the least way that matters to any of them [m], (nodes,)."""
    share, highest, least = floor_of
    for q in range(m):
        k = index[q]
        floor = max(least, min(highest, share * gap[k]))
        allowed = error_allowed(distance[k], floor, least, tolerance)
        waiting_out[q] = 1
        for i in range(3):
            geometry_out[q, i] = normal[k, i]
        for i in range(4):
            j = nodes[k, i]
            nodes_out[q, i], geometry_out[q, 3 + i] = j, weight[k, i]
            quiet_out[j] = min(quiet_out[j], QUIET * allowed)
            begin_out[j + 2] += 1
        geometry_out[q, 7] = allowed
    for j in range(2, len(begin_out)):
        begin_out[j] += begin_out[j - 1]
    for q in range(m):
        for i in range(4):
            j = nodes_out[q, i]
            of_out[begin_out[j + 1]] = q
            begin_out[j + 1] += 1


@inlined
def _tell(j, way, begin, of, quiet, drift, waiting):
    """Node j goes another way [m]: its pairs wait for a visit, if that and what came before matters to them."""
    drift[j] += way
    if drift[j] > quiet[j]:
        drift[j] = 0.0
        for a in range(begin[j], begin[j + 1]):
            waiting[of[a]] = 1


@kernel
def _note_others(n, before, velocities, dt, begin, of, quiet, drift, waiting):
    for j in range(n):
        x, y, z = velocities[j, 0] - before[j, 0], velocities[j, 1] - before[j, 1], velocities[j, 2] - before[j, 2]
        if x != 0.0 or y != 0.0 or z != 0.0:
            _tell(j, math.sqrt(x * x + y * y + z * z) * dt, begin, of, quiet, drift, waiting)


@kernel
def _sweep(
    m, most, nodes, geometry, aim, per, total, begin, of, quiet, inverse_mass, dt, velocities, drift, waiting, words
):
    """Sweeps over the constraints that wait, (m,) uint8, eight by eight in words; returns the largest change in the
    last one, in tolerances. drift: way of each node by changes since its constraints were told [m], (nodes,)."""
    moved = 0.0
    for _ in range(most):
        moved = 0.0
        for w in range(len(words)):
            if words[w] == 0:
                continue
            for p in range(8 * w, 8 * w + 8):
                q = np.uint64(p)
                if waiting[q] == 0:
                    continue
                x, y, z = geometry[q, 0], geometry[q, 1], geometry[q, 2]
                speed = 0.0
                for i in range(4):
                    j = np.uint64(nodes[q, i])
                    along = x * velocities[j, 0] + y * velocities[j, 1] + z * velocities[j, 2]
                    speed += geometry[q, 3 + i] * along
                change = max(-total[q], (aim[q] - speed) * per[q])
                if change != 0.0:
                    total[q] += change
                    moved = max(moved, abs(change) / per[q] * dt / geometry[q, 7])
                    for i in range(4):
                        j = np.uint64(nodes[q, i])
                        step = change * geometry[q, 3 + i] * inverse_mass[j]
                        velocities[j, 0] += step * x
                        velocities[j, 1] += step * y
                        velocities[j, 2] += step * z
                        _tell(j, abs(step) * dt, begin, of, quiet, drift, waiting)
                waiting[q] = 0
        if moved < CONVERGED:
            break
    return moved
