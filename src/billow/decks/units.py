"""The unit system of a deck, which no deck says: found by evidence, or asked for.

A system is consistent: mass, length and time decide the rest. Each piece of evidence is a number whose SI value can
only lie in a certain range; a system in which all lie in theirs passes. Exactly one must pass, on two pieces at least.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal

from billow.base.errors import InputError

UNKNOWN_UNITS = InputError.declare(
    "E-DCK-009",
    "the units of the deck cannot be told",
    where="{deck}",
    cause="a deck of meshes alone, or numbers in a system that is not in the list",
    remedy="say them: --units, one of {names}",
)


@dataclass(frozen=True)
class Units:
    """name; kilograms, metres and seconds in one unit of mass, length and time."""

    name: str
    mass: float
    length: float
    time: float

    def factor(self, dimension: str) -> float:
        """What a number of this dimension is multiplied by to be SI."""
        m, length, t = DIMENSIONS[dimension]
        return self.mass**m * self.length**length * self.time**t

    def si(self, value: float, dimension: str) -> float:
        """A number of the deck in SI; where all units are powers of ten, its digits stay what they are."""
        power = self._power(dimension)
        return value * self.factor(dimension) if power is None else _moved(value, power)

    def of_si(self, value: float, dimension: str) -> float:
        """The other way."""
        power = self._power(dimension)
        return value / self.factor(dimension) if power is None else _moved(value, -power)

    def _power(self, dimension: str) -> int | None:
        """The power of ten that the factor is, None if it is none."""
        power = round(math.log10(self.factor(dimension)))
        return power if math.isclose(self.factor(dimension), 10.0**power, rel_tol=1e-12) else None


def _moved(value: float, power: int) -> float:
    """A number times a power of ten, its shortest digits kept."""
    return float(Decimal(repr(float(value))).scaleb(power)) if power else float(value)


DIMENSIONS = {
    "-": (0, 0, 0),
    "mass": (1, 0, 0),
    "length": (0, 1, 0),
    "area": (0, 2, 0),
    "time": (0, 0, 1),
    "velocity": (0, 1, -1),
    "per velocity": (0, -1, 1),
    "acceleration": (0, 1, -2),
    "force": (1, 1, -2),
    "inertia": (1, 2, 0),
    "stiffness": (1, 0, -2),
    "mass per length": (1, -1, 0),
    "density": (1, -3, 0),
    "pressure": (1, -1, -2),
    "mass flow": (1, 0, -1),
    "power": (1, 2, -3),
    "specific heat": (0, 2, -2),
    "molar heat": (1, 2, -2),
    "molar mass": (1, 0, 0),
    "heat transfer": (1, 0, -3),
    "frequency": (0, 0, -1),
    "per pressure": (-1, 1, 2),
}
"""Powers of mass, length and time; mole and kelvin are the same in all systems."""

SYSTEMS = {
    units.name: units
    for units in (
        Units("kg-mm-ms", 1.0, 1e-3, 1e-3),
        Units("t-mm-s", 1e3, 1e-3, 1.0),
        Units("kg-m-s", 1.0, 1.0, 1.0),
        Units("g-mm-ms", 1e-3, 1e-3, 1e-3),
        Units("lbf-in-s", 175.12683524647637, 0.0254, 1.0),
    )
}
"""By name. The unit of mass of lbf-in-s is lbf s^2/in."""

RANGES = {
    "gas constant": ("molar heat", 8.2, 8.5, "J/(mol K)"),
    "ambient pressure": ("pressure", 8e4, 1.1e5, "Pa"),
    "density of fabric": ("density", 400.0, 1600.0, "kg/m^3"),
    "thickness of fabric": ("length", 1e-4, 1e-3, "m"),
    "modulus of fabric": ("pressure", 2e7, 3e10, "Pa"),
    "molar mass": ("molar mass", 2e-3, 0.2, "kg/mol"),
    "size of the bag": ("length", 0.1, 5.0, "m"),
    "end of the run": ("time", 5e-3, 1.0, "s"),
}
"""Kind of evidence -> its dimension, the range of its SI value, and that unit."""
LEAST = 2


@dataclass(frozen=True)
class Evidence:
    """kind: one of RANGES. value: as the deck has it. place: where."""

    kind: str
    value: float
    place: str

    def in_si(self, units: Units) -> float:
        return self.value * units.factor(RANGES[self.kind][0])

    def fits(self, units: Units) -> bool:
        _, low, high, _ = RANGES[self.kind]
        return low <= self.in_si(units) <= high


def find_units(evidence: list[Evidence], deck: str, told: tuple[str, str] | None = None) -> Units:
    """The one system that fits all evidence. told: one that the deck names, and where. Raises InputError E-DCK-009,
    which says what each reading would mean."""
    passed = [units for units in SYSTEMS.values() if all(one.fits(units) for one in evidence)]
    if told is not None:
        if any(units.name == told[0] for units in passed):
            return SYSTEMS[told[0]]
        why = f"UNIT at {told[1]} says {told[0]}, which does not fit; {_readings(evidence, passed)}"
        raise UNKNOWN_UNITS(deck=deck, names=", ".join(SYSTEMS), why=why)
    if len(passed) == 1 and len({one.kind for one in evidence}) >= LEAST:
        return passed[0]
    raise UNKNOWN_UNITS(deck=deck, names=", ".join(SYSTEMS), why=_readings(evidence, passed))


def _readings(evidence: list[Evidence], passed: list[Units]) -> str:
    if not evidence:
        return "the deck holds nothing that tells them: no gas constant, pressure, density, thickness or size"
    counted = {0: "no system fits all of it", 1: f"{len(evidence)} piece of evidence is too little"}
    head = counted.get(len(passed), f"{len(passed)} systems fit")
    said = []
    for units in SYSTEMS.values():
        first = next((one for one in evidence if not one.fits(units)), evidence[0])
        unit = RANGES[first.kind][3]
        said.append(f"{units.name}: {first.kind} {first.in_si(units):.3g} {unit} at {first.place}")
    return f"{head}; " + "; ".join(said)
