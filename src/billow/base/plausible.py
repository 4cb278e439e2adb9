"""What sizes, pressures, temperatures, masses and times of airbags are like: one table, of which every input is asked
that no schema bounds, and every concern about a probable slip of the unit.

Outside `possible` a value is refused; outside `usual` it is a concern. Ranges in the schema of a case refuse the
impossible where it is written; they are about as wide as `possible`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from billow.base.errors import Concern, InputError
from billow.base.units import CONVERSIONS

IMPOSSIBLE = InputError.declare(
    "E-UNIT-001",
    "{thing} is {value:.4g} {unit}",
    why="{kind}: possible are {low:g} to {high:g} {unit}",
    cause="a file or a number in another unit",
    remedy="check the numbers and their unit",
)
UNUSUAL = Concern.declare(
    "W-UNIT-001",
    "{thing} is {value:.4g} {unit}",
    why="{kind}: usual are {low:g} to {high:g} {unit}",
    cause="a file or a number in another unit",
    remedy="check the numbers and their unit",
)


class Plausible(NamedTuple):
    """unit; possible and usual: (low, high) in it."""

    unit: str
    possible: tuple[float, float]
    usual: tuple[float, float]


TABLE = {
    "bag size": Plausible("m", (5e-3, 50.0), (0.03, 8.0)),
    "speed of sound in fabric": Plausible("m/s", (0.0, float("inf")), (100.0, 4000.0)),
    "weight of fabric": Plausible("kg/m^2", (0.0, float("inf")), (0.05, 2.0)),
    "ambient pressure": Plausible("Pa", (1e3, 1e6), (2e4, 2e5)),
    "opening pressure": Plausible("Pa", (0.0, 1e7), (100.0, 500e3)),
    "density of a body": Plausible("kg/m^3", (0.0, float("inf")), (5.0, 20e3)),
    "speed of a body": Plausible("m/s", (0.0, 100.0), (0.0, 30.0)),
    "duration of a trace": Plausible("s", (1e-4, 60.0), (1e-3, 10.0)),
    "peak pressure of a trace": Plausible("Pa", (1e3, 1e8), (1e5, 1e7)),
    "duration of a run": Plausible("s", (1e-5, 10.0), (1e-3, 1.0)),
}
"""What is asked of each quantity. Usual are bags from curtain cushions to landing bags, surroundings from 10 km height
to a pressure chamber; 30 m/s is a crash at 108 km/h."""


def is_usual(kind: str, value: float) -> bool:
    low, high = TABLE[kind].usual
    return low <= value <= high


def require_possible(kind: str, value: float, thing: str, where: str, change: str, written: str | None = None) -> None:
    """Refuse a value that cannot be, InputError E-UNIT-001.

    thing: how the message calls it. change: what to do if {unit} was meant. written: the unit in which it was given.
    """
    unit, (low, high), _ = TABLE[kind]
    if not low <= value <= high:
        remedy = _remedy(kind, value, change, written)
        raise IMPOSSIBLE(kind=kind, thing=thing, value=value, unit=unit, low=low, high=high, where=where, remedy=remedy)


def unusual(
    kind: str, value: float, thing: str, where: str, change: str, written: str | None = None
) -> Iterator[Concern]:
    """The concern about a value, W-UNIT-001, if it is not usual; arguments as above."""
    unit, _, (low, high) = TABLE[kind]
    if not is_usual(kind, value):
        remedy = _remedy(kind, value, change, written)
        yield UNUSUAL(kind=kind, thing=thing, value=value, unit=unit, low=low, high=high, where=where, remedy=remedy)


def _remedy(kind: str, value: float, change: str, written: str | None) -> str | None:
    """With the unit that brings the number closest to the middle of what is usual; None if no unit makes it usual."""
    unit, _, (low, high) = TABLE[kind]
    factors = CONVERSIONS[unit]
    written = written or unit
    number, middle = value / factors[written], math.sqrt(max(low, 1e-3 * high) * high)
    likely = [name for name, factor in factors.items() if name != written and low <= number * factor <= high]
    if not likely or not number > 0.0:
        return None
    name = min(likely, key=lambda name: abs(math.log(number * factors[name] / middle)))
    return f"it looks like {number:.4g} {name}: {change.format(unit=name)}"
