"""Driven nodes: nodes whose places are given over time, as the clamps of a test machine hold fabric."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from billow.parts.part import DRIVE_WORK, Booking, Part


@dataclass
class DrivenState:
    """force: of the fabric on each driven node at the last step [N], (n, 3); kinetic: energy of these nodes [J]."""

    force: np.ndarray
    kinetic: float = 0.0


@dataclass(frozen=True)
class DrivenNodes(Part):
    """nodes: (n,) int64, all of them fixed in the model; mass: [kg], (n,). path: their places [m] (n, 3) at a time [s].

    They move evenly over a step; work is the mean of both forces over the way (trapezoid rule).
    """

    nodes: np.ndarray
    mass: np.ndarray
    path: Callable[[float], np.ndarray]

    accounts = (DRIVE_WORK,)

    def start(self, bag) -> DrivenState:
        return DrivenState(np.zeros((len(self.nodes), 3)))

    def drive(
        self, state: DrivenState, positions: np.ndarray, velocities: np.ndarray, force: np.ndarray, time: float,
        dt: float,
    ) -> None:  # fmt: skip
        """Give the nodes the velocity [m/s] that takes them where they are at `time + dt` [s].

        force: on all nodes at the start of the step [N], (nodes, 3).
        """
        state.force = force[self.nodes].copy()
        velocities[self.nodes] = (self.path(time + dt) - positions[self.nodes]) / dt

    def work(self, state: DrivenState, velocities: np.ndarray, force: np.ndarray, dt: float) -> list[Booking]:
        """Work that moved the nodes over the step: against the fabric, and for their kinetic energy."""
        moved = velocities[self.nodes]
        kinetic = 0.5 * float(self.mass @ np.sum(moved * moved, axis=1))
        done = -0.5 * float(np.sum((state.force + force[self.nodes]) * moved)) * dt + kinetic - state.kinetic
        state.kinetic = kinetic
        return [Booking(DRIVE_WORK, done)]
