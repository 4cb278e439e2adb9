"""The `[fabric]` table."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator
from pydantic_core import PydanticCustomError

from billow.case.quantity import Strict, quantity

Modulus = quantity("Pa", 1e4, 1e12)


class Fabric(Strict):
    """Woven fabric. Defaults: nylon 6.6, 470 dtex, uncoated."""

    law: Literal["linear"] = "linear"
    """linear: orthotropic, linear in Green strain (FORM 0)."""
    density: quantity("kg/m^3", 50.0, 5000.0) = 800.0
    """Mass per volume of the fabric as woven."""
    thickness: quantity("m", 1e-5, 5e-3) = 0.30e-3
    """Thickness."""
    young_warp: Modulus = 0.40e9
    """Young's modulus along the warp."""
    young_weft: Modulus = 0.35e9
    """Young's modulus along the weft."""
    poisson: quantity("-", 0.0, 0.49) = 0.2
    """Poisson's ratio (warp load, weft contraction)."""
    shear: Modulus = 10e6
    """Shear modulus between warp and weft; woven fabric is soft in shear."""
    compression: bool = False
    """Whether the fabric carries compression; real fabric buckles."""
    damping: quantity("-", 0.0, 0.5) = 0.05
    """Stiffness-proportional damping, as a fraction of critical in an element's highest mode."""
    permeability: quantity("-", 0.0, 10.0) = 0.0
    """Leak speed in units of 1 m/s at 500 Pa; grows with the root of the pressure difference. 0 for coated fabric."""

    @model_validator(mode="after")
    def _resists(self):
        largest = (self.young_warp / self.young_weft) ** 0.5
        if self.poisson >= largest:
            raise PydanticCustomError(
                "poisson",
                "{reason}",
                {
                    "reason": f"with young_warp = {self.young_warp:g} Pa, young_weft = {self.young_weft:g} Pa and "
                    f"poisson = {self.poisson:g} a stretched fabric gains energy; poisson must stay below the root of "
                    f"young_warp / young_weft, {largest:.3g}",
                    "try": "check the units of both moduli, reduce poisson, or exchange young_warp and young_weft",
                },
            )
        return self
