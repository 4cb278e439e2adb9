"""Driven nodes: their places are given over time, in all directions or in some, as clamps and rails hold fabric."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from billow.parts.part import DRIVE_WORK, GRAVITY_WORK, KINETIC, Booking, Moment, Owner, Part, Quantity


@dataclass
class DrivenState:
    """force: on each driven node at the start of the step [N], (n, 3); kinetic: energy of their given motion [J];
    reaction: what holds or moves each node, over the last step [N], (n, 3)."""

    force: np.ndarray
    reaction: np.ndarray
    kinetic: float = 0.0


@dataclass(frozen=True)
class DrivenNodes(Part):
    """nodes: (n,) int64, all of them fixed in the model; mass: [kg], (n,). path: their places [m] (n, 3) at a time [s].
    held: projection onto the directions in which the path counts, (n, 3, 3); None if it counts in all. groups: which of
    the nodes, by name.

    They move evenly over a step; work is the mean of both forces over the way (trapezoid rule). In the directions that
    are not held, nodes yield to forces as all nodes do, with kicks of their own.
    """

    nodes: np.ndarray
    mass: np.ndarray
    path: Callable[[float], np.ndarray]
    held: np.ndarray | None = None
    groups: Mapping[str, np.ndarray] = field(default_factory=dict)

    accounts = (DRIVE_WORK, GRAVITY_WORK)

    @cached_property
    def yielding(self) -> np.ndarray:
        """1/mass [1/kg] of those that yield in some direction, else zero, (n,)."""
        if self.held is None:
            return np.zeros(len(self.nodes))
        some = (np.trace(self.held, axis1=1, axis2=2) < 2.5) & (self.mass > 0.0)
        return np.where(some, 1.0 / np.where(some, self.mass, 1.0), 0.0)

    def _along(self, vectors: np.ndarray) -> np.ndarray:
        """The components of (n, 3) in the directions that are held."""
        return vectors if self.held is None else np.einsum("nij,nj->ni", self.held, vectors)

    def yielded(self, vectors: np.ndarray) -> np.ndarray:
        """The components of (n, 3) in the directions in which nodes with mass yield."""
        return (vectors - self._along(vectors)) * (self.yielding > 0.0)[:, None]

    def start(self, bag) -> DrivenState:
        return DrivenState(np.zeros((len(self.nodes), 3)), np.zeros((len(self.nodes), 3)))

    def drive(
        self, state: DrivenState, positions: np.ndarray, velocities: np.ndarray, force: np.ndarray, time: float,
        dt: float,
    ) -> None:  # fmt: skip
        """Give the nodes the velocity [m/s] that takes them where they are at `time + dt` [s], and half a kick where
        they yield.

        force: on all nodes at the start of the step [N], (nodes, 3).
        """
        state.force = force[self.nodes].copy()
        given = self._along((self.path(time + dt) - positions[self.nodes]) / dt)
        if self.held is not None:
            kicked = velocities[self.nodes] + (0.5 * dt * self.yielding)[:, None] * state.force
            given = given + (kicked - self._along(kicked))
        velocities[self.nodes] = given

    def work(
        self, state: DrivenState, velocities: np.ndarray, force: np.ndarray, contact: np.ndarray, gravity: np.ndarray,
        dt: float,
    ) -> list[Booking]:  # fmt: skip
        """Work that moved the nodes over the step: against the fabric and against bodies, and for their kinetic energy;
        and the second half of the kick where they yield.

        force: at the end of the step [N], contact: of bodies and layers over the step [N], both (nodes, 3); gravity:
        [m/s^2], (3,).
        """
        moved, pull = velocities[self.nodes], force[self.nodes]
        along = self._along(moved)
        kinetic = 0.5 * float(self.mass @ np.sum(along * along, axis=1))
        state.reaction = -self._along(0.5 * (state.force + pull) + contact[self.nodes])
        done = float(np.sum(state.reaction * along)) * dt + kinetic - state.kinetic
        state.kinetic = kinetic
        bookings = [Booking(DRIVE_WORK, done)]
        if gravity.any():
            bookings.append(Booking(GRAVITY_WORK, float(gravity @ (self.mass @ moved)) * dt))
        if self.held is not None:
            kick = (0.5 * dt * self.yielding)[:, None] * pull
            kicked = moved + (kick - self._along(kick))
            gained = np.sum(kicked * kicked, axis=1) - np.sum(moved * moved, axis=1)
            velocities[self.nodes] = kicked
            bookings.append(Booking(KINETIC, 0.5 * float(self.mass @ gained)))
        return bookings

    # --- what a run says of them -----------------------------------------------------------------------------------

    def owners(self) -> Iterator[Owner]:
        for name in self.groups:
            yield Owner("group of nodes", name, ("reaction", "displacement"))

    def quantities(self, state: DrivenState, moment: Moment) -> Iterator[Quantity]:
        if not self.groups:
            return
        moved = moment.positions[self.nodes] - self.path(0.0)
        for name, members in self.groups.items():
            yield Quantity(name, "reaction", "N", state.reaction[members].sum(axis=0))
            yield Quantity(name, "displacement", "m", moved[members].mean(axis=0))
