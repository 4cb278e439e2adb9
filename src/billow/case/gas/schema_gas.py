"""The `[gas]`, `[inflator]`, `[ambient]` and `[leakage]` tables."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag, field_validator, model_validator

from billow.case.gas.models import GAS_MODELS
from billow.case.quantity import Name, Strict, curve, distinct, number_or_curve, quantity, refused, whole
from billow.parts.gas.supply.species import AIR, COLDEST, HOTTEST, MOLAR_GAS_CONSTANT

Fraction = quantity("-", 0.0, 1.0)
Pressure = quantity("Pa", 1e3, 1e6)
MassFlow = curve("kg/s", 0.0, 100.0)
Molar = quantity("J/(mol K)", -1000.0, 1000.0)
Term = quantity("-", -100.0, 100.0)

LARGEST = {"permeability": 10.0, "wang-nefske": 1.0, "graefe": 1.0, "porous-medium": 0.1, "velocity-curve": 50.0}
"""Largest plausible coefficient of each law, in its own unit."""

NO_INFLATOR = 'set gas.model = "none" for a bag without inflator'
ONE, SEVERAL = "inflator[one]", "inflator[several]"  # how inflators were written: branches that stand in no key


def _require_whole(fractions: dict[str, float]) -> dict[str, float]:
    total = sum(fractions.values())
    if abs(total - 1.0) > 1e-6:
        raise refused(f"fractions sum to {round(total, 9)}, not 1")
    return fractions


Fractions = Annotated[dict[str, Fraction], AfterValidator(_require_whole)]


class Species(Strict):
    """A user-defined gas: molar heat capacity cp = a + b T + c T^2."""

    molar_mass: quantity("kg/mol", 1e-3, 0.5)
    """Molar mass."""
    a: Molar
    """Constant part, J/(mol K)."""
    b: quantity("-", -10.0, 10.0) = 0.0
    """Linear part, J/(mol K^2)."""
    c: quantity("-", -0.1, 0.1) = 0.0
    """Quadratic part, J/(mol K^3)."""

    @model_validator(mode="after")
    def _heats(self):
        within = [COLDEST, HOTTEST]
        if self.c and COLDEST < -0.5 * self.b / self.c < HOTTEST:
            within.append(-0.5 * self.b / self.c)
        least, at = min((self.a + t * (self.b + t * self.c), t) for t in within)
        if least <= MOLAR_GAS_CONSTANT:
            raise refused(
                f"cp falls to {least:.4g} J/(mol K) at {at:g} K; it must stay above the gas constant, "
                f"{MOLAR_GAS_CONSTANT:.4g} J/(mol K), between {COLDEST:g} and {HOTTEST:g} K",
                "give molar values, a in J/(mol K), b in J/(mol K^2), c in J/(mol K^3)",
            )
        return self


class Initial(Strict):
    """What the bag holds at the start."""

    gas: Fractions = Field(default_factory=lambda: dict(AIR))
    """Composition; fractions must sum to 1."""
    fractions: Literal["mole", "mass"] = "mole"
    """What the fractions are of."""
    temperature: quantity("K", 200.0, 3000.0) | Literal["ambient"] = "ambient"
    """Temperature."""
    pressure: Pressure | Literal["ambient"] = "ambient"
    """Absolute pressure."""


class Orifice(Strict):
    """A hole of fixed area between two chambers, or to the surroundings, that is not part of the mesh."""

    name: Name
    """Name, for the histories."""
    between: tuple[Name, Name]
    """The two chambers it joins; "ambient" for the surroundings."""
    area: quantity("m^2", 1e-8, 10.0)
    """Area."""
    discharge: number_or_curve("-", 0.0, 1.0, "time") = 0.7
    """Discharge coefficient: a number, or a curve against time."""

    @model_validator(mode="after")
    def _joins(self):
        if self.between[0] == self.between[1]:
            raise refused(f"it joins {self.between[0]} with itself")
        return self


class Gas(Strict):
    """What fills the bag."""

    model: Literal[tuple(GAS_MODELS)] = "uniform-pressure"
    """uniform-pressure: one well-mixed gas in each chamber; corpuscular: particles that fly, collide and push, so that
    jets, narrow gaps and the flow path matter; mesh: flow of a gas without viscosity on a mesh of cells that the fabric
    cuts, without noise; none: no gas at all."""
    cell: quantity("m", 5e-4, 0.2) = 0.015
    """Edge of a cell of the mesh gas. Half of it costs about 16 times as much."""
    advection: Literal["donor", "van_leer"] = "van_leer"
    """Scheme of the mesh gas: donor is of first order, smears jets and waves, and cannot overshoot; van_leer is of
    second order where the flow is smooth."""
    flow_limit: quantity("-", 0.02, 1.0) = 1.0
    """Part of a cell that the mesh gas may flow in a step of its own, at most. 1: only stability limits steps, 0.9 of a
    cell for flow and sound together. 0.25 is the limit of other codes; it costs more steps beyond Mach 1.1."""
    film_friction: bool = False
    """Whether walls brake the mesh gas in layers thinner than a cell, as in a channel with fully developed flow.
    Matters below a millimetre; gas in motion for a few milliseconds is braked harder than that."""
    particles: whole(1_000, 20_000_000) = 100_000
    """Number of particles of the corpuscular gas, for injected and initial gas together."""
    seed: whole(0, 2**31 - 1) = 1
    """Seed of the corpuscular gas' random numbers; runs with other seeds show how large the noise is."""
    switch_time: quantity("s", 0.0, 10.0) = 0.0
    """Time at which the corpuscular or mesh gas becomes uniform pressure, which costs almost nothing; 0 for never.
    Mass and energy are kept exactly; the kinetic energy of the flow becomes heat."""
    heat_transfer: quantity("W/(m^2 K)", 0.0, 1e4) = 0.0
    """Heat transfer coefficient from the gas through the outer fabric to the surroundings."""
    opening_discharge: Fraction = 0.7
    """Discharge coefficient of the openings between chambers."""
    initial: Initial = Initial()
    orifices: tuple[Orifice, ...] = ()
    species: dict[Name, Species] = Field(default_factory=dict)
    """User-defined gases by name, for example [gas.species.smoke]; they take precedence over the library."""

    _distinct = field_validator("orifices")(distinct("orifices"))


