"""Some keys of a case replaced: how a design of experiments reaches into a case."""

from __future__ import annotations

from typing import Any

from billow.base.errors import InputError

NO_SUCH_SETTING = InputError.declare(
    "E-CASE-006",
    "the case has no {part!r} to vary",
    where="key {key}",
    why="the dotted key does not lead to a setting",
    cause="a misspelt key after --set or among the keys of a study; an obstacle addressed by a name it does not have",
    remedy="use one of {known}",
)


def vary(data: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """The tables of a case with dotted keys replaced, in place; what stands in a list (obstacles, several inflators) is
    addressed by name, or by number from 1 if it has none (folds). Values are not checked.

    Raises InputError E-CASE-006 for keys that lead nowhere.
    """
    for key, value in changes.items():
        *path, last = key.split(".")
        place: Any = data
        for part in path:
            entries = _entries(place)
            if part not in entries:
                raise _unknown(key, part, entries)
            place = entries[part]
        if not isinstance(place, dict):
            raise _unknown(key, last, _entries(place))
        place[last] = value
    return data


def _entries(place: Any) -> dict[str, Any]:
    """What stands at a place: the entries of a table, the tables of a list by name or number from 1, or nothing."""
    if isinstance(place, dict):
        return place
    items = place if isinstance(place, (list, tuple)) else ()
    return {str(item.get("name", k)): item for k, item in enumerate(items, 1) if isinstance(item, dict)}


def _unknown(key: str, part: str, entries: dict[str, Any]) -> InputError:
    return NO_SUCH_SETTING(key=key, part=part, known=", ".join(sorted(entries)) or "the keys in docs/case.md")
