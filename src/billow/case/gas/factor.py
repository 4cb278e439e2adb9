"""Field types for factors: a number, a curve against time, or a curve against pressure."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Tag, model_validator

from billow.case.quantity import Strict, curve, quantity, require_curve

NUMBER, TIME, PRESSURE = "written[number]", "written[time]", "written[pressure]"
"""What a factor was written as; names of branches that stand in no key."""


def _written_as(value: Any) -> str:
    keys = value if isinstance(value, dict) else getattr(type(value), "model_fields", ())
    return PRESSURE if "pressure" in keys else TIME if keys or isinstance(value, dict) else NUMBER


def pressure_curve(unit: str, low: float, high: float) -> Any:
    """A piecewise linear curve against pressure: {pressure = [Pa, ...], value = [unit, ...]}."""
    value_type, pressure_type = quantity(unit, low, high), quantity("Pa", -1e6, 1e7)

    class Curve(Strict):
        pressure: tuple[pressure_type, ...]
        value: tuple[value_type, ...]

        @model_validator(mode="after")
        def _check(self):
            require_curve("pressure", "Pa", self.pressure, self.value)
            return self

    Curve.__name__ = Curve.__qualname__ = f"Curve[{unit}, against pressure]"
    return Curve


def over_time(unit: str, low: float, high: float) -> Any:
    """A number or a curve against time."""
    number, time = Annotated[quantity(unit, low, high), Tag(NUMBER)], Annotated[curve(unit, low, high), Tag(TIME)]
    return Annotated[number | time, Discriminator(lambda v: NUMBER if _written_as(v) == NUMBER else TIME)]


def over_pressure(unit: str, low: float, high: float) -> Any:
    """A number or a curve against pressure."""
    number = Annotated[quantity(unit, low, high), Tag(NUMBER)]
    pressure = Annotated[pressure_curve(unit, low, high), Tag(PRESSURE)]
    return Annotated[number | pressure, Discriminator(lambda v: NUMBER if _written_as(v) == NUMBER else PRESSURE)]


def over_either(unit: str, low: float, high: float) -> Any:
    """A number, a curve against time, or a curve against pressure."""
    number, time = Annotated[quantity(unit, low, high), Tag(NUMBER)], Annotated[curve(unit, low, high), Tag(TIME)]
    pressure = Annotated[pressure_curve(unit, low, high), Tag(PRESSURE)]
    return Annotated[number | time | pressure, Discriminator(_written_as)]
