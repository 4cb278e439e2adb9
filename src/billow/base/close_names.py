"""Names like one that was not found, for messages."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

MOST = 3


def close_names(name: str, known: Iterable[str]) -> list[str]:
    """Up to three of the known names that a misspelt one may stand for, the likeliest first."""
    by_lower = {other.lower(): other for other in known}
    found = difflib.get_close_matches(name.lower()[:200], by_lower, MOST, 0.5)
    within = [other for other in by_lower if name and name.lower() in other and other not in found]
    return [by_lower[other] for other in (found + within)[:MOST]]


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The beginning of a remedy, empty if no name is close."""
    found = close_names(name, known)
    return f"did you mean {' or '.join(found)}? " if found else ""
