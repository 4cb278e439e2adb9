"""Case dictionaries that nobody would write, generated from the schema itself, so that no key is forgotten."""

from __future__ import annotations

import copy
import math
import types
import typing
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st

from billow.base.units import CONVERSIONS
from billow.case import schema
from billow.case.bag import schema_bag
from billow.case.gas import schema_gas
from billow.case.obstacles.obstacles import OBSTACLES
from billow.case.quantity import Strict, unit_of

EXAMPLE: dict[str, Any] = {
    "title": "Generated",
    "bag": {"element_size": 0.05, "vents": {}, "straps": {}},
    "fabric": {"permeability": 0.0275},
    "gas": {},
    "inflator": {
        "gas": {"N2": 0.45, "H2O": 0.30, "CO2": 0.25},
        "mass_flow": {"time": [0.0, 0.002, 0.008], "value": [0.0, 12.5, 0.0]},
        "jets": {},
    },
    "ambient": {},
    "obstacles": [
        {"shape": "plate"},
        {"shape": "super-ellipsoid", "clearance": 0.05, "locked": False},
        {"shape": "box", "size": [0.2, 0.2, 0.1], "place": [0.0, 0.0, 0.9]},
        {"shape": "cylinder", "place": [0.0, 0.0, 1.5]},
        {"shape": "housing", "inner": [0.3, 0.3], "depth": 0.05, "place": [0.0, 0.0, 1.2]},
    ],
    "run": {"end_time": 0.002, "frames": 2, "histories_per_frame": 2},
}
"""A sound case of 612 triangles that takes a tenth of a second. An obstacle from a mesh needs a file: meshes
have inputs of their own."""

NUMBERS = [0, -1, 1, 1e-300, -1e300, 1e308, math.inf, -math.inf, math.nan, 10**30, 10**5000, True]
TEXTS = ["", " ", "1", "0.3 mm", "1e999 m", "-0 %", "1 furlong", "nan", "0x10", "١٢ m", "1" * 300, "\x00", "a\nb", "😀"]
JUNK = st.one_of(
    st.sampled_from(NUMBERS),
    st.sampled_from(TEXTS),
    st.none(),
    st.integers(),
    st.floats(),
    st.text(max_size=20),
    st.binary(max_size=8),
    st.recursive(
        st.one_of(st.none(), st.floats(), st.text(max_size=8)),
        lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=8), inner, max_size=4)),
        max_leaves=8,
    ),
)


def fields(model: type[Strict] = schema.Case, path: tuple[str | int, ...] = ()) -> Iterator[tuple[tuple, Any]]:
    """Path and pydantic field of every setting, bag and obstacles as they stand in `EXAMPLE`."""
    for name, field in model.model_fields.items():
        if name == "obstacles":
            for k, table in enumerate(EXAMPLE["obstacles"]):
                yield from fields(OBSTACLES[table["shape"]], (*path, name, k))
        elif name == "bag":
            yield from fields(schema_bag.DriverBag, (*path, name))
        elif name == "inflator":
            yield from fields(schema_gas.Inflator, (*path, name))
        elif isinstance(field.annotation, type) and issubclass(field.annotation, Strict) and not _is_curve(field):
            yield from fields(field.annotation, (*path, name))
        else:
            yield (*path, name), field


def _is_curve(field) -> bool:
    return getattr(field.annotation, "__name__", "").startswith("Curve")


def ranges(annotation: Any) -> Iterator[tuple[str, float, float]]:
    """Unit and range of every quantity in a type."""
    own = unit_of(types.SimpleNamespace(metadata=getattr(annotation, "__metadata__", ())))
    if own is not None:
        yield own.unit, own.low, own.high
    for part in typing.get_args(annotation):
        yield from ranges(part)


def mostly(common: st.SearchStrategy, rare: st.SearchStrategy) -> st.SearchStrategy:
    """Nine of ten values from `common`; `one_of` alone would draw both equally often."""
    return st.integers(0, 9).flatmap(lambda draw: rare if draw == 9 else common)


def quantity_values(unit: str, low: float, high: float) -> st.SearchStrategy:
    """Numbers in a range, at its ends, just outside, and texts with a unit that may or may not fit."""
    inside = st.floats(low, high)
    ends = st.sampled_from([low, high, math.nextafter(low, -math.inf), math.nextafter(high, math.inf)])
    with_unit = st.builds("{:.6g} {}".format, inside, st.sampled_from([*CONVERSIONS[unit], "furlong"]))
    return mostly(inside, st.one_of(ends, with_unit))


def curves(unit: str = "kg/s", low: float = 0.0, high: float = 100.0) -> st.SearchStrategy:
    """Curves: mostly increasing times, lengths that may differ, now and then no lists at all."""
    times = st.one_of(
        st.lists(quantity_values("s", 0.0, 10.0), max_size=6),
        st.lists(st.floats(0.0, 0.1), min_size=2, max_size=6, unique=True).map(sorted),
    )
    values = st.lists(quantity_values(unit, low, high), max_size=6)
    paired = times.flatmap(
        lambda t: st.tuples(st.just(t), st.lists(st.floats(low, high), min_size=len(t), max_size=len(t)))
    )
    return st.one_of(
        paired.map(lambda pair: {"time": pair[0], "value": pair[1]}),
        st.fixed_dictionaries({"time": times, "value": values}),
        st.dictionaries(st.sampled_from(["time", "value", "times"]), JUNK, max_size=3),
    )


def _values_of(path: tuple, field: Any) -> st.SearchStrategy:
    """Values for one setting: most are sound, some are junk."""
    own = unit_of(field)
    quantities = [(own.unit, own.low, own.high)] if own else list(ranges(field.annotation))
    if path[-1] == "mass_flow":
        sound = curves()
    elif path[-1] == "gas":
        sound = st.dictionaries(st.sampled_from(["N2", "O2", "H2O", "He", "Xx"]), st.floats(0.0, 1.0), max_size=4)
    elif typing.get_origin(field.annotation) is tuple:
        sound = st.tuples(*(quantity_values(*q) for q in quantities)).map(list)
    elif path[-1] == "radii":
        sound = st.one_of(quantity_values(*quantities[0]), st.lists(quantity_values(*quantities[0]), max_size=4))
    elif path[-2:] == ("inflator", "temperature"):
        sound = st.one_of(quantity_values(*quantities[0]), curves("K", 200.0, 3000.0))
    elif quantities:
        sound = quantity_values(*quantities[0])
    elif field.annotation is bool:
        sound = st.booleans()
    elif field.annotation is int:
        sound = st.one_of(st.integers(0, 12), st.integers(-2, 20_000))
    else:
        sound = st.one_of(
            st.sampled_from([*typing.get_args(field.annotation), "plate", "driver"]), st.text(max_size=30)
        )
    return mostly(sound, JUNK)


SETTINGS = {path: _values_of(path, field) for path, field in fields()}


@st.composite
def case_dictionaries(draw) -> dict[str, Any]:
    """The example with up to five settings replaced."""
    data = copy.deepcopy(EXAMPLE)
    for path in draw(st.lists(st.sampled_from(list(SETTINGS)), min_size=1, max_size=5, unique=True)):
        place = data
        for part in path[:-1]:
            place = place[part] if isinstance(place, list) else place.setdefault(part, {})
        place[path[-1]] = draw(SETTINGS[path])
    return data
