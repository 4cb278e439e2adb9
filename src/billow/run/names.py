"""Names of what has columns in the histories: checked once, for everything in a case, before a run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from billow.base.errors import InputError
from billow.parts.part import WHOLE_MODEL, Owner
from billow.solver.model import Model

TAKEN = InputError.declare(
    "E-CASE-007",
    "{first} and {second} share a name",
    where="{keys}",
    why="{why}",
    cause="two things of a case that were named alike; capitals do not tell names apart",
    remedy="give one of them another name",
)

SENSOR = ("gas_pressure", "gas_temperature", "gas_density", "gas_velocity")
"""What a sensor writes."""

KEYS = {
    "vent": "bag", "fabric part": "bag", "opening": "bag", "chamber": "bag", "strap": "bag.straps",
    "orifice": "gas.orifices", "obstacle": "obstacles", "free obstacle": "obstacles", "moved obstacle": "obstacles",
    "guided obstacle": "obstacles", "tear seam": "bag.tear_seams", "sensor": "run.sensors",
    "group of nodes": "nodes",
}  # fmt: skip
"""Kind of owner -> where a case names it."""

SAME_CLOTH = {"chamber", "fabric part"}
"""A part of the fabric may be called like the chamber behind it."""


def owners(model: Model, sensors: Iterable[str] = ()) -> Iterator[Owner]:
    """Everything that has columns in the histories of a run; sensors: their names."""
    ledger = tuple(account.name for account in model.accounts)
    yield Owner(WHOLE_MODEL, "", ("time", "dt", *ledger, "energy_residual"))
    for _, part in model.parts:
        yield from part.owners()
    if model.gas.model.view() is not None:
        yield from (Owner("sensor", name, SENSOR) for name in sensors)


def require_distinct(found: Iterable[Owner]) -> None:
    """Raises InputError E-CASE-007 if two owners share a name or a column; letters count the same in upper and lower
    case, since not every program that reads the columns tells them apart."""
    names, columns = {}, {}
    for one in found:
        other = names.setdefault(one.name.casefold(), one)
        if one.name and other is not one and {one.kind, other.kind} != SAME_CLOTH:
            raise _taken(other, one, f"their columns of histories.csv would begin alike, with {one.name}_")
        for quantity in one.quantities:
            column = f"{one.name}_{quantity}" if one.name else quantity
            other = columns.setdefault(column.casefold(), one)
            if other is not one and one.name:
                raise _taken(other, one, f"both would write the column {column} of histories.csv")


def _taken(first: Owner, second: Owner, why: str) -> InputError:
    keys = dict.fromkeys(KEYS[owner.kind] for owner in (first, second) if owner.name)
    return TAKEN(first=_told(first), second=_told(second), keys=", ".join(keys), why=why)


def _told(owner: Owner) -> str:
    return f"the {owner.kind} {owner.name}" if owner.name else owner.kind
