"""For every code, the smallest thing a user, a disk or a cluster can do that brings it about.

Each function raises the error, or returns what a study has recorded, or returns a warning. `here` offers a folder,
sound files (`here.bench`) and `here.patch`, pytest's monkeypatch.
"""

from __future__ import annotations

import triggers_cases
import triggers_convergence
import triggers_coupled
import triggers_fabric
import triggers_gas
import triggers_geometry
import triggers_injury
import triggers_runs
import triggers_studies
import triggers_surrogates
import triggers_tank
from here import Here, Told

TRIGGERS = {
    **triggers_cases.TRIGGERS,
    **triggers_convergence.TRIGGERS,
    **triggers_coupled.TRIGGERS,
    **triggers_gas.TRIGGERS,
    **triggers_fabric.TRIGGERS,
    **triggers_geometry.TRIGGERS,
    **triggers_injury.TRIGGERS,
    **triggers_runs.TRIGGERS,
    **triggers_studies.TRIGGERS,
    **triggers_surrogates.TRIGGERS,
    **triggers_tank.TRIGGERS,
}

__all__ = ["TRIGGERS", "Here", "Told"]
