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

from billow.base.compiled import CHUNK, kernel, scalar
from billow.base.errors import Concern
from billow.parts.fabric.membrane import Membrane, odd_speed
from billow.parts.fabric.triangle import add_corner_forces, along, products, stretch_bound
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
    history_width: ClassVar[int] = 0

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

    def add_forces(
        self, membrane: Membrane, triangles: np.ndarray, positions: np.ndarray, velocities: np.ndarray,
        history: np.ndarray, corner_force: np.ndarray, partial: np.ndarray,
    ) -> None:  # fmt: skip
        """As `billow.parts.fabric.membrane.FabricLaw` promises; there is no history."""
        rule = KEEP if self.compression else PRINCIPAL if self.is_isotropic else YARN
        mesh = membrane.for_kernels(triangles, positions, velocities)
        _linear_forces(len(membrane.elements), rule, *self._moduli, mesh, corner_force, partial)


@scalar
def linear_stress(rule, c11, c22, c12, c66, e11, e22, e12):
    """Stress (s11, s22, s12) [Pa] of Green strain (e11, e22, e12) [-]; e12 is half the engineering shear."""
    s11 = c11 * e11 + c12 * e22
    s22 = c12 * e11 + c22 * e22
    s12 = 2.0 * c66 * e12
    if rule == KEEP:
        return s11, s22, s12
    if rule == YARN:
        if s11 < 0.0:
            s11 = 0.0
            s22 = (c22 - c12 * c12 / c11) * e22
        if s22 < 0.0:
            s22 = 0.0
            s11 = max(0.0, (c11 - c12 * c12 / c22) * e11)
        return s11, s22, s12
    # Principal tension field; isotropic, so stress and strain share their axes.
    mean = 0.5 * (e11 + e22)
    radius = math.sqrt((0.5 * (e11 - e22)) ** 2 + e12 * e12)
    largest, smallest = mean + radius, mean - radius
    if c12 * largest + c22 * smallest >= 0.0:
        return s11, s22, s12  # taut
    if largest <= 0.0:
        return 0.0, 0.0, 0.0  # slack
    # Wrinkled: uniaxial tension along the first principal direction n, S = E e1 n (x) n.
    tension = (c11 - c12 * c12 / c22) * largest
    nn11 = 0.5 * (1.0 + 0.5 * (e11 - e22) / radius)
    nn12 = 0.5 * e12 / radius
    return tension * nn11, tension * (1.0 - nn11), tension * nn12


@kernel
def _linear_forces(n, rule, moduli, liner, mesh, corner_force, partial_out):
    elements, inverse, volume, viscosity, triangles, positions, velocities = mesh
    (c11, c22, c12, c66), (l11, l22, l12, l66) = moduli, liner
    chunks = (n + CHUNK - 1) // CHUNK
    for chunk in prange(chunks):
        energy, power, largest = 0.0, 0.0, 0.0
        for item in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            i = np.uint64(item)
            t = np.uint64(elements[i])
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            d11, d12, d21, d22 = inverse[0, i], inverse[1, i], inverse[2, i], inverse[3, i]
            f = along(positions, a, b, c, d11, d12, d21, d22)
            aa, bb, ab, r11, r22, r12 = products(f, along(velocities, a, b, c, d11, d12, d21, d22))
            e11, e22, e12 = 0.5 * (aa - 1.0), 0.5 * (bb - 1.0), 0.5 * ab
            s11, s22, s12 = linear_stress(rule, c11, c22, c12, c66, e11, e22, e12)
            m11, m22, m12 = linear_stress(KEEP, l11, l22, l12, l66, e11, e22, e12)
            s11, s22, s12 = s11 + m11, s22 + m22, s12 + m12
            v, mu = volume[i], viscosity[i]
            energy += 0.5 * v * (s11 * e11 + s22 * e22 + 2.0 * s12 * e12)
            power += v * mu * (r11 * r11 + r22 * r22 + 2.0 * r12 * r12)
            largest = max(largest, stretch_bound(aa, bb, ab, 0.0, 1.0))
            s11, s22, s12 = s11 + mu * r11, s22 + mu * r22, s12 + mu * r12
            add_corner_forces(corner_force, t, v, f, s11, s22, s12, d11, d12, d21, d22)
        partial_out[chunk, 0] = energy
        partial_out[chunk, 1] = power
        partial_out[chunk, 2] = largest
        partial_out[chunk, 3] = 0.0
