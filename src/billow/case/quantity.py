"""Field types of the case schema: numbers with a unit and a plausible range, whole numbers, curves, names, titles."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, Discriminator, Tag, create_model, model_validator
from pydantic_core import PydanticCustomError

from billow.base.attribute_docstrings import described
from billow.base.units import CONVERSIONS, in_unit, other_scales

ZERO_CELSIUS = 273.15  # K


MOST_TABLES = 1000
"""Obstacles, straps, sensors and the like of one case; each has arrays as long as the mesh, or columns of its own."""


class Strict(BaseModel, extra="forbid", frozen=True, allow_inf_nan=False, validate_default=True):
    """Unknown keys are refused, values never change, numbers are finite, lists of tables have an end."""

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: Any) -> dict[str, Any]:
        return described(cls, handler(core_schema), handler)

    chooser: ClassVar[str] = "shape"
    """The key that chooses this table among others, if it has one of that name."""

    @model_validator(mode="before")
    @classmethod
    def _bounded(cls, data: Any) -> Any:
        for key, items in data.items() if isinstance(data, dict) else ():
            if isinstance(items, (list, tuple)) and len(items) > MOST_TABLES and isinstance(items[0], dict):
                raise refused(f"{len(items)} tables {key}; at most {MOST_TABLES} are allowed, to fit into memory")
        return data


def refused(reason: str, remedy: str | None = None, kind: str = "value") -> PydanticCustomError:
    """What a validator raises; reason and remedy become the lines "why" and "try" of the message."""
    return PydanticCustomError(kind, "{reason}", {"reason": reason, "try": remedy})


_REASONS = {
    "string_type": "a text in quotes is expected",
    "int_type": "a whole number is expected",
    "int_parsing": "a whole number is expected",
    "int_from_float": "a whole number is expected",
    "int_parsing_size": "the number is too large",
    "float_type": "a number is expected",
    "float_parsing": "a number is expected",
    "finite_number": "the number is not finite",
    "bool_type": "true or false is expected",
    "bool_parsing": "true or false is expected",
    "dict_type": "a table is expected",
    "model_type": "a table is expected",
    "model_attributes_type": "a table is expected",
    "tuple_type": "a list is expected",
    "list_type": "a list is expected",
}
"""pydantic's name of a problem -> its reason in the words of this program."""


def reason_of(problem: Mapping[str, Any]) -> str:
    """Why a value was refused, from an entry of a ValidationError."""
    return _REASONS.get(problem["type"], problem["msg"].replace("Input should", "it should"))


def listed(names: Sequence[str]) -> str:
    """Names in a sentence: a, b and c."""
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]


def missing_beside(problem: Mapping[str, Any], problems: Sequence[Mapping[str, Any]]) -> list[str]:
    """All keys that are missing in the table in which `problem` misses one, at most twenty."""
    table = problem["loc"][:-1]
    return [str(p["loc"][-1]) for p in problems if p["type"] == "missing" and p["loc"][:-1] == table][:20]


def quantity(unit: str, low: float, high: float) -> Any:
    """A number kept in `unit`; text with a unit is converted; values outside low..high are refused as implausible."""

    def convert(value):
        try:
            return in_unit(value, unit)
        except ValueError as error:
            raise refused(str(error), kind="unit") from None

    def check(value: float) -> float:
        if low <= value <= high:
            return value
        reason = f"{value:g} {unit} is outside the plausible range {low:g} to {high:g} {unit}"
        raise refused(reason, _meant(value, unit, low, high), kind="range")

    return Annotated[float, BeforeValidator(convert), AfterValidator(check), Documented(unit, low, high)]


def whole(low: int, high: int, noun: str = "") -> Any:
    """A whole number from low to high; noun: what it counts, for messages."""

    def plain(value: Any) -> Any:
        if isinstance(value, bool):  # which Python counts among the whole numbers
            raise refused("a whole number is expected, not true or false", kind="range")
        return value

    def check(value: int) -> int:
        if low <= value <= high:
            return value
        given = str(value) if abs(value) < 10**18 else f"{value:.3g}" if abs(value) < 10**300 else "a huge number"
        raise refused(f"{given}{noun and ' '}{noun}; expected {low} to {high}", kind="range")

    return Annotated[int, BeforeValidator(plain), AfterValidator(check), Documented("", low, high)]


def _meant(value: float, unit: str, low: float, high: float) -> str | None:
    """What to write if the number was in another unit, or None."""
    if unit == "K" and low <= value + ZERO_CELSIUS <= high:
        return f"write {value + ZERO_CELSIUS:g} if {value:g} degrees Celsius are meant"
    readings = [f'"{text}"' for text in other_scales(value, unit, low, high)] if value > 0.0 else []
    return f"write {' or '.join(readings)} if that is meant" if readings else None


