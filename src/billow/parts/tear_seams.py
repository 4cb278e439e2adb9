"""Tear seams: lines of tied nodes that hold until the force per length of seam exceeds their strength (docs/theory.md,
Tear seams). A tie pulls only, F = k max(0, distance - rest), is damped while taut, and never holds again once it tore.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.base.compiled import scalar
from billow.parts.part import DAMPING, LOST, STORED, Account, Booking, Frame, Loads, Moment, Owner, Part, Quantity

TEAR_SEAM = Account("tear_seam", STORED, renewed=True)
"""Recoverable energy of the ties that hold."""
TEARING = Account("tearing", LOST, renewed=False)
"""What ties held when they tore."""

STEP_FACTOR = 0.9
"""Of the stable step 2 / omega of a node between its ties."""

FORCE, ENERGY, POWER, SINCE, TORN_AT = range(5)
"""What is known of each tie: force [N], stored energy [J], damping power [W], time since which it pulls [s], NOT_YET
while slack, and time at which it tore [s], NOT_YET while it holds."""
NOT_YET = -1.0


@dataclass(frozen=True)
class TearSeams(Part):
    """All ties of all seams.

    names: of the seams. ties: (ties, 2) int64 node pairs. seam: (ties,) int64, which seam a tie belongs to. length: of
    seam that a tie stands for [m], (ties,). rest: distance up to which it does not pull [m], (ties,). stiffness [N/m],
    viscosity [N s/m]: (ties,). rate, strength: of each seam, its strength [N/m] at rates of loading [N/m/s], linear
    between them: (seams, points) each. The rate is the mean since the tie began to pull.
    """

    names: tuple[str, ...]
    ties: np.ndarray
    seam: np.ndarray
    length: np.ndarray
    rest: np.ndarray
    stiffness: np.ndarray
    viscosity: np.ndarray
    rate: np.ndarray
    strength: np.ndarray

    accounts = (TEAR_SEAM, TEARING, DAMPING)

    def start(self, bag) -> np.ndarray:
        """Ties that have never pulled, (ties, 5), the columns named above."""
        return np.tile([0.0, 0.0, 0.0, NOT_YET, NOT_YET], (len(self.ties), 1))

    def add_forces(
        self, tie: np.ndarray, positions: np.ndarray, velocities: np.ndarray, now: float, dt: float, loads: Loads
    ) -> list[Booking]:
        """Add the pull of the ties at the time `now` [s], the end of a step of dt [s], to the forces on the nodes;
        books what they hold, damping, and what those held that tear."""
        stored, power, lost = _tie_forces(
            self.ties, self.seam, self.length, self.rest, self.stiffness, self.viscosity, self.rate, self.strength,
            positions, velocities, now, loads.node_force, tie,
        )  # fmt: skip
        return [Booking(TEAR_SEAM, stored), Booking(DAMPING, power * dt), Booking(TEARING, lost)]

    def squared_rate(self, inverse_mass: np.ndarray) -> float:
        """1 / dt^2 [1/s^2] of the largest stable step; as that of straps. inverse_mass: [1/kg], (nodes,)."""
        other_is_free = inverse_mass[self.ties[:, ::-1]] > 0.0
        rows = np.where(other_is_free, 2.0, 1.0) * self.stiffness[:, None]
        stiffness = np.bincount(self.ties.ravel(), rows.ravel(), len(inverse_mass))
        return 0.25 * float((stiffness * inverse_mass).max()) / STEP_FACTOR**2

    @cached_property
    def _whole(self) -> np.ndarray:
        """Length of each seam [m]."""
        return np.bincount(self.seam, self.length, len(self.names))

    def owners(self) -> Iterator[Owner]:
        for name in self.names:
            yield Owner("tear seam", name, ("force", "torn"))

    def quantities(self, tie: np.ndarray, moment: Moment) -> Iterator[Quantity]:
        force = np.bincount(self.seam, tie[:, FORCE], len(self.names)).tolist()
        torn = np.bincount(self.seam, self.length * (tie[:, TORN_AT] != NOT_YET), len(self.names)) / self._whole
        for name, pull, share in zip(self.names, force, torn.tolist(), strict=True):
            yield Quantity(name, "force", "N", pull)
            yield Quantity(name, "torn", "-", share)

    def frame(self, tie: np.ndarray, moment: Moment) -> Frame:
        """When the tie of each node tore [s]; -1 where it holds or there is none."""
        torn_at = np.full(len(moment.positions), NOT_YET)
        np.maximum.at(torn_at, self.ties.ravel(), np.repeat(tie[:, TORN_AT], 2))
        return Frame(point={"torn_at": torn_at})

    def remarks(self, tie: np.ndarray) -> list[str]:
        return [self._story(k, tie[self.seam == k, TORN_AT]) for k in range(len(self.names))]

    def _story(self, seam: int, torn_at: np.ndarray) -> str:
        """In which order the ties of a seam tore."""
        order = np.argsort(torn_at, kind="stable")
        order = order[torn_at[order] != NOT_YET]
        if not len(order):
            return f"tear seam {self.names[seam]}: holds"
        first, last = 1e3 * torn_at[order[0]], 1e3 * torn_at[order[-1]]
        listed = ", ".join(str(k + 1) for k in order[:12]) + (", ..." if len(order) > 12 else "")
        count = f"{len(order)} of {len(torn_at)} ties tore"
        return f"tear seam {self.names[seam]}: {count}, from {first:.4g} to {last:.4g} ms, in the order {listed}"


@scalar
def _strength_at(rates, strengths, rate):
    """Linear between the points, and constant beyond them."""
    last = len(rates) - 1
    if rate <= rates[0]:
        return strengths[0]
    for k in range(last):
        if rate < rates[k + 1]:
            return strengths[k] + (strengths[k + 1] - strengths[k]) * (rate - rates[k]) / (rates[k + 1] - rates[k])
    return strengths[last]


@scalar
def _tie_forces(
    ties, seam, length, rest, stiffness, viscosity, rates, strengths, positions, velocities, now, nodal_force, tie
):  # fmt: skip
    stored, heating, lost = 0.0, 0.0, 0.0
    for i in range(len(ties)):
        tie[i, FORCE] = tie[i, ENERGY] = tie[i, POWER] = 0.0
        if tie[i, TORN_AT] != NOT_YET:
            continue
        a, b = ties[i, 0], ties[i, 1]
        dx, dy, dz = (
            positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1], positions[b, 2] - positions[a, 2],
        )  # fmt: skip
        apart = math.sqrt(dx * dx + dy * dy + dz * dz)
        longer = apart - rest[i]
        if longer <= 0.0:
            tie[i, SINCE] = NOT_YET
            continue
        if tie[i, SINCE] == NOT_YET:
            tie[i, SINCE] = now
        dx, dy, dz = dx / apart, dy / apart, dz / apart
        parting = (
            (velocities[b, 0] - velocities[a, 0]) * dx
            + (velocities[b, 1] - velocities[a, 1]) * dy
            + (velocities[b, 2] - velocities[a, 2]) * dz
        )
        elastic = stiffness[i] * longer
        energy = 0.5 * elastic * longer
        per_length, pulls_for = elastic / length[i], now - tie[i, SINCE]
        rate = per_length / pulls_for if pulls_for > 0.0 else math.inf
        if pulls_for > 0.0 and per_length > _strength_at(rates[seam[i]], strengths[seam[i]], rate):
            tie[i, TORN_AT] = now
            lost += energy
            pull = 0.5 * elastic  # for the half step before; none after
        else:
            viscous = max(viscosity[i] * parting, -elastic)  # a tie never pushes
            pull = elastic + viscous
            tie[i, FORCE], tie[i, ENERGY], tie[i, POWER] = pull, energy, viscous * parting
            stored, heating = stored + energy, heating + viscous * parting
        nodal_force[a, 0] += pull * dx
        nodal_force[a, 1] += pull * dy
        nodal_force[a, 2] += pull * dz
        nodal_force[b, 0] -= pull * dx
        nodal_force[b, 1] -= pull * dy
        nodal_force[b, 2] -= pull * dz
    return stored, heating, lost
