"""Three-node membrane triangles, total Lagrangian from the flat cut (docs/theory.md, Membrane element), and what every
fabric law promises."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from billow.base.compiled import CHUNK
from billow.base.errors import Concern, InputError
from billow.base.plausible import is_usual
from billow.geometry.assembly import COLUMNS, Corners
from billow.geometry.chambers import Chambers
from billow.parts.fabric.block import BLOCK, CONSTANTS, D11, D12, D21, D22, MU, RATE, VOLUMES, V
from billow.parts.part import Setting

ENERGY, POWER, STRETCH, HYSTERESIS, SQUARED_RATE, LATE, TURNED = range(VOLUMES)
"""Columns of `partial`, what a law sums up per chunk of elements; those of the volumes follow."""

UNDAMPED, SLACKENING = 1e-3, 0.3
"""Fabric that goes slack gains energy if its damping fraction lies below UNDAMPED, unless its step is shorter: without
any damping SLACKENING times the usual one (docs/theory.md, Membrane step)."""
NO_AREA = InputError.declare(
    "E-GEO-004",
    "a triangle of the flat reference shape has no area",
    where="triangle {triangle}",
    why="its strain could not be defined",
    cause="two of its reference corners coincide, or all three lie on a line",
    remedy="correct the reference coordinates of its nodes",
)
ODD_SPEED = Concern.declare(
    "W-FAB-001",
    "sound travels at {speed:.3g} m/s along the {yarns}",
    where="fabric.young_{yarns} or fabric.curves.{yarns}, fabric.density",
    why="woven fabric has 400 to 1,500 m/s: a modulus, a stress or the density is probably in another unit",
    remedy='write units, for example young_{yarns} = "0.4 GPa"',
)


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
    7. `squared_rate` bounds the frequencies of an element at rest, and `add_forces` how they grow as it is strained, so
       that the step is stable.

    density: [kg/m^3]. thickness: [m], on which the stress acts. compression: whether the fabric carries compression or
    goes slack. damping: fraction of critical damping of an element's highest mode [-]. history_width: numbers stored
    per element, all zero at the start; a law that uses `block` leaves the last RATES of them to it. wave_speed: fastest
    membrane wave [m/s], from the steepest slope, unloading included. warp_modulus: [Pa], of straps cut along the warp.
    """

    density: float
    thickness: float
    compression: bool
    damping: float
    history_width: int
    wave_speed: float
    warp_modulus: float

    def along_yarns(self, reference_inverse: np.ndarray) -> np.ndarray:
        """Inverse flat edges Dm^-1, row by row, [1/m], (4, n), with its columns along the law's two yarn directions
        instead of the axes of the flat cut."""

    def squared_rate(self, membrane: Membrane) -> np.ndarray:
        """1/dt^2 [1/s^2], (n,), of the largest step with which an unstrained element alone is stable: omega^2/4 of its
        highest mode with its share of mass at each corner. No mode of a mesh is faster than that of its fastest
        element. A law that knows only the bound for thirds of the mass multiplies it by the largest lightness."""

    def add_forces(
        self, membrane: Membrane, corners: Corners, positions: np.ndarray, velocities: np.ndarray,
        history: np.ndarray, loads: np.ndarray, partial: np.ndarray,
    ) -> None:  # fmt: skip
        """Set the loads of the elements, and bring history up to date.

        corners: of the elements. positions [m] and velocities [m/s]: (nodes, 3). history: (history_width, n and room
        to the end of a block). loads: (entries, COLUMNS), receives membrane forces on the corners [N] and a third of
        the area vectors [m^2],
        summed up at the entries of `corners`, and only there. partial: of `Membrane.sums`, receives per chunk of
        elements the recoverable strain energy [J], the power turned to heat [W], a bound on the largest squared stretch
        [-], the energy turned to heat so far that follows from the history [J], the largest 1/dt^2 [1/s^2] of any
        element as it is strained now, what `damping_heat` needs of the stress of the call before [W] and [W/s] (zero
        before the call), and the part of the elements in the volumes [m^3] of the surroundings and of each chamber, by
        Gauss' theorem.
        """

    def concerns(self, altitude: float, setting: Setting) -> Iterator[Concern]:
        """What of this law is allowed but probably not meant; altitude: of the smallest element [m]."""


