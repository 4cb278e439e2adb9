"""Every error and warning code: what it means, what usually causes it, and what helps.

docs/errors.md is made from this file. Codes are stable: a code keeps its meaning, and one that is no longer used is
never given to something else. A test compares the catalogue with the codes in the source.
"""

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

GROUPS = {
    "CASE": "The case file",
    "GEO": "Geometry",
    "GAS": "Gas",
    "CONV": "Convergence studies",
    "NUM": "Runs that are stopped",
    "RES": "Results, datasets and interrupted runs",
    "STU": "Studies",
    "ROM": "Surrogates",
    "INJ": "Injury metrics",
    "CPL": "Force inputs and coupled models",
    "CLI": "The command line",
    "FAB": "Fabric",
    "MESH": "Mesh",
    "OBS": "Obstacles",
    "TANK": "Tank tests",
}
"""What the middle of a code stands for."""

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

__all__ = ["CATALOGUE", "GROUPS", "Entry"]
