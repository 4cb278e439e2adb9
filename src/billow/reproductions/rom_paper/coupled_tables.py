"""How the coupled model's impactor is rated: over all unseen runs and run by run."""

from __future__ import annotations

import numpy as np

from billow.reproductions.rom_paper.case_results import CaseResults
from billow.reproductions.rom_paper.table import Table
from billow.rom.coupled.coupled_evaluation import COUPLED, MEAN_MOTION, QUANTITIES, TRUE_CONTACT, TRUE_INPUTS

OTHER_ANSWERS = (
    f"{TRUE_INPUTS.capitalize()}: the same model, but its bag is predicted with the nodal contact forces that the "
    "solver found in the very run that is asked for; the force on the impactor still comes from the learned law. "
    f"{TRUE_CONTACT.capitalize()}: no bag and no law; the impactor moves by the same steps under the contact force "
    "that the solver recorded on it, filtered to CFC 180 like the forces that were learned: what a perfect law would "
    f"reach. {MEAN_MOTION.capitalize()}: that of the training runs, which ignores the design."
)


def rating_table(results: CaseResults) -> Table:
    """The coupled model's impactor against the solver's, beside answers that know more or less."""
    found = results.coupled_evaluation
    rows = [(q, *(cell(q, a) for a in found.ratings for cell in (found.median, found.worst))) for q in QUANTITIES]
    columns = ("median", "worst", *(f"{a}: {of}" for a in found.ratings if a != COUPLED for of in ("median", "worst")))
    return Table(
        f"{results.case.name}-coupled",
        "The coupled model's impactor",
        f"ISO/TS 18571 rating against the solver, {len(found.runs)} unseen runs, along z. First pair: the coupled "
        f"model, to which nothing of the deployment is known in advance. {OTHER_ANSWERS}",
        ("", *columns),
        rows=tuple(rows),
    )


def rating_by_run(results: CaseResults) -> Table:
    """The rating of the impactor's acceleration, run by run."""
    found = results.coupled_evaluation
    accelerations = [q for q in QUANTITIES if q.startswith("acceleration")]
    scores = [found.overall(q, answer) for q in accelerations for answer in found.ratings]
    return Table(
        f"{results.case.name}-coupled-runs",
        "The impactor's acceleration, run by run",
        f"ISO/TS 18571 rating against the solver, along z. {OTHER_ANSWERS}",
        ("run", *(f"{q.removeprefix('acceleration ')}: {answer}" for q in accelerations for answer in found.ratings)),
        tuple((run, *map(float, row)) for run, row in zip(found.runs, np.transpose(scores), strict=True)),
    )