@dataclass(frozen=True)
class Membrane:
    """Elements that share one fabric.

    elements: (n,) int64, indices of their triangles in the surface. reference_inverse: Dm^-1 row by row, [1/m], (4, n).
    yarn_inverse: the same with its columns along the yarns. volume: reference area times thickness, [m^3], (n,).
    viscosity: damping modulus, [Pa s], (n,). altitude: smallest reference altitude, [m], (n,). lightness: a third of
    an element's mass over its share of the mass of the node at each corner, [-], (n, 3) (`share_mass`); squared_rate:
    1/dt^2 of its own stable step at rest with these shares, damping included, [1/s^2], (n,). behind, ahead: chambers
    on either side of each, (n,) int32 as in `Chambers`. mixed: whether a block is not full, or its elements do not all
    lie between the same two chambers, (blocks,) bool.
    """

    fabric: FabricLaw
    elements: np.ndarray
    reference_inverse: np.ndarray
    yarn_inverse: np.ndarray
    volume: np.ndarray
    viscosity: np.ndarray
    altitude: np.ndarray
    lightness: np.ndarray
    squared_rate: np.ndarray
    behind: np.ndarray
    ahead: np.ndarray
    mixed: np.ndarray

    @classmethod
    def build(
        cls, fabric: FabricLaw, elements: np.ndarray, reference: np.ndarray,
        thickness: float | np.ndarray | None = None, chambers: Chambers | None = None,
    ) -> Membrane:  # fmt: skip
        """Elements from flat corner coordinates, reference: [m], (n, 3, 2), warp first.

        thickness: if it differs from the fabric's own (seams, reinforcements), [m], (n,) or one number. chambers: of
        the surface; a single one by default.
        Raises InputError E-GEO-004 if a reference triangle has no area.
        """
        edge1, edge2 = reference[:, 1] - reference[:, 0], reference[:, 2] - reference[:, 0]
        determinant = edge1[:, 0] * edge2[:, 1] - edge1[:, 1] * edge2[:, 0]
        longest = np.max([np.sum(e**2, axis=1) for e in (edge1, edge2, edge2 - edge1)], axis=0)
        sound = np.abs(determinant) > 1e-8 * longest
        if not sound.all():
            raise NO_AREA(triangle=elements[int(np.argmin(sound))])
        inverse = np.array([edge2[:, 1], -edge2[:, 0], -edge1[:, 1], edge1[:, 0]]) / determinant
        area = 0.5 * np.abs(determinant)
        altitude = 2.0 * area / np.sqrt(longest)
        viscosity = fabric.damping * fabric.density * fabric.wave_speed * altitude
        volume = area * (fabric.thickness if thickness is None else thickness)
        elements = np.asarray(elements, np.int64)
        sides = Chambers.single(len(elements)) if chambers is None else chambers
        which = slice(None) if chambers is None else elements
        behind, ahead = sides.behind[which], sides.ahead[which]
        membrane = cls(
            fabric, elements, inverse, fabric.along_yarns(inverse), volume, viscosity, altitude, np.empty((0, 3)),
            np.empty(0), behind, ahead, _mixed(behind, ahead),
        )  # fmt: skip
        return membrane.sharing(np.ones((len(elements), 3)))

    def sharing(self, lightness: np.ndarray) -> Membrane:
        """With other shares of the mass of its nodes, and the steps that go with them."""
        shared = replace(self, lightness=lightness)
        return replace(shared, squared_rate=shared._with_damping(self.fabric.squared_rate(shared)))

    def only(self, which: np.ndarray) -> Membrane:
        """Some of its elements, by their places in it."""
        rows = {name: getattr(self, name)[:, which] for name in ("reference_inverse", "yarn_inverse")}
        each = ("elements", "volume", "viscosity", "altitude", "lightness", "squared_rate", "behind", "ahead")
        some = replace(self, **rows, **{name: getattr(self, name)[which] for name in each})
        return replace(some, mixed=_mixed(some.behind, some.ahead))

    @cached_property
    def alone(self) -> Membrane:
        """With a third of their own mass at the corners of all elements."""
        return self.sharing(np.ones_like(self.lightness))

    def _with_damping(self, squared_rate: np.ndarray) -> np.ndarray:
        """1/dt^2 [1/s^2] with damping taken from the last half step, dt = 2/omega (sqrt(1 + xi^2) - xi) for each mode
        (docs/theory.md, Membrane step, says also why fabric without compression and next to no damping needs less)."""
        omega = 2.0 * np.sqrt(squared_rate)
        gxx, gyy, gxy = self.gradients
        widest = 0.5 * (gxx + gyy) + np.sqrt(0.25 * (gxx - gyy) ** 2 + gxy**2)
        xi = 1.5 * self.viscosity * widest / (self.fabric.density * omega)
        factor = 1.0 / (np.sqrt(1.0 + xi**2) + xi)
        if not self.fabric.compression:
            factor = factor * min(1.0, SLACKENING + (1.0 - SLACKENING) * self.fabric.damping / UNDAMPED)
        return squared_rate / factor**2

    @property
    def mass(self) -> np.ndarray:
        """Mass of each element [kg], (n,)."""
        return self.fabric.density * self.volume

    @property
    def gradients(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Sums over the corners of the products xx, yy, xy of the gradients of their shape functions, times the
        lightness [1/m^2], (n,)."""
        d11, d12, d21, d22 = self.reference_inverse
        along, across = np.stack([-d11 - d21, d11, d21]), np.stack([-d12 - d22, d12, d22])
        light = self.lightness.T
        return tuple((light * product).sum(axis=0) for product in (along**2, across**2, along * across))

    @cached_property
    def _constants(self) -> np.ndarray:
        """As the kernels of all laws read them, (CONSTANTS, n and room to the end of a block)."""
        n = len(self.elements)
        rows = np.zeros((CONSTANTS, -(-n // BLOCK) * BLOCK))
        rows[[D11, D12, D21, D22], :n] = self.yarn_inverse
        rows[V, :n], rows[MU, :n], rows[RATE, :n] = self.volume, self.viscosity, self.squared_rate
        return rows

    def for_kernels(self, positions: np.ndarray, velocities: np.ndarray) -> tuple[np.ndarray, ...]:
        """What the kernels of all laws read. positions [m] and velocities [m/s]: (nodes, 3)."""
        return self._constants, self.behind, self.ahead, positions, velocities, self.mixed

    def by_itself(
        self, triangles: np.ndarray, positions: np.ndarray, velocities: np.ndarray, history: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Forces on the corners of each element [N], (n, 3, 3), and sums as `FabricLaw.add_forces` makes them; the
        history stays as it is. triangles: of the surface, (triangles, 3); positions [m], velocities [m/s]: (nodes, 3).
        """
        corners = Corners.apart(triangles[self.elements])
        chambers = 1 + int(max(self.behind.max(initial=0), self.ahead.max(initial=0)))
        loads, sums = np.empty((corners.entry.size, COLUMNS)), self.sums(chambers)
        self.fabric.add_forces(self, corners, positions, velocities, history.copy(), loads, sums)
        return loads[:, :3].reshape(-1, 3, 3), sums

    def sums(self, chambers: int = 1) -> np.ndarray:
        """Room for what the law sums up: (chunks, VOLUMES + 1 + chambers)."""
        return np.zeros((-(-len(self.elements) // CHUNK), VOLUMES + 1 + chambers))

    def fresh_history(self) -> np.ndarray:
        """History of fabric that has never been strained, (history_width, n and room to the end of a block)."""
        return np.zeros((self.fabric.history_width, self._constants.shape[1]))

    def cauchy_green(self, triangles: np.ndarray, positions: np.ndarray) -> tuple[np.ndarray, ...]:
        """Entries 11, 22 and 12 of F^T F [-], (n,) each, at positions [m] (nodes, 3)."""
        corners = positions[triangles[self.elements]]
        u, w = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        d = self.reference_inverse[:, :, None]
        f1, f2 = u * d[0] + w * d[2], u * d[1] + w * d[3]
        return tuple(np.einsum("ij,ij->i", a, b) for a, b in ((f1, f1), (f2, f2), (f1, f2)))

    def stretch(self, triangles: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Largest principal stretch [-], (n,), at positions [m] (nodes, 3)."""
        c1, c2, c12 = self.cauchy_green(triangles, positions)
        return np.sqrt(0.5 * (c1 + c2) + np.sqrt((0.5 * (c1 - c2)) ** 2 + c12**2))

    def least_stretch(self, triangles: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Smallest principal stretch [-], as `stretch`."""
        c1, c2, c12 = self.cauchy_green(triangles, positions)
        return np.sqrt(np.maximum(0.5 * (c1 + c2) - np.sqrt((0.5 * (c1 - c2)) ** 2 + c12**2), 0.0))

    @property
    def crossing_time(self) -> float:
        """Time [s] that the fastest wave takes across the smallest altitude."""
        return float(self.altitude.min() / self.fabric.wave_speed)


def _mixed(behind: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """As `Membrane.mixed`, of elements between these chambers, (n,) each."""
    element = np.arange(len(behind))
    first = element // BLOCK * BLOCK
    differs = (behind != behind[first]) | (ahead != ahead[first])
    mixed = np.zeros(-(-len(element) // BLOCK), np.bool_)
    mixed[element[differs] // BLOCK] = mixed[len(element) // BLOCK :] = True
    return mixed


def damping_heat(power: float, late: float, turned: float, dt: float) -> float:
    """What damping turns to heat [J] in a step of dt [s]: the work of the mean of its stresses at both ends.

    Nodes move by the mean of the forces at both ends of a step, those of damping among them. Power at the end alone
    would book too much of what swings from step to step. The rates of strain that the stress of the start goes with are
    those about the shape of the start: with F0 = F - dt F', F0^T F' is what the end has less dt F'^T F', and both are
    known at the end.
    """
    return dt * (power + late - dt * turned)


def odd_speed(yarns: str, modulus: float, density: float) -> Iterator[Concern]:
    """The concern about the speed of sound along warp or weft; modulus: [Pa], density: [kg/m^3]."""
    speed = math.sqrt(modulus / density)
    if not is_usual("speed of sound in fabric", speed):
        yield ODD_SPEED(speed=speed, yarns=yarns)
