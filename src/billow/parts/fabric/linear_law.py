"""FORM 0: orthotropic linear fabric, with or without compression, and a liner: docs/theory.md, Linear law; its damping
and what "no compression" means: docs/theory.md, Membrane element.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, spliced
from billow.base.errors import Concern
from billow.geometry.assembly import Corners
from billow.parts.fabric.block import (
    AA,
    AB,
    BB,
    BLOCK,
    ENERGY,
    RATES,
    S11,
    S12,
    S22,
    add_up,
    close_chunk,
    fetch,
    load,
    open_chunk,
    strain_of,
)  # fmt: skip
from billow.parts.fabric.membrane import Membrane, odd_speed
from billow.parts.part import Setting

ODD_MODULI = Concern.declare(
    "W-FAB-003",
    "the moduli of the fabric do not go together",
    where="fabric.young_warp, fabric.young_weft, fabric.shear",
    why="warp and weft differ by a small factor, and woven fabric is far softer in shear",
    remedy="check the powers of ten",
)

KEEP, PRINCIPAL, YARN = 0, 1, 2  # the answers to compression


@dataclass(frozen=True)
class Liner:
    """Isotropic layer. ratio: its thickness over the fabric's [-], 0 for none; young [Pa]; poisson [-]."""

    ratio: float = 0.0
    young: float = 0.0
    poisson: float = 0.0

    @property
    def stiffness(self) -> np.ndarray:
        """Plane-stress moduli (c11, c22, c12, c66) [Pa], (4,), spread over the fabric's thickness."""
        c11 = self.ratio * self.young / (1.0 - self.poisson**2)
        return np.array([c11, c11, self.poisson * c11, 0.5 * (1.0 - self.poisson) * c11])