@dataclass(frozen=True)
class Documented:
    """Unit and range of a number, kept in the field's metadata for the generated reference; a count has no unit."""

    unit: str
    low: float
    high: float

    def __get_pydantic_json_schema__(self, core_schema: Any, handler: Callable[[Any], dict]) -> dict[str, Any]:
        """Number in its range, or text with a unit."""
        number = {**handler(core_schema), "minimum": self.low, "maximum": self.high}
        return {"anyOf": [number, {"type": "string"}]} if self.unit else number


def unit_of(field) -> Documented | None:
    """Unit and range of a pydantic field, if it is a quantity."""
    return next((m for m in field.metadata if isinstance(m, Documented) and m.unit), None)


_pressure = ("Pa", quantity("Pa", -1e6, 1e7))
AXES = {
    "time": ("s", quantity("s", 0.0, 10.0)),
    "pressure": _pressure,
    "gauge_pressure": _pressure,
    "loading_rate": ("N/m/s", quantity("N/m/s", 0.0, 1e12)),
}
"""What curves run against: its unit, and the type of its points."""


def curve(unit: str, low: float, high: float, axis: str = "time") -> Any:
    """A piecewise linear curve against time or pressure: {time = [s, ...], value = [unit, ...]}."""
    axis_unit, axis_type = AXES[axis]

    def check(self):
        points, value = getattr(self, axis), self.value
        if len(points) < 2:
            raise refused(f"a curve needs at least two points; this one has {len(points)}", kind="curve")
        if len(points) != len(value):
            reason = f"{axis} has {len(points)} points and value has {len(value)}; they must be equally many"
            raise refused(reason, kind="curve")
        for before, after in itertools.pairwise(points):
            if after <= before:
                reason = f"{axis}s must increase; {after} {axis_unit} follows {before} {axis_unit}"
                raise refused(reason, kind="curve")
        return self

    return create_model(
        f"Curve[{unit}]" if axis == "time" else f"Curve[{unit}, against {axis}]",
        __base__=Strict,
        __validators__={"check": model_validator(mode="after")(check)},
        **{axis: (tuple[axis_type, ...], ...), "value": (tuple[quantity(unit, low, high), ...], ...)},
    )


def number_or_curve(unit: str, low: float, high: float, *axes: str) -> Any:
    """A number, or a curve against one of the axes."""

    def written_as(value: Any) -> str:
        keys = value if isinstance(value, dict) else getattr(type(value), "model_fields", ())
        if not keys and not isinstance(value, dict):
            return "written[number]"
        return f"written[{next((axis for axis in reversed(axes) if axis in keys), axes[0])}]"

    choices = [Annotated[quantity(unit, low, high), Tag("written[number]")]]  # names of branches that stand in no key
    choices += [Annotated[curve(unit, low, high, axis), Tag(f"written[{axis}]")] for axis in axes]
    return Annotated[reduce(or_, choices), Discriminator(written_as)]


def chosen_by(key: str, tables: dict[str, type[Strict]], default: str | None = None) -> Any:
    """One of several tables, chosen by one of its keys, `shape` or `kind`."""

    def known(value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        if default and key not in value:
            return {key: default, **value}
        given = value.get(key)
        if given not in tuple(tables):
            missing = f"its {key} is no text" if key in value else f"it has no {key}"
            reason = f"there is no {key} {given[:40]!r}" if isinstance(given, str) else missing
            raise refused(reason, f"write {' or '.join(f'{key} = {name!r}' for name in tables)}")
        return value

    return Annotated[reduce(or_, tables.values()), Discriminator(key), BeforeValidator(known)]


def distinct(kind: str, remedy: str | None = None) -> Callable[[Any], Any]:
    """A validator that refuses two items of one name in a list."""

    def check(items):
        names = [item.name for item in items] if isinstance(items, tuple) else []
        if len(set(names)) != len(names):
            raise refused(f"two {kind} are called {max(names, key=names.count)}", remedy)
        return items

    return check


def _plain_name(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,39}", value):
        raise refused(
            "names head columns of histories.csv and lead to settings",
            "use letters, digits, - and _ (at most 40), a letter first",
        )
    return value


def _one_line(value: str) -> str:
    if not value.isprintable():
        raise refused("it holds a line break or a control character", "use plain text in one line")
    return value


def unit_of_length(value: str) -> str:
    """A validator of names of units of length."""
    if value not in CONVERSIONS["m"]:
        raise refused("it is no unit of length", f"use one of {', '.join(CONVERSIONS['m'])}", kind="unit")
    return value


Name = Annotated[str, AfterValidator(_plain_name)]
Text = Annotated[str, AfterValidator(_one_line)]
