"""Straps (tethers): tension-only bars between nodes, F = EA max(0, strain), damped while taut, until they tear."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from billow.base.compiled import scalar
from billow.parts.part import (
    DAMPING,
    HYSTERESIS,
    STORED,
    Account,
    Booking,
    Frame,
    Loads,
    Moment,
    Owner,
    Part,
    Quantity,
)

STRAP = Account("strap", STORED, renewed=True)
"""Recoverable energy of the straps."""

STEP_FACTOR = 0.9
"""Of the stable step 2 / omega of a node between its bars."""

TENSION, ENERGY, POWER, ELONGATION, TORN, LOST = range(6)
"""What is known of each bar: tension [N], stored energy [J], damping power [W], length beyond the unstretched one [m]
(negative while slack), 1 once it tore, and the energy [J] it held then."""


@dataclass(frozen=True)
class Straps(Part):
    """All bars of all straps.

    bars: (bars, 2) int64 node pairs. length: unstretched [m], (bars,). stiffness: EA [N], (bars,).
    viscosity: force per rate of strain [N s], (bars,). strap: (bars,) int64, which strap a bar belongs to.
    mass: of each bar [kg], (bars,), lumped half to each end. failure: tension at which a bar tears [N], (bars,).
    """

    bars: np.ndarray
    length: np.ndarray
    stiffness: np.ndarray
    viscosity: np.ndarray
    mass: np.ndarray
    strap: np.ndarray
    failure: np.ndarray

    accounts = (STRAP, DAMPING, HYSTERESIS)

    @property
    def strap_count(self) -> int:
        return int(self.strap.max()) + 1 if len(self.strap) else 0

    @staticmethod
    def name(strap: int) -> str:
        """What users call a strap, counted from 0."""
        return f"strap_{strap + 1}"

    def start(self, bag) -> np.ndarray:
        """Bars that have never pulled, (bars, 6), the columns named above."""
        return np.zeros((len(self.bars), 6))

    def add_forces(
        self, bar: np.ndarray, positions: np.ndarray, velocities: np.ndarray, dt: float, loads: Loads
    ) -> list[Booking]:
        """Add the tensions to the forces on the nodes; books what bars hold, damping, and what torn bars held."""
        if not len(bar):
            return []
        energy, power, lost = add_strap_forces(self, positions, velocities, loads.node_force, bar)
        return [(STRAP, energy), (DAMPING, power * dt), (HYSTERESIS, lost)]

    def squared_rate(self, inverse_mass: np.ndarray) -> float:
        """1 / dt^2 [1/s^2] of the largest stable step; zero without straps. inverse_mass: [1/kg], (nodes,).

        Bound of the largest squared frequency: for each node the sum of EA/L of its bars, counted twice where the other
        end is free too, over its mass (Gershgorin, rows of the stiffness over the mass).
        """
        spring = (self.stiffness / self.length)[:, None]
        other_is_free = inverse_mass[self.bars[:, ::-1]] > 0.0
        rows = np.where(other_is_free, 2.0 * spring, spring)
        stiffness = np.bincount(self.bars.ravel(), rows.ravel(), len(inverse_mass))
        return 0.25 * float((stiffness * inverse_mass).max()) / STEP_FACTOR**2

    def owners(self) -> Iterator[Owner]:
        for k in range(self.strap_count):
            yield Owner("strap", self.name(k), ("tension", "elongation"))

    def quantities(self, bar: np.ndarray, moment: Moment) -> Iterator[Quantity]:
        tension, elongation = (np.bincount(self.strap, bar[:, column]) for column in (TENSION, ELONGATION))
        rows = zip(tension.tolist(), (elongation / np.bincount(self.strap)).tolist(), strict=True)
        for k, (pull, longer) in enumerate(rows):
            yield Quantity(self.name(k), "tension", "N", pull)
            yield Quantity(self.name(k), "elongation", "m", longer)

    def frame(self, bar: np.ndarray, moment: Moment) -> Frame:
        """Tension of each bar [N]."""
        return Frame(bar={"tension": bar[:, TENSION]} if len(self.bars) else {})


NO_STRAPS = Straps(
    np.empty((0, 2), np.int64), np.empty(0), np.empty(0), np.empty(0), np.empty(0), np.empty(0, np.int64), np.empty(0)
)


def add_strap_forces(
    straps: Straps, positions: np.ndarray, velocities: np.ndarray, nodal_force: np.ndarray, bar: np.ndarray
) -> tuple[float, float, float]:
    """Add bar forces [N] to nodal_force (nodes, 3), and bring bar (bars, 6), the columns named above, up to date.
    Returns the sums of ENERGY [J], POWER [W] and LOST [J].

    A bar tears when its tension exceeds its failure tension; the energy it held is lost, and it never pulls again.
    """
    return _strap_forces(
        straps.bars, straps.length, straps.stiffness, straps.viscosity, straps.failure, positions, velocities,
        nodal_force, bar,
    )  # fmt: skip


@scalar
def _strap_forces(bars, length, stiffness, viscosity, failure, positions, velocities, nodal_force, bar):
    for i in range(len(bars)):
        a, b = bars[i, 0], bars[i, 1]
        dx, dy, dz = (
            positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1], positions[b, 2] - positions[a, 2],
        )  # fmt: skip
        now = math.sqrt(dx * dx + dy * dy + dz * dz)
        strain = now / length[i] - 1.0
        bar[i, TENSION] = bar[i, ENERGY] = bar[i, POWER] = 0.0
        bar[i, ELONGATION] = now - length[i]
        if strain <= 0.0 or bar[i, TORN] > 0.0:
            continue
        dx, dy, dz = dx / now, dy / now, dz / now
        rate = (
            (velocities[b, 0] - velocities[a, 0]) * dx
            + (velocities[b, 1] - velocities[a, 1]) * dy
            + (velocities[b, 2] - velocities[a, 2]) * dz
        ) / length[i]
        elastic = stiffness[i] * strain
        energy = 0.5 * elastic * strain * length[i]
        viscous = max(viscosity[i] * rate, -elastic)  # a strap never pushes
        tension = elastic + viscous
        if tension > failure[i]:
            bar[i, TORN] = 1.0
            bar[i, LOST] = energy
            continue
        bar[i, TENSION] = tension
        bar[i, ENERGY] = energy
        bar[i, POWER] = viscous * rate * length[i]
        nodal_force[a, 0] += tension * dx
        nodal_force[a, 1] += tension * dy
        nodal_force[a, 2] += tension * dz
        nodal_force[b, 0] -= tension * dx
        nodal_force[b, 1] -= tension * dy
        nodal_force[b, 2] -= tension * dz
    stored, heating, lost = 0.0, 0.0, 0.0
    for i in range(len(bars)):
        stored, heating, lost = stored + bar[i, ENERGY], heating + bar[i, POWER], lost + bar[i, LOST]
    return stored, heating, lost
