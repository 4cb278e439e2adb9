"""Field types of the case schema: numbers with a unit and a plausible range, curves against time."""

from __future__ import annotations

import itertools
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, model_validator
from pydantic_core import PydanticCustomError

from billow.base.units import other_scales, to_si

ZERO_CELSIUS = 273.15  # K


class Strict(BaseModel):
    """Unknown keys are refused, values never change, numbers are finite."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True, validate_default=True
    )


def quantity(unit: str, low: float, high: float) -> Any:
    """A number kept in `unit`; text with a unit is converted; values outside low..high are refused as implausible."""

    def convert(value):
        try:
            return to_si(value, unit)
        except ValueError as error:
            raise PydanticCustomError("unit", "{reason}", {"reason": str(error)}) from None

    def check(value: float) -> float:
        if low <= value <= high:
            return value
        reason = f"{value:g} {unit} is outside the plausible range {low:g} to {high:g} {unit}"
        raise PydanticCustomError("range", "{reason}", {"reason": reason, "try": _meant(value, unit, low, high)})

    return Annotated[float, BeforeValidator(convert), AfterValidator(check), _Documented(unit, low, high)]


def _meant(value: float, unit: str, low: float, high: float) -> str | None:
    """What to write if the number was in another unit, or None."""
    if unit == "K" and low <= value + ZERO_CELSIUS <= high:
        return f"write {value + ZERO_CELSIUS:g} if {value:g} degrees Celsius are meant"
    readings = [f'"{text}"' for text in other_scales(value, unit, low, high)] if value > 0.0 else []
    return f"write {' or '.join(readings)} if that is meant" if readings else None


class _Documented:
    """Unit and range, kept in the field's metadata for the generated reference."""

    def __init__(self, unit: str, low: float, high: float):
        self.unit, self.low, self.high = unit, low, high


def unit_of(field) -> _Documented | None:
    """Unit and range of a pydantic field, if it is a quantity."""
    return next((m for m in field.metadata if isinstance(m, _Documented)), None)


def curve(unit: str, low: float, high: float) -> Any:
    """A piecewise linear curve against time: {time = [s, ...], value = [unit, ...]}."""
    value_type = quantity(unit, low, high)
    time_type = quantity("s", 0.0, 10.0)

    class Curve(Strict):
        time: tuple[time_type, ...]
        value: tuple[value_type, ...]

        @model_validator(mode="after")
        def _check(self):
            require_curve("time", "s", self.time, self.value)
            return self

    Curve.__name__ = Curve.__qualname__ = f"Curve[{unit}]"
    return Curve


def require_curve(axis: str, unit: str, points: tuple[float, ...], value: tuple[float, ...]) -> None:
    """Refuse a curve of fewer than two points, of lists of different length, or whose axis does not increase."""
    if len(points) < 2:
        raise PydanticCustomError("curve", "a curve needs at least two points; this one has {n}", {"n": len(points)})
    if len(points) != len(value):
        raise PydanticCustomError(
            "curve",
            "{axis} has {n} points and value has {m}; they must be equally many",
            {"axis": axis, "n": len(points), "m": len(value)},
        )
    for before, after in itertools.pairwise(points):
        if after <= before:
            raise PydanticCustomError(
                "curve",
                "{axis}s must increase; {after} {unit} follows {before} {unit}",
                {"axis": axis, "unit": unit, "after": after, "before": before},
            )
