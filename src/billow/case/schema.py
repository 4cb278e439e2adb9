"""The case: what a user writes, one strict schema with units, ranges and defaults.

Every default is a sourced number for a 60-litre driver bag (physics notes, section 9). The reference in docs/case.md is
generated from this file.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w
from pydantic import AfterValidator, BeforeValidator, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from billow.case.quantity import Strict, curve, quantity

Length = quantity("m", 1e-4, 10.0)
Fraction = quantity("-", 0.0, 1.0)
Pressure = quantity("Pa", 0.0, 1e7)
Modulus = quantity("Pa", 1e4, 1e12)
MassFlow = curve("kg/s", 0.0, 100.0)
Radius = quantity("m", 5e-3, 5.0)
Speed = quantity("m/s", -100.0, 100.0)
Acceleration = quantity("m/s^2", -100.0, 100.0)
MOST_ROWS = 100_000  # of histories; a run that needs 50 ms has 500


def _plain_name(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,39}", value):
        raise PydanticCustomError(
            "name",
            "{reason}",
            {
                "reason": "names head columns of histories.csv and lead to settings",
                "try": "use letters, digits, - and _ (at most 40), a letter first",
            },
        )
    return value


def _one_line(value: str) -> str:
    if not value.isprintable():
        raise PydanticCustomError(
            "text",
            "{reason}",
            {"reason": "it holds a line break or a control character", "try": "use plain text in one line"},
        )
    return value


Name = Annotated[str, AfterValidator(_plain_name)]
Text = Annotated[str, AfterValidator(_one_line)]


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


class Plate(Strict):
    """Rigid plate at rest: everything below z = height."""

    shape: Literal["plate"]
    """plate"""
    name: Name = "plate"
    """Name in results."""
    height: quantity("m", -10.0, 10.0) = 0.0
    """Height of its surface."""
    slope: quantity("N/m", 1.0, 1e9) = 1e5
    """Force per penetration of 1 cm^2 of fabric."""
    friction: quantity("-", 0.0, 2.0) = 0.2
    """Coulomb friction coefficient."""
    damping: Fraction = 0.1
    """Contact damping, fraction of critical."""


class SuperEllipsoid(Strict):
    """Rigid super-ellipsoid |x/a|^n + |y/b|^n + |z/c|^n = 1 above the bag, locked or free."""

    shape: Literal["super-ellipsoid"]
    """super-ellipsoid"""
    name: Name = "impactor"
    """Name in results."""
    radii: Radius | tuple[Radius, Radius, Radius] = 0.15
    """Radii a, b, c along its own axes; one number for all three."""
    degree: quantity("-", 2.0, 10.0) = 2.0
    """Degree n: 2 is an ellipsoid, larger is boxier."""
    clearance: quantity("m", 0.0, 5.0) = 0.15
    """Height of its centre minus its third radius above the plane z = 0: the gap to the flat bag."""
    offset: tuple[quantity("m", -5.0, 5.0), quantity("m", -5.0, 5.0)] = (0.0, 0.0)
    """Position of its centre across the bag's axis (x, y)."""
    angle_about_x: quantity("deg", -180.0, 180.0) = 0.0
    """Orientation: rotation about the x axis."""
    locked: bool = True
    """Locked in place, or free to move with six degrees of freedom."""
    mass: quantity("kg", 1e-3, 1000.0) = 4.5
    """Mass; inertia is that of a solid of uniform density."""
    velocity: tuple[Speed, Speed, Speed] = (0.0, 0.0, 0.0)
    """Velocity at the start, if free."""
    slope: quantity("N/m", 1.0, 1e9) = 1e5
    """Contact characteristic: force per penetration of 1 cm^2 of fabric."""
    friction: quantity("-", 0.0, 2.0) = 0.2
    """Coulomb friction coefficient."""
    damping: Fraction = 0.1
    """Contact damping, fraction of critical."""


def _known_shape(value: Any) -> Any:
    shapes = ("plate", "super-ellipsoid")
    if isinstance(value, dict) and value.get("shape") not in shapes:
        given = value.get("shape")
        reason = f"there is no shape {given[:40]!r}" if isinstance(given, str) else "it has no shape"
        remedy = f"write {' or '.join(f'shape = {shape!r}' for shape in shapes)}"
        raise PydanticCustomError("shape", "{reason}", {"reason": reason, "try": remedy})
    return value


Obstacle = Annotated[Plate | SuperEllipsoid, Field(discriminator="shape"), BeforeValidator(_known_shape)]


class Run(Strict):
    """Times and output."""

    end_time: quantity("s", 1e-6, 1.0) = 0.050
    """Simulated time."""
    frames: int = 50
    """Number of output frames after the start, evenly spaced."""
    histories_per_frame: int = 10
    """Rows of histories.csv per frame."""
    dt_scale: quantity("-", 0.01, 1.0) = 1.0
    """Fraction of the stable step to use."""
    gravity: tuple[Acceleration, Acceleration, Acceleration] = (0.0, 0.0, 0.0)
    """Acceleration of gravity; negligible during a deployment."""

    @field_validator("frames", "histories_per_frame")
    @classmethod
    def _countable(cls, value):
        if not 1 <= value <= 10_000:
            raise PydanticCustomError("range", "{reason}", {"reason": f"{value}; expected 1 to 10000"})
        return value

    @model_validator(mode="after")
    def _rows_fit(self):
        rows = self.frames * self.histories_per_frame
        if rows > MOST_ROWS:
            raise PydanticCustomError(
                "rows",
                "{reason}",
                {
                    "reason": f"frames times histories_per_frame makes {rows} rows of histories; at most {MOST_ROWS}",
                    "try": "reduce frames or histories_per_frame",
                },
            )
        return self


class Case(Strict):
    """A whole simulation."""

    title: Text = "Driver bag"
    """Free text."""
    bag: Bag = Bag()
    fabric: Fabric = Fabric()
    gas: Gas = Gas()
    inflator: Inflator = Inflator()
    ambient: Ambient = Ambient()
    obstacles: tuple[Obstacle, ...] = (Plate(shape="plate"),)
    run: Run = Run()

    @field_validator("obstacles")
    @classmethod
    def _distinct(cls, value):
        names = [obstacle.name for obstacle in value]
        if len(set(names)) != len(names):
            raise PydanticCustomError("names", "two obstacles are called {name}", {"name": max(names, key=names.count)})
        return value

    @classmethod
    def load(cls, path: str | Path) -> Case:
        """Case from a TOML file; raises InputError with file, key, value and remedy."""
        from billow.case.case_file import load_case  # which knows this schema

        return load_case(path)

    @classmethod
    def from_dict(cls, data: dict[str, Any], where: str = "case") -> Case:
        """Case from nested dictionaries; raises InputError."""
        from billow.case.case_file import validate

        return validate(data, where)

    def to_dict(self) -> dict[str, Any]:
        """Every key with its effective value, defaults filled in."""
        return self.model_dump(mode="python")

    def to_toml(self) -> str:
        """The effective case as TOML."""
        return tomli_w.dumps(self.to_dict())

    def digest(self) -> str:
        """SHA-256 of the effective case: equal for equal physics and settings."""
        return hashlib.sha256(self.to_toml().encode()).hexdigest()

    def vary(self, changes: dict[str, Any]) -> Case:
        """The case with dotted keys replaced, for example {"fabric.permeability": 0.03, "obstacles.impactor.degree":
        3.0}.

        Obstacles are addressed by name. Raises InputError for unknown keys or bad values.
        """
        from billow.case.vary import vary

        return vary(self, changes)
