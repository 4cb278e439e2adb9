"""Some keys of a case replaced: how a design of experiments reaches into a case."""

from __future__ import annotations

from typing import Any

from billow.base.errors import InputError


def vary(data: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """The tables of a case with dotted keys replaced, in place; what stands in a list (obstacles, several inflators) is
    addressed by name. Values are not checked.

    Raises InputError E-CASE-006 for keys that lead nowhere.
    """
    for key, value in changes.items():
        *path, last = key.split(".")
        place: Any = data
        for part in path:
            place = _enter(place, part, key)
        if not isinstance(place, dict):
            raise _unknown(key, last, sorted(_named(place)))
        place[last] = value
    return data


def _enter(place: Any, part: str, key: str) -> Any:
    if isinstance(place, (list, tuple)):
        named = _named(place)
        if part not in named:
            raise _unknown(key, part, sorted(named))
        return named[part]
    if not isinstance(place, dict) or part not in place:
        raise _unknown(key, part, sorted(place) if isinstance(place, dict) else [])
    return place[part]


def _named(place: Any) -> dict[str, Any]:
    """The tables of a list by name; none if it is not a list."""
    items = place if isinstance(place, (list, tuple)) else ()
    return {str(item.get("name")): item for item in items if isinstance(item, dict)}


def _unknown(key: str, part: str, known: list[str]) -> InputError:
    return InputError(
        "E-CASE-006",
        f"the case has no {part!r} to vary",
        where=f"key {key}",
        why="the dotted key does not lead to a setting",
        remedy=f"use one of: {', '.join(known)}" if known else "see docs/case.md for the keys",
    )
