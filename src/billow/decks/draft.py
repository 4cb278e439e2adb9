"""A case that is being written: tables of values, each with where it comes from, and its text with a comment a key."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from billow.decks.cards import Field


@dataclass(frozen=True)
class Said:
    """value: as TOML has it. source: of the deck, for the comment behind it."""

    value: Any
    source: str = ""


def said(value: Any, one: Field | str) -> Said:
    """A value and the field it comes from, or a remark."""
    return Said(value, one if isinstance(one, str) else f"{one.place} {one.shown}")


def plain(tables: Any) -> Any:
    """The values alone."""
    if isinstance(tables, Said):
        return tables.value
    if isinstance(tables, dict):
        return {key: plain(value) for key, value in tables.items()}
    return [plain(one) for one in tables] if isinstance(tables, list) else tables


def source_of(tables: Any, keys: list[str]) -> str | None:
    """Where the value of a dotted key comes from, or that of what lies around it."""
    found, place = None, tables
    for key in keys:
        if isinstance(place, list):
            place = next((one for k, one in enumerate(place) if key in (str(k), _name_of(one))), None)
        elif isinstance(place, dict):
            place = place.get(key)
        if place is None:
            break
        if isinstance(place, Said):
            found = place.source
            break
    return found


def _name_of(table: Any) -> Any:
    return plain(table.get("name")) if isinstance(table, dict) else None


def case_text(head: list[str], tables: dict[str, Any]) -> str:
    """TOML of a case; head: lines of the comment above it."""
    lines = [f"# {line}" for line in head]
    _write(lines, tables, "")
    return "\n".join(lines) + "\n"


def _write(lines: list[str], table: dict[str, Any], path: str) -> None:
    for key, value in table.items():
        if not _is_table(value):
            value = value if isinstance(value, Said) else Said(value)
            comment = f"  # {value.source}" if value.source else ""
            lines.append(f"{_key(key)} = {_toml(value.value)}{comment}")
    for key, value in table.items():
        name = f"{path}.{_key(key)}" if path else _key(key)
        if isinstance(value, dict):
            if value:
                lines += ["", f"[{name}]"] if any(not _is_table(v) for v in value.values()) else []
                _write(lines, value, name)
        elif _is_table(value):
            for one in value:
                lines += ["", f"[[{name}]]"]
                _write(lines, one, name)


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


def _key(key: str) -> str:
    return key if key.replace("_", "").replace("-", "").isalnum() and key.isascii() else json.dumps(key)


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return repr(float(value)) if isinstance(value, float) else str(int(value))
