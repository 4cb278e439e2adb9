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
    addressed by name. Values are not checked.

    Raises InputError E-CASE-006 for keys that lead nowhere.
    """
    for key, value in changes.items():
        *path, last = key.split(".")
        place: Any = data
        for part in path:
            place = _enter(place, part, key)
        if not isinstance(place, dict):
            raise NO_SUCH_SETTING(key=key, part=last, known=_known(place))
        place[last] = value
    return data


def _enter(place: Any, part: str, key: str) -> Any:
    if isinstance(place, (list, tuple)):
        named = _named(place)
        if part not in named:
            raise NO_SUCH_SETTING(key=key, part=part, known=_known(place))
        return named[part]
    if not isinstance(place, dict) or part not in place:
        raise NO_SUCH_SETTING(key=key, part=part, known=_known(place))
    return place[part]


def _named(place: Any) -> dict[str, Any]:
    """The tables of a list by name; none if it is not a list."""
    items = place if isinstance(place, (list, tuple)) else ()
    return {str(item.get("name")): item for item in items if isinstance(item, dict)}


def _known(place: Any) -> str:
    """The keys or names at a place, as a message lists them."""
    return ", ".join(sorted(place if isinstance(place, dict) else _named(place))) or "the keys in docs/case.md"
