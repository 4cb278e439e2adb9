"""What every fabric law promises."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from billow.base.errors import Concern
from billow.parts.part import Setting

ENERGY, POWER, STRETCH, HYSTERESIS = range(4)
"""Columns of `partial`, what a law sums up per chunk of elements."""

SUMS = 4
"""Number of those columns."""


class Elements(Protocol):
    """What a law reads of a `Membrane`, which says what each is."""

    elements: np.ndarray
    yarn_inverse: np.ndarray
    volume: np.ndarray
    viscosity: np.ndarray


class FabricLaw(Protocol):
    """Stress from deformation. `Membrane` knows the elements, the law knows what they are made of.

    Promises, which tests/fabric/test_law_contract.py checks for every law:

    1. Fabric moved or turned as a rigid body feels no force; forces turn with it.
    2. A triangle has neither net force nor net torque.
    3. Force is minus the gradient of the recoverable energy wherever the history stands still.
    4. Work on the fabric is either recoverable or turned to heat, and heat never falls: no loop creates energy. (The
       law "curves" returns too much where a shear rate changes its sign; the energy balance of a run shows it.)
    5. Forces are finite for any finite positions, crumpled, inverted and collapsed triangles included. A position or
       velocity that is not finite makes the sums not finite.
    6. Stress follows from strain and history, so that a second evaluation changes nothing. (The law "curves" keeps
       this only while no shear rate changes its sign.)
    7. `wave_speed` bounds the speed of every wave, so that `Membrane.stable_dt` is stable.

    density: [kg/m^3]. thickness: [m], on which the stress acts. compression: whether the fabric carries compression or
    goes slack. damping: fraction of critical damping of an element's highest mode [-]. history_width: numbers stored
    per element, all zero at the start. wave_speed: fastest membrane wave [m/s], from the steepest slope, unloading
    included. warp_modulus: [Pa], of straps cut along the warp.
    """

    density: float
    thickness: float
    compression: bool
    damping: float
    history_width: int

    @property
    def wave_speed(self) -> float: ...

    @property
    def warp_modulus(self) -> float: ...

    def along_yarns(self, reference_inverse: np.ndarray) -> np.ndarray:
        """Inverse flat edges Dm^-1, row by row, [1/m], (4, n), with its columns along the law's two yarn directions
        instead of the axes of the flat cut."""

    def add_forces(
        self, membrane: Elements, triangles: np.ndarray, positions: np.ndarray, velocities: np.ndarray,
        history: np.ndarray, corner_force: np.ndarray, partial: np.ndarray,
    ) -> None:  # fmt: skip
        """Add membrane forces [N] to corner_force (triangles, 3, 3), and bring history up to date.

        triangles: (triangles, 3). positions [m] and velocities [m/s]: (nodes, 3). history: (elements, history_width).
        partial: (chunks, 4), receives per chunk of elements the recoverable strain energy [J], the power turned to
        heat [W], a bound on the largest squared stretch [-] (for the stable step), and the energy turned to heat so far
        that follows from the history [J].
        """

    def concerns(self, altitude: float, setting: Setting) -> Iterator[Concern]:
        """What of this law is allowed but probably not meant; altitude: of the smallest element [m]."""
