"""The `[leakage]` table: how gas gets through the fabric."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from billow.case.gas.factor import over_pressure, over_time
from billow.case.quantity import Strict, quantity, refused
from billow.case.text import Name

Term = quantity("-", -100.0, 100.0)
LARGEST = {"permeability": 10.0, "wang-nefske": 1.0, "graefe": 1.0, "porous-medium": 0.1, "velocity-curve": 50.0}
"""Largest plausible coefficient of each law, in its own unit."""


class PartLeakage(Strict):
    """Leakage through one part of the fabric."""

    law: Literal["permeability", "wang-nefske", "graefe", "porous-medium", "velocity-curve"] = "permeability"
    """permeability: fabric.permeability times a leak speed that grows with the root of the pressure difference.
    wang-nefske: an orifice of a share of the fabric's area. graefe: sqrt(2 rho dp). porous-medium: proportional to dp.
    velocity-curve: a leak speed times the density upstream. The factors multiply each."""
    time_factor: over_time("-", 0.0, 1e6) = 1.0
    """Factor (FLC): a number, or a curve against time."""
    pressure_factor: over_pressure("-", 0.0, 1e6) = 1.0
    """Factor (FAC): a number, or a curve against the absolute pressure upstream. In s/m for porous-medium, m/s for
    velocity-curve, without unit for the others."""
    area: Literal["reference", "deformed"] | tuple[Term, Term, Term, Term] = "reference"
    """Area that leaks: as cut, as stretched, or four terms X0 to X3 of X0 + X1 rs + X2 rp + X3 rs rp on the area as
    cut, rs the stretch of area and rp the pressure ratio (Anagonye and Wang)."""
    blockage: bool = False
    """Whether fabric in contact with an obstacle stops leaking."""
    through_blocked: quantity("-", 0.0, 1.0) = 0.0
    """Share of the leakage that remains through blocked fabric."""

    @model_validator(mode="after")
    def _plausible(self):
        if self.law in ("porous-medium", "velocity-curve") and self.pressure_factor == 1.0:
            raise refused(
                f"{self.law} needs a pressure_factor; it has the unit of the law",
                "give leakage.pressure_factor as a number or a curve against absolute pressure",
            )
        largest = self._largest(self.time_factor) * self._largest(self.pressure_factor)
        limit = LARGEST[self.law]
        if largest > limit:
            raise refused(
                f"the factors of {self.law} reach {largest:g}; at most {limit:g} is plausible",
                "check the unit of leakage.pressure_factor: SI, against absolute pressure",
            )
        return self

    @staticmethod
    def _largest(factor) -> float:
        return factor if isinstance(factor, float) else max(factor.value)


class Leakage(PartLeakage):
    """Leakage through the fabric. One law for all of it, and others for single parts."""

    parts: dict[Name, PartLeakage] = Field(default_factory=dict)
    """Laws of single parts by name, for example [leakage.parts.front]; each replaces the general law completely."""
