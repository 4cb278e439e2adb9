"""For every code, the smallest thing a user, a disk or a cluster can do that brings it about.

Each function raises the error, or returns what a study has recorded, or returns a warning. `here` offers a folder,
sound files (`here.bench`) and `here.patch`, pytest's monkeypatch.
"""

from __future__ import annotations

import triggers_cases
import triggers_runs
import triggers_studies
import triggers_surrogates
from here import Here, Told

TRIGGERS = {
    **triggers_cases.TRIGGERS,
    **triggers_runs.TRIGGERS,
    **triggers_studies.TRIGGERS,
    **triggers_surrogates.TRIGGERS,
}

__all__ = ["TRIGGERS", "Here", "Told"]
