"""The `[bag]` table: shape, mesh size, vents, straps."""

from __future__ import annotations

from typing import Literal

from pydantic import field_validator
from pydantic_core import PydanticCustomError

from billow.case.quantity import Strict, quantity

Length = quantity("m", 1e-4, 10.0)
Fraction = quantity("-", 0.0, 1.0)
Pressure = quantity("Pa", 0.0, 1e7)


class Vents(Strict):
    """Vent holes in the rear panel, evenly spaced about the axis."""

    count: int = 2
    """Number of vents."""
    diameter: quantity("m", 1e-3, 0.2) = 0.035
    """Diameter of each hole."""
    distance: Length = 0.17
    """Distance of their centres from the bag's axis."""
    discharge: Fraction = 0.7
    """Discharge coefficient."""
    opening_pressure: Pressure = 0.0
    """Gauge pressure at which a vent opens and stays open."""

    @field_validator("count")
    @classmethod
    def _few(cls, value):
        if not 0 <= value <= 12:
            raise PydanticCustomError("range", "{reason}", {"reason": f"{value} vents; expected 0 to 12"})
        return value


class Straps(Strict):
    """Straps (tethers) from the retainer ring to a stitch line on the front panel, cut from the bag's fabric."""

    count: int = 4
    """Number of straps."""
    length: quantity("m", 0.01, 2.0) = 0.28
    """Unstretched length."""
    width: quantity("m", 1e-3, 0.5) = 0.06
    """Width of each strap."""
    stitch_radius: quantity("m", 1e-3, 2.0) = 0.08
    """Radius of the stitch line on the front panel."""

    @field_validator("count")
    @classmethod
    def _few(cls, value):
        if not 0 <= value <= 24:
            raise PydanticCustomError("range", "{reason}", {"reason": f"{value} straps; expected 0 to 24"})
        return value


class Bag(Strict):
    """Driver bag: two round panels sewn at the rim, lying flat on the plane z = 0, mouth and vents in the rear
    panel."""

    shape: Literal["driver"] = "driver"
    """Kind of bag."""
    diameter: quantity("m", 0.05, 5.0) = 0.70
    """Diameter of the flat panels."""
    element_size: quantity("m", 5e-4, 0.2) = 0.010
    """Edge length of the triangles, about."""
    mouth_radius: quantity("m", 5e-3, 1.0) = 0.05
    """Radius of the retainer ring; fabric on it and inside is held fixed."""
    initial_gap: quantity("m", 1e-5, 0.2) = 0.002
    """Height of the front panel's middle above the rear panel at the start."""
    vents: Vents = Vents()
    straps: Straps = Straps()
