"""Three-node membrane triangles, total Lagrangian from the flat cut (docs/theory.md, Membrane element)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.parts.fabric.fabric_law import FabricLaw

UNDAMPED, SLACKENING = 1e-3, 0.4
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


@dataclass(frozen=True)
class Membrane:
    """Elements that share one fabric.

    elements: (n,) int64, indices of their triangles in the surface. reference_inverse: Dm^-1 row by row, [1/m], (4, n).
    yarn_inverse: the same with its columns along the yarns. volume: reference area times thickness, [m^3], (n,).
    viscosity: damping modulus, [Pa s], (n,). altitude: smallest reference altitude, [m], (n,).
    """

    fabric: FabricLaw
    elements: np.ndarray
    reference_inverse: np.ndarray
    yarn_inverse: np.ndarray
    volume: np.ndarray
    viscosity: np.ndarray
    altitude: np.ndarray

    @classmethod
    def build(
        cls, fabric: FabricLaw, elements: np.ndarray, reference: np.ndarray, thickness: float | np.ndarray | None = None
    ) -> Membrane:
        """Elements from flat corner coordinates, reference: [m], (n, 3, 2), warp first.

        thickness: if it differs from the fabric's own (seams, reinforcements), [m], (n,) or one number.
        Raises InputError E-GEO-004 if a reference triangle has no area.
        """
        edge1, edge2 = reference[:, 1] - reference[:, 0], reference[:, 2] - reference[:, 0]
        determinant = edge1[:, 0] * edge2[:, 1] - edge1[:, 1] * edge2[:, 0]
        longest = np.max([np.sum(e**2, axis=1) for e in (edge1, edge2, edge2 - edge1)], axis=0)
        if (np.abs(determinant) < 1e-8 * longest).any():
            bad = int(np.argmax(np.abs(determinant) < 1e-8 * longest))
            raise NO_AREA(triangle=elements[bad])
        inverse = np.array([edge2[:, 1], -edge2[:, 0], -edge1[:, 1], edge1[:, 0]]) / determinant
        area = 0.5 * np.abs(determinant)
        altitude = 2.0 * area / np.sqrt(longest)
        viscosity = fabric.damping * fabric.density * fabric.wave_speed * altitude
        volume = area * (fabric.thickness if thickness is None else thickness)
        return cls(
            fabric, np.asarray(elements, np.int64), inverse, fabric.along_yarns(inverse), volume, viscosity, altitude
        )

    @property
    def mass(self) -> np.ndarray:
        """Mass of each element [kg], (n,)."""
        return self.fabric.density * self.volume

    def fresh_history(self) -> np.ndarray:
        """History of fabric that has never been strained, (n, history_width)."""
        return np.zeros((len(self.elements), self.fabric.history_width))

    def stable_dt(self, largest_stretch: float = 1.0) -> float:
        """Stable step [s] of the most critical element: h/c (sqrt(1 + xi^2) - xi) / stretch, without a safety factor.

        h is the smallest altitude, c the wave speed and xi the damping fraction (docs/theory.md, Membrane step;
        Belytschko, Liu and Moran, "Nonlinear Finite Elements for Continua and Structures", 2000, ch. 6). In a total
        Lagrangian element the tangent grows with the square of the stretch, so the step shrinks with the stretch.

        Fabric without compression has a kink in its stress wherever it goes slack. At each kink a step within the bound
        gains or loses a little energy; the gains win, unless damping takes them. Next to no damping therefore needs a
        shorter step.
        """
        xi = self.fabric.damping
        factor = (np.sqrt(1.0 + xi**2) - xi) / max(1.0, largest_stretch)
        if not self.fabric.compression:
            factor *= min(1.0, SLACKENING + (1.0 - SLACKENING) * xi / UNDAMPED)
        return float(self.altitude.min() / self.fabric.wave_speed * factor)
