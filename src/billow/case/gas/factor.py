"""Field types for factors: a number, a curve against time, or a curve against pressure."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from billow.case.quantity import curve, quantity

NUMBER, TIME, PRESSURE = "written[number]", "written[time]", "written[pressure]"
"""What a factor was written as; names of branches that stand in no key."""


def _written_as(value: Any) -> str:
    keys = value if isinstance(value, dict) else getattr(type(value), "model_fields", ())
    return PRESSURE if "pressure" in keys else TIME if keys or isinstance(value, dict) else NUMBER


def over_time(unit: str, low: float, high: float) -> Any:
    """A number or a curve against time."""
    number, time = Annotated[quantity(unit, low, high), Tag(NUMBER)], Annotated[curve(unit, low, high), Tag(TIME)]
    return Annotated[number | time, Discriminator(lambda v: NUMBER if _written_as(v) == NUMBER else TIME)]


def over_pressure(unit: str, low: float, high: float) -> Any:
    """A number or a curve against pressure."""
    number = Annotated[quantity(unit, low, high), Tag(NUMBER)]
    pressure = Annotated[curve(unit, low, high, "pressure"), Tag(PRESSURE)]
    return Annotated[number | pressure, Discriminator(lambda v: NUMBER if _written_as(v) == NUMBER else PRESSURE)]


def over_either(unit: str, low: float, high: float) -> Any:
    """A number, a curve against time, or a curve against pressure."""
    number, time = Annotated[quantity(unit, low, high), Tag(NUMBER)], Annotated[curve(unit, low, high), Tag(TIME)]
    pressure = Annotated[curve(unit, low, high, "pressure"), Tag(PRESSURE)]
    return Annotated[number | time | pressure, Discriminator(_written_as)]
