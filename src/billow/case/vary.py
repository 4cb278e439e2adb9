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

AXES = "xyz"
"""Names of the first entries of a vector."""


def vary(data: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """The tables of a case with dotted keys replaced, in place; what stands in a list (obstacles, several inflators) is
    addressed by name, or by number from 1 if it has none (folds, entries of a curve); entries of a vector also by x, y
    and z. Values are not checked.

    Raises InputError E-CASE-006 for keys that lead nowhere.
    """
    for key, value in changes.items():
        *path, last = key.split(".")
        place: Any = data
        for part in path:
            entries = _entries(place)
            if part not in entries:
                raise _unknown(key, part, entries)
            inner = entries[part]
            if isinstance(inner, tuple):  # a list as the schema keeps it, which cannot be changed
                inner = list(inner)
                _set(place, part, inner)
            place = inner
        if isinstance(place, dict):
            place[last] = value
        elif last in _entries(place) and not isinstance(_entries(place)[last], dict):
            _set(place, last, value)
        else:
            raise _unknown(key, last, _entries(place))
    return data


def _entries(place: Any) -> dict[str, Any]:
    """What stands at a place: the entries of a table, those of a list by name or number from 1, or nothing."""
    if isinstance(place, dict):
        return place
    items = place if isinstance(place, (list, tuple)) else ()
    return {name: items[k] for name, k in _places(items).items()}


def _places(items: list | tuple) -> dict[str, int]:
    """Where the entries of a list stand, by how they are addressed."""
    places = {str(item.get("name", k) if isinstance(item, dict) else k): k - 1 for k, item in enumerate(items, 1)}
    if 2 <= len(items) <= len(AXES) and not any(isinstance(item, (dict, list, tuple)) for item in items):
        places |= {axis: k for k, axis in enumerate(AXES[: len(items)])}
    return places


def _set(place: Any, part: str, value: Any) -> None:
    place[part if isinstance(place, dict) else _places(place)[part]] = value


def _unknown(key: str, part: str, entries: dict[str, Any]) -> InputError:
    return NO_SUCH_SETTING(key=key, part=part, known=", ".join(sorted(entries)) or "the keys in docs/case.md")