@dataclass(frozen=True)
class LinearFabric:
    """Orthotropic linear fabric (FORM 0): second Piola-Kirchhoff stress linear in Green strain, plane stress.

    density [kg/m^3], thickness [m], young_warp and young_weft [Pa], poisson (nu_ab, warp strain under weft stress
    follows from symmetry) [-], shear [Pa], compression: whether the fabric carries compression, damping: fraction of
    critical damping of an element's highest mode [-].
    """

    density: float
    thickness: float
    young_warp: float
    young_weft: float
    poisson: float
    shear: float
    compression: bool
    damping: float
    liner: Liner = Liner()
    history_width: ClassVar[int] = RATES

    @cached_property
    def is_isotropic(self) -> bool:
        return bool(
            np.isclose(self.young_warp, self.young_weft)
            and np.isclose(self.shear, 0.5 * self.young_warp / (1.0 + self.poisson))
        )

    @cached_property
    def stiffness(self) -> np.ndarray:
        """Plane-stress moduli (c11, c22, c12, c66) [Pa], (4,), without the liner."""
        reverse_poisson = self.poisson * self.young_weft / self.young_warp
        d = 1.0 - self.poisson * reverse_poisson
        return np.array([self.young_warp / d, self.young_weft / d, self.poisson * self.young_weft / d, self.shear])

    @cached_property
    def _moduli(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Of fabric and liner, as the kernel takes them."""
        return tuple(self.stiffness.tolist()), tuple(self.liner.stiffness.tolist())

    @property
    def wave_speed(self) -> float:
        """Fastest membrane wave [m/s]: sqrt(Emax / (rho (1 - nu^2))) (docs/theory.md, Membrane step), or the fastest
        plane wave in any direction where weft or shear make that faster."""
        young = max(self.young_warp, self.young_weft)
        c11, c22, c12, c66 = self.stiffness + self.liner.stiffness
        angle = np.linspace(0.0, 0.5 * np.pi, 91)
        c, s = np.cos(angle) ** 2, np.sin(angle) ** 2
        warp, weft, both = c11 * c + c66 * s, c66 * c + c22 * s, (c12 + c66) ** 2 * c * s
        plane = 0.5 * (warp + weft) + np.sqrt(0.25 * (warp - weft) ** 2 + both)  # of the acoustic tensor
        return float(np.sqrt(max(young / (1.0 - self.poisson**2), plane.max()) / self.density))

    @property
    def warp_modulus(self) -> float:
        return self.young_warp

    def concerns(self, altitude: float, setting: Setting) -> Iterator[Concern]:
        """Moduli that do not go together."""
        young = self.young_warp, self.young_weft
        if max(young) > 20.0 * min(young) or self.shear > 2.0 * max(young):
            yield ODD_MODULI()
        yield from odd_speed("weft", self.young_weft, self.density)

    def along_yarns(self, reference_inverse: np.ndarray) -> np.ndarray:
        """As it is: the yarns lie along the axes of the flat cut."""
        return reference_inverse

    def squared_rate(self, membrane: Membrane) -> np.ndarray:
        """omega^2/4 from the largest eigenvalue of 3/rho C B B^T, where B gives the strain of nodal displacements and C
        the moduli of taut fabric, which are never below those of wrinkled or slack fabric."""
        c11, c22, c12, c66 = self.stiffness + self.liner.stiffness
        root = np.linalg.cholesky([[c11, c12, 0.0], [c12, c22, 0.0], [0.0, 0.0, c66]])
        gxx, gyy, gxy = membrane.gradients
        none = np.zeros_like(gxx)
        products = np.array([[gxx, none, gxy], [none, gyy, gxy], [gxy, gxy, gxx + gyy]]).transpose(2, 0, 1)
        return 0.75 / self.density * np.linalg.eigvalsh(root.T @ products @ root)[:, -1]

    def add_forces(
        self, membrane: Membrane, corners: Corners, positions: np.ndarray, velocities: np.ndarray,
        history: np.ndarray, loads: np.ndarray, partial: np.ndarray,
    ) -> None:  # fmt: skip
        """As `billow.parts.fabric.membrane.FabricLaw` promises."""
        rule = KEEP if self.compression else PRINCIPAL if self.is_isotropic else YARN
        mesh = membrane.for_kernels(positions, velocities)
        _linear_forces(len(membrane.elements), rule, *self._moduli, mesh, tuple(corners), history, loads, partial)


@spliced
def taut_stress(c11, c22, c12, c66, e11, e22, e12):
    """Stress (s11, s22, s12) [Pa] of Green strain (e11, e22, e12) [-]; e12 is half the engineering shear."""
    return c11 * e11 + c12 * e22, c12 * e11 + c22 * e22, 2.0 * c66 * e12


@spliced
def yarn_stress(c11, c22, c12, c66, e11, e22, e12):
    """As `taut_stress`, but yarns carry no compression; one that is pulled alone pulls with its own modulus."""
    s11, s22 = c11 * e11 + c12 * e22, c12 * e11 + c22 * e22
    s22 = (c22 - c12 * c12 / c11) * e22 if s11 < 0.0 else s22
    s11 = 0.0 if s11 < 0.0 else s11
    alone = (c11 - c12 * c12 / c22) * e11
    alone = alone if alone > 0.0 else 0.0
    return alone if s22 < 0.0 else s11, 0.0 if s22 < 0.0 else s22, 2.0 * c66 * e12


@spliced
def tension_field_stress(c11, c22, c12, c66, e11, e22, e12):
    """As `taut_stress` of isotropic fabric, which wrinkles: no principal stress is negative."""
    mean, half = 0.5 * (e11 + e22), 0.5 * (e11 - e22)
    radius = math.sqrt(half * half + e12 * e12)
    largest, smallest = mean + radius, mean - radius
    taut = c12 * largest + c22 * smallest >= 0.0
    # Wrinkled: uniaxial tension E e1 n (x) n along the first principal direction n; slack: nothing.
    tension = (c11 - c12 * c12 / c22) * largest
    tension = 0.5 * tension if largest > 0.0 else 0.0
    over = tension / (radius if radius > 0.0 else 1.0)
    return (
        c11 * e11 + c12 * e22 if taut else tension + over * half,
        c12 * e11 + c22 * e22 if taut else tension - over * half,
        2.0 * c66 * e12 if taut else over * e12,
    )


@spliced
def _stress(block, rule, moduli, liner):
    """Fill the rows S11, S22, S12 and ENERGY: of the fabric by its rule, then of the liner too; no loop branches."""
    c11, c22, c12, c66 = moduli
    if rule == KEEP:
        for j in range(BLOCK):
            e11, e22, e12 = 0.5 * (block[AA + j] - 1.0), 0.5 * (block[BB + j] - 1.0), 0.5 * block[AB + j]
            s11, s22, s12 = taut_stress(c11, c22, c12, c66, e11, e22, e12)
            block[S11 + j], block[S22 + j], block[S12 + j] = s11, s22, s12
    elif rule == YARN:
        for j in range(BLOCK):
            e11, e22, e12 = 0.5 * (block[AA + j] - 1.0), 0.5 * (block[BB + j] - 1.0), 0.5 * block[AB + j]
            s11, s22, s12 = yarn_stress(c11, c22, c12, c66, e11, e22, e12)
            block[S11 + j], block[S22 + j], block[S12 + j] = s11, s22, s12
    else:
        for j in range(BLOCK):
            e11, e22, e12 = 0.5 * (block[AA + j] - 1.0), 0.5 * (block[BB + j] - 1.0), 0.5 * block[AB + j]
            s11, s22, s12 = tension_field_stress(c11, c22, c12, c66, e11, e22, e12)
            block[S11 + j], block[S22 + j], block[S12 + j] = s11, s22, s12
    l11, l22, l12, l66 = liner
    for j in range(BLOCK):
        e11, e22, e12 = 0.5 * (block[AA + j] - 1.0), 0.5 * (block[BB + j] - 1.0), 0.5 * block[AB + j]
        m11, m22, m12 = taut_stress(l11, l22, l12, l66, e11, e22, e12)
        s11, s22, s12 = block[S11 + j] + m11, block[S22 + j] + m22, block[S12 + j] + m12
        block[S11 + j], block[S22 + j], block[S12 + j] = s11, s22, s12
        block[ENERGY + j] = 0.5 * (s11 * e11 + s22 * e22 + 2.0 * s12 * e12)


@kernel
def _linear_forces(n, rule, moduli, liner, mesh, corners, history, loads, partial_out):
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        block = open_chunk(chunk, corners, loads, partial_out)
        end = min(n, (chunk + 1) * CHUNK)
        for first in range(chunk * CHUNK, end, BLOCK):
            count = min(BLOCK, end - first)
            fetch(block, first, count, mesh, corners)
            strain_of(block, first, mesh)
            _stress(block, rule, moduli, liner)
            load(block, first, mesh, history, 0.0, 1.0, 0.5)
            add_up(block, first, count, mesh, corners, history, loads, chunk, partial_out)
        close_chunk(block, chunk, partial_out)
