"""The `[gas]`, `[inflator]` and `[ambient]` tables."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from billow.case.quantity import Strict, curve, quantity

Fraction = quantity("-", 0.0, 1.0)
MassFlow = curve("kg/s", 0.0, 100.0)


class Gas(Strict):
    """What fills the bag."""

    model: Literal["uniform-pressure", "none"] = "uniform-pressure"
    """uniform-pressure: one well-mixed gas; none: no gas at all."""


class Jets(Strict):
    """Ring of jets the inflator blows through. Uniform pressure alone cannot see their direction."""

    count: int = 12
    """Number of holes; 0 for a diffuse source without jets."""
    ring_radius: quantity("m", 1e-3, 0.5) = 0.038
    """Radius of the ring of holes."""
    hole_diameter: quantity("m", 1e-4, 0.05) = 0.005
    """Diameter of a hole."""
    angle: quantity("deg", 0.0, 89.0) = 45.0
    """Angle of the deflected jets from the bag's axis."""

    @field_validator("count")
    @classmethod
    def _few(cls, value):
        if not 0 <= value <= 64:
            raise PydanticCustomError("range", "{reason}", {"reason": f"{value} jets; expected 0 to 64"})
        return value


class Inflator(Strict):
    """Gas source. Default: 50 g of pyrotechnic gas within 50 ms."""

    gas: dict[str, Fraction] = Field(default_factory=lambda: {"N2": 0.45, "H2O": 0.30, "CO2": 0.25})
    """Mole fractions; they must sum to 1."""
    mass_flow: MassFlow = MassFlow(time=(0.0, 0.008, 0.050), value=(0.0, 2.0, 0.0))
    """Mass flow against time, piecewise linear, zero outside."""
    temperature: quantity("K", 200.0, 3000.0) | curve("K", 200.0, 3000.0) = 650.0
    """Total temperature of the gas: one number, or a curve against time."""
    jets: Jets = Jets()

    @field_validator("gas")
    @classmethod
    def _whole(cls, value):
        total = sum(value.values())
        if abs(total - 1.0) > 1e-6:
            raise PydanticCustomError("fractions", "mole fractions sum to {total}, not 1", {"total": round(total, 9)})
        return value

    @model_validator(mode="after")
    def _delivers(self):
        if not any(self.mass_flow.value):
            raise PydanticCustomError(
                "flow",
                "{reason}",
                {
                    "reason": "the mass flow is zero at all times",
                    "try": 'set gas.model = "none" for a bag without inflator',
                },
            )
        return self


class Ambient(Strict):
    """Still air around and, at the start, inside the bag."""

    pressure: quantity("Pa", 1e3, 1e6) = 101325.0
    """Absolute pressure."""
    temperature: quantity("K", 200.0, 400.0) = 295.0
    """Temperature."""
