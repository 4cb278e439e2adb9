"""What is allowed but probably not meant: slips of units and settings that defeat each other.

Ranges in the schema refuse the impossible. Concerns look at quantities together; they are printed before a run, kept in
its record, and turn its verdict to REVIEW. Each part has its own; those of the mesh are the case's.
"""

from __future__ import annotations

from billow.base.errors import Concern
from billow.case.bag.plausible_mesh import mesh_concerns
from billow.case.schema import Case
from billow.solver.model import Model


def concerns_of(case: Case, model: Model) -> list[Concern]:
    """Everything about a case that looks unintended."""
    setting = model.setting(case.run.end_time)
    found = list(mesh_concerns(case, model))
    for _, part in model.parts:
        found += part.concerns(setting)
    return found