class Jets(Strict):
    """Ring of jets the inflator blows through. Uniform pressure alone cannot see their direction."""

    count: whole(0, 64, "jets") = 12
    """Number of holes; 0 for a diffuse source without jets."""
    ring_radius: quantity("m", 1e-3, 0.5) | Literal["fits"] = "fits"
    """Radius of the ring of holes; fits: 38 mm, or 0.8 of the radius of a mouth that is too small for that."""
    hole_diameter: quantity("m", 1e-4, 0.05) = 0.005
    """Diameter of a hole."""
    angle: quantity("deg", 0.0, 89.0) = 45.0
    """Angle of the deflected jets from the bag's axis."""
    azimuth: quantity("deg", -360.0, 360.0) = 0.0
    """Place of the first hole on the ring: angle about the axis into the bag, from the x axis; for a mesh, from the
    node with the lowest number on the rim of the mouth, so that the ring belongs to the mouth however the bag lies."""
    cone: quantity("deg", 0.0, 89.0) = 15.0
    """Half-angle of the cone each jet spreads in, for the corpuscular gas; uniform pressure has its own law of jets."""
    spin: quantity("Hz", -1e4, 1e4) = 0.0
    """Turns of the ring about the bag's axis per second."""


class Inflator(Strict):
    """Gas source; several are written as [[inflator]], each with a name. Default: 50 g of pyrotechnic gas within 50
    ms."""

    name: Name = "inflator"
    """Name; inflators are told apart by it."""
    chamber: Name = "mouth"
    """Chamber it blows into; mouth: the one with the mouth, or the first if none or several have one; first: the
    first."""
    delay: quantity("s", 0.0, 10.0) = 0.0
    """Added to the times of its curves."""
    scale: quantity("-", 0.01, 100.0) = 1.0
    """Factor on the mass flow."""
    time_scale: quantity("-", 0.01, 100.0) = 1.0
    """Factor on the times of its curves, before the delay is added: 2 blows twice as long, and twice the mass."""
    gas: Fractions = Field(default_factory=lambda: {"N2": 0.45, "H2O": 0.30, "CO2": 0.25})
    """Composition; fractions must sum to 1."""
    fractions: Literal["mole", "mass"] = "mole"
    """What the fractions are of."""
    mass_flow: MassFlow = MassFlow(time=(0.0, 0.008, 0.050), value=(0.0, 2.0, 0.0))
    """Mass flow against time, piecewise linear, zero outside."""
    temperature: quantity("K", 200.0, 3000.0) | curve("K", 200.0, 3000.0) = 650.0
    """Total temperature of the gas: one number, or a curve against time."""
    jets: Jets = Jets()

    @model_validator(mode="after")
    def _delivers(self):
        if not any(self.mass_flow.value):
            raise refused("the mass flow is zero at all times", NO_INFLATOR)
        return self


