"""Codes that are not declared where they are raised yet: what each means, what usually causes it, and what helps."""

from __future__ import annotations

from billow.error_catalogue import (
    case,
    command_line,
    convergence,
    coupled,
    fabric,
    gas,
    geometry,
    injury,
    obstacles,
    results,
    runs,
    studies,
    surrogates,
    tank,
)
from billow.error_catalogue.entry import Entry

CATALOGUE: dict[str, Entry] = {
    **case.CODES,
    **command_line.CODES,
    **convergence.CODES,
    **coupled.CODES,
    **fabric.CODES,
    **gas.CODES,
    **geometry.CODES,
    **injury.CODES,
    **obstacles.CODES,
    **results.CODES,
    **runs.CODES,
    **studies.CODES,
    **surrogates.CODES,
    **tank.CODES,
}

__all__ = ["CATALOGUE", "Entry"]
