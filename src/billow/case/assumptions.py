"""What a case takes from Billow where a measurement belongs: typical values, named by check, log and saved case.

A value counts as taken from Billow if it is the default, whether it was left out or written: nobody has measured it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from billow.case.fabric.schema_fabric import LAWS
from billow.case.gas.models import GAS_MODELS
from billow.case.quantity import unit_of
from billow.case.schema import Case

OF_FABRIC = ("density", "thickness")
OF_LAW = {"moduli": ("young_warp", "young_weft", "poisson", "shear"), "curves": ()}
OF_INFLATOR = ("gas", "mass_flow", "temperature")
OF_OBSTACLE = ("slope", "friction", "damping")
HEADING = "typical values, not measured for this case"


def assumptions(case: Case) -> list[str]:
    """A line for each table of the case: which of its values stand for a measurement and are Billow's own."""
    return [f"{table}: {', '.join(named)}" for table, named in _found(case) if named]


def header(case: Case) -> str:
    """The same as comments, for the top of a saved case."""
    return "".join(f"# {line}\n" for line in [f"{HEADING}:", *assumptions(case)] if assumptions(case))


def _found(case: Case) -> Iterator[tuple[str, list[str]]]:
    gas = GAS_MODELS[case.gas.model].has_supply
    of_parts = [(f"fabric.parts.{part}", fabric) for part, fabric in case.fabric.parts.items()]
    for key, fabric in [("fabric", case.fabric), *of_parts]:
        of_law = LAWS[fabric.law]
        named = _defaults(fabric, *OF_FABRIC, *OF_LAW[of_law])
        leakage = case.leakage.parts.get(key.rpartition(".")[2], case.leakage)
        if gas and leakage.law == "permeability" and fabric.coating.thickness == 0.0:
            named += _defaults(fabric, "permeability")
        yield key, named
        if of_law == "curves" and fabric.from_library:
            yield f"{key}.curves", [*fabric.from_library[:-1], f"{fabric.from_library[-1]} from {fabric.library}"]
    if case.bag.shape == "mesh" and not case.bag.reference:
        yield "bag", ["warp along the x axis of space, since no bag.reference says how the fabric was cut"]
    if gas:
        for inflator in case.inflators:
            key = f"inflator.{inflator.name}" if isinstance(case.inflator, tuple) else "inflator"
            yield key, _defaults(inflator, *OF_INFLATOR)
        if _has_vents(case.bag):
            yield "bag.vents", _defaults(case.bag.vents, "discharge")
        yield "gas", _defaults(case.gas, "heat_transfer", *(["opening_discharge"] if _has_openings(case.bag) else []))
        for orifice in case.gas.orifices:
            yield f"gas.orifices.{orifice.name}", _defaults(orifice, "discharge")
    for obstacle in case.obstacles:
        more = [] if getattr(obstacle, "locked", True) else ["mass"]
        yield f"obstacles.{obstacle.name}", _defaults(obstacle, *OF_OBSTACLE, *more)


def _defaults(table: Any, *keys: str) -> list[str]:
    """Those keys of a table that have their default, with it where it is a number."""
    found = []
    for key in keys:
        value, field = getattr(table, key), type(table).model_fields[key]
        if value == field.get_default(call_default_factory=True):
            unit = unit_of(field)
            found.append(f"{key} = {value:g}{f' {unit.unit}' if unit and unit.unit != '-' else ''}" if unit else key)
    return found


def _has_vents(bag: Any) -> bool:
    if bag.shape == "mesh":
        return any(part.kind == "vent" for part in bag.parts)
    return bool(getattr(bag.vents, "chambers", ()) or getattr(bag.vents, "count", 0))


def _has_openings(bag: Any) -> bool:
    if bag.shape == "mesh":
        return any(part.kind == "opening" for part in bag.parts)
    return bag.shape == "window" or (bag.shape == "rectangular" and bag.chambers > 1)