Inflators = Annotated[
    Annotated[Inflator, Tag(ONE)] | Annotated[tuple[Inflator, ...], Tag(SEVERAL)],
    Discriminator(lambda value: SEVERAL if isinstance(value, (list, tuple)) else ONE),
]
"""One inflator, or several."""


class Ambient(Strict):
    """Still air around and, at the start, inside the bag."""

    pressure: Pressure = 101325.0
    """Absolute pressure."""
    temperature: quantity("K", 200.0, 400.0) = 295.0
    """Temperature."""


class PartLeakage(Strict):
    """Leakage through one part of the fabric."""

    law: Literal["permeability", "wang-nefske", "graefe", "porous-medium", "velocity-curve"] = "permeability"
    """permeability: fabric.permeability times a leak speed that grows with the root of the pressure difference.
    wang-nefske: an orifice of a share of the fabric's area. graefe: sqrt(2 rho dp). porous-medium: proportional to dp.
    velocity-curve: a leak speed times the density upstream. The factors multiply each."""
    time_factor: number_or_curve("-", 0.0, 1e6, "time") = 1.0
    """Factor (FLC): a number, or a curve against time."""
    pressure_factor: number_or_curve("-", 0.0, 1e6, "pressure") = 1.0
    """Factor (FAC): a number, or a curve against the absolute pressure upstream. In s/m for porous-medium, m/s for
    velocity-curve, without unit for the others."""
    area: Literal["reference", "deformed"] | tuple[Term, Term, Term, Term] = "reference"
    """Area that leaks: as cut, as stretched, or four terms X0 to X3 of X0 + X1 rs + X2 rp + X3 rs rp on the area as
    cut, rs the stretch of area and rp the pressure ratio (Anagonye and Wang)."""
    blockage: bool = False
    """Whether fabric in contact with an obstacle, or with another layer of fabric ("layers"), stops leaking."""
    through_blocked: quantity("-", 0.0, 1.0) = 0.0
    """Share of the leakage that remains through blocked fabric."""

    @model_validator(mode="after")
    def _plausible(self):
        if self.law in ("porous-medium", "velocity-curve") and self.pressure_factor == 1.0:
            raise refused(
                f"{self.law} needs a pressure_factor; it has the unit of the law",
                "give leakage.pressure_factor as a number or a curve against absolute pressure",
            )
        factors = (self.time_factor, self.pressure_factor)
        largest = math.prod(f if isinstance(f, float) else max(f.value) for f in factors)
        limit = LARGEST[self.law]
        if largest > limit:
            raise refused(
                f"the factors of {self.law} reach {largest:g}; at most {limit:g} is plausible",
                "check the unit of leakage.pressure_factor: SI, against absolute pressure",
            )
        return self


class Leakage(PartLeakage):
    """Leakage through the fabric. One law for all of it, and others for single parts."""

    parts: dict[Name, PartLeakage] = Field(default_factory=dict)
    """Laws of single parts by name, for example [leakage.parts.front]; each replaces the general law completely."""
