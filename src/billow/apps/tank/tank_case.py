"""The case of a tank test: one TOML file for prediction and evaluation (docs/tank.md, The file)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, ValidationError

from billow.apps.tank.filling import InflowTemperature, Tank, make_tank
from billow.base.errors import InputError, shown
from billow.base.toml_file import read_toml
from billow.base.units import in_unit
from billow.case.quantity import Strict, Text, curve, listed, missing_beside, quantity, reason_of, refused
from billow.parts.gas.supply.species import AIR, SPECIES

UNREADABLE = InputError.declare(
    "E-TANK-001",
    "the tank case cannot be read",
    cause="a misspelt path, or a file that is not TOML",
    remedy="give a TOML file; docs/tank.md has one to start from",
)
UNUSABLE_KEY = InputError.declare(
    "E-TANK-002",
    "{key} cannot be used",
    where="{place}, key {key}",
    cause="a misspelt key, or a number in another unit",
    remedy="see docs/tank.md for the keys and their units",
)
UNKNOWN_GAS = InputError.declare(
    "E-TANK-003",
    "unknown gas {name}",
    why="there are no thermodynamic data for it",
    cause="a misspelt formula",
    remedy="use {known}",
)
SHARES_OTHER_THAN_ONE = InputError.declare(
    "E-TANK-004",
    "the mole fractions sum to {total:.9g}, not 1",
    why="a share is missing or given twice, or the numbers are percentages",
    remedy='correct them; percentages are written as "45 %"',
)
NOT_GIVEN = InputError.declare(
    "E-TANK-012",
    "{quantity} is not given",
    where="the tank case, [{table}]",
    cause="a key that only a prediction or only an evaluation needs",
    remedy="add the key; docs/tank.md shows the file",
)


def _cubic_metres(value: Any) -> Any:
    """A text such as "60 l" in cubic metres."""
    if isinstance(value, bool):
        raise refused("a volume is expected, not true or false", kind="unit")
    for unit, factor in (("m^3", 1.0), ("l", 1e-3)):
        if isinstance(value, str) and value.rstrip().endswith(unit):
            try:
                return factor * in_unit(value.rstrip().removesuffix(unit), "-")
            except ValueError as error:
                raise refused(str(error), kind="unit") from None
    return value


def volume_within(low: float, high: float) -> Any:
    """A volume kept in cubic metres; values outside low..high are refused as implausible."""

    def check(value: float) -> float:
        if low <= value <= high:
            return value
        reason = f"{value:g} m^3 is outside the plausible range {low:g} to {high:g} m^3"
        remedy = f'write "{value:g} l" if litres are meant' if low <= 1e-3 * value <= high else None
        raise refused(reason, remedy, kind="range")

    return Annotated[float, BeforeValidator(_cubic_metres), AfterValidator(check)]


Fractions = dict[str, quantity("-", 0.0, 1.0)]
Kelvin = quantity("K", 200.0, 3000.0)
Time = quantity("s", 0.0, 10.0)


class TankTable(Strict):
    """The tank and the gas in it at the start."""

    volume: volume_within(1e-4, 10.0)
    pressure: quantity("Pa", 0.0, 1e7) = 101325.0
    temperature: quantity("K", 200.0, 400.0) = 295.0
    gas: Fractions = Field(default_factory=lambda: dict(AIR))
    wall_area: quantity("m^2", 0.0, 100.0) = 0.0
    heat_transfer: quantity("W/(m^2 K)", 0.0, 1e4) = 0.0
    wall_temperature: quantity("K", 200.0, 1000.0) | None = None


class InflatorTable(Strict):
    """The gas source: complete to predict a test, as far as known to evaluate one."""

    gas: Fractions
    mass_flow: curve("kg/s", 0.0, 100.0) | None = None
    temperature: Kelvin | curve("K", 200.0, 3000.0) | None = None
    total_mass: quantity("kg", 1e-5, 10.0) | None = None
    delay: Time = 0.0


class Measurement(Strict):
    """How a trace was measured; uncertainties are half-widths at 95 %."""

    pressure: Literal["absolute", "gauge"] | None = None
    ambient_pressure: quantity("Pa", 1e3, 1e6) = 101325.0
    end_time: Time | None = None
    temperature_uncertainty: quantity("K", 0.0, 1000.0) = 0.0
    volume_uncertainty: volume_within(0.0, 1.0) = 0.0
    mass_uncertainty: quantity("kg", 0.0, 1.0) = 0.0


class Forward(Strict):
    """Times of a prediction."""

    end_time: quantity("s", 1e-4, 10.0) = 0.1
    step: quantity("s", 1e-6, 0.1) = 1e-4


class TankCase(Strict):
    """A tank test."""

    title: Text = "Tank test"
    tank: TankTable
    inflator: InflatorTable
    measurement: Measurement = Measurement()
    forward: Forward = Forward()

    @classmethod
    def load(cls, path: str | Path) -> TankCase:
        """From a TOML file. Raises InputError E-TANK-001 (no TOML) and those of `from_dict`."""
        try:
            data = read_toml(path)
        except (OSError, ValueError) as error:
            raise UNREADABLE(where=path, why=error) from None
        return cls.from_dict(data, str(path))

    @classmethod
    def from_dict(cls, data: dict[str, Any], where: str = "tank case") -> TankCase:
        """From nested dictionaries.

        Raises InputError: E-TANK-002 (a key or value), E-TANK-003 (unknown gas), E-TANK-004 (fractions).
        """
        try:
            case = cls.model_validate(data)
        except ValidationError as error:
            raise _explain(error, where) from None
        for key, shares in (("tank.gas", case.tank.gas), ("inflator.gas", case.inflator.gas)):
            place, total = f"{where}, key {key}", sum(shares.values())
            unknown = [name for name in shares if name not in SPECIES]
            if unknown:
                raise UNKNOWN_GAS(where=place, name=shown(unknown[0]), known=", ".join(SPECIES))
            if abs(total - 1.0) > 1e-6:
                raise SHARES_OTHER_THAN_ONE(where=place, total=total)
        return case

    def make_tank(self, volume_change: float = 0.0) -> Tank:
        """The tank, its volume changed by [m^3]."""
        tank = self.tank
        return make_tank(
            tank.volume + volume_change,
            *(tank.pressure, tank.temperature, tank.gas, self.inflator.gas),
            tank.heat_transfer * tank.wall_area,
            tank.wall_temperature,
        )

    @property
    def inflow_temperature(self) -> InflowTemperature | None:
        """Total temperature of the inflow, if it is given."""
        given = self.inflator.temperature
        if given is None or isinstance(given, float):
            return None if given is None else InflowTemperature.constant(given)
        return InflowTemperature(np.array(given.time) + self.inflator.delay, np.array(given.value))


def _explain(error: ValidationError, where: str) -> InputError:
    problems = error.errors(include_url=False)
    # Of a union every branch complains; the branch that got furthest speaks for it.
    problem = max(
        problems,
        key=lambda p: (p["type"] in ("range", "unit", "curve") and not isinstance(p["input"], dict), len(p["loc"])),
    )
    key = ".".join(str(part) for part in problem["loc"] if "[" not in str(part) and part != "float")
    if problem["type"] == "missing":
        names = missing_beside(problem, problems)
        what = f"{listed(names)} {'are' if len(names) > 1 else 'is'} missing"
        return UNUSABLE_KEY(what=what, place=where, key=key, why="there is no default")
    why = "no setting has this name" if problem["type"] == "extra_forbidden" else reason_of(problem)
    return UNUSABLE_KEY(place=where, key=key, why=why, remedy=(problem.get("ctx") or {}).get("try"))
