"""What a fabric is made of, independent of any mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np


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

    @cached_property
    def is_isotropic(self) -> bool:
        return bool(
            np.isclose(self.young_warp, self.young_weft)
            and np.isclose(self.shear, 0.5 * self.young_warp / (1.0 + self.poisson))
        )

    @cached_property
    def stiffness(self) -> np.ndarray:
        """Plane-stress moduli (c11, c22, c12, c66) [Pa], (4,)."""
        reverse_poisson = self.poisson * self.young_weft / self.young_warp
        d = 1.0 - self.poisson * reverse_poisson
        return np.array([self.young_warp / d, self.young_weft / d, self.poisson * self.young_weft / d, self.shear])

    @property
    def wave_speed(self) -> float:
        """Fastest membrane wave [m/s]: sqrt(Emax / (rho (1 - nu^2))) (physics notes, section 4), or the fastest plane
        wave in any direction where weft or shear make that faster."""
        young = max(self.young_warp, self.young_weft)
        c11, c22, c12, c66 = self.stiffness
        angle = np.linspace(0.0, 0.5 * np.pi, 91)
        c, s = np.cos(angle) ** 2, np.sin(angle) ** 2
        warp, weft, both = c11 * c + c66 * s, c66 * c + c22 * s, (c12 + c66) ** 2 * c * s
        plane = 0.5 * (warp + weft) + np.sqrt(0.25 * (warp - weft) ** 2 + both)  # of the acoustic tensor
        return float(np.sqrt(max(young / (1.0 - self.poisson**2), plane.max()) / self.density))
