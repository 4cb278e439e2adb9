"""What decks of all programs share on their way to a case: the choices of the command, and tables that no card says."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from billow.base.errors import InputError
from billow.decks.bag_mesh import BagMesh
from billow.decks.context import Context
from billow.decks.draft import Said
from billow.decks.fabric import birth_time

NO_AIRBAG = InputError.declare(
    "E-DCK-017",
    "the deck does not say {what}",
    where="{place}",
    cause="a deck of a mesh alone, or a file that is not included",
    remedy="take what is missing from a case: --base CASE.toml",
)

BASE_TABLES = ("fabric", "gas", "leakage", "inflator", "ambient")


@dataclass
class Options:
    """What the command says beside the deck. parts: number -> kind; close: number of an open edge -> kind; merge: [m];
    base: case that gives what the deck lacks; measure: what curves of fabric measure."""

    units: str = "auto"
    airbag: int | None = None
    parts: dict[int, str] = field(default_factory=dict)
    close: dict[int, str] = field(default_factory=dict)
    merge: float | None = None
    base: Path | None = None
    measure: str = "true"
    allow_outside: bool = False


def rest_of_base(context: Context, base: dict[str, Any], needs_gas: bool, path: Path) -> None:
    """What the deck lacks, from the other case."""
    if needs_gas and not ("inflator" in base or base.get("gas", {}).get("model") == "none"):
        raise NO_AIRBAG(what="what gas fills the bag", place=path, why="it has no *AIRBAG that is read")
    for name in BASE_TABLES:
        table, mine = base.get(name), context.tables.get(name)
        if isinstance(table, dict) and not isinstance(mine, list):
            if name in ("gas", "inflator", "ambient") and not needs_gas:
                continue
            context.tables[name] = {**table, **(mine or {})}
            context.report.remarks.append(f"[{name}] from the case given with --base, where the deck says nothing")
        elif table is not None and mine is None and needs_gas:
            context.tables[name] = table


def _without_jets(context: Context) -> None:
    """The inflators of the other case without jets: a bag without a mouth has nothing to carry them."""
    given = context.tables.get("inflator") or []
    for one in [given] if isinstance(given, dict) else given:
        if one.get("jets", {}).get("count", 1):
            one["jets"] = {"count": 0}
            context.report.remarks.append("the bag has no mouth: the gas of the inflator comes in without jets")


def put_bag_tables(context: Context, bag: BagMesh) -> None:
    """The `[bag]` table: files, parts, and what others put there."""
    if bag.birth is not None and bag.birth.number and "birth_time" not in context.tables["bag"]:
        birth_time(context, bag.birth)  # unless the material has one, which counts
    own = context.tables["bag"]
    has_vent = any(part["kind"] == "vent" for part in bag.parts.values())
    if not has_vent:
        own.pop("vents", None)
    if context.airbag is None and not any(part["kind"] == "mouth" for part in bag.parts.values()):
        _without_jets(context)
    table: dict[str, Any] = {"shape": "mesh", "start": "start.vtkhdf"}
    if bag.reference is not None:
        table["reference"] = Said("reference.vtkhdf", bag.reference_source)
    context.tables["bag"] = {**table, **own, "parts": list(bag.parts.values())}
