"""Codes that are not declared where they are raised yet: what each means, what usually causes it, and what helps."""

from __future__ import annotations

from billow.error_catalogue import (
    command_line,
    coupled,
    fabric,
    gas,
    geometry,
    obstacles,
    results,
    runs,
    surrogates,
)
from billow.error_catalogue.entry import Entry

CATALOGUE: dict[str, Entry] = {
    **command_line.CODES,
    **coupled.CODES,
    **fabric.CODES,
    **gas.CODES,
    **geometry.CODES,
    **obstacles.CODES,
    **results.CODES,
    **runs.CODES,
    **surrogates.CODES,
}

__all__ = ["CATALOGUE", "Entry"]
