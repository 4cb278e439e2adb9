"""What is wrong with a convergence study."""

from __future__ import annotations

from collections.abc import Callable

from here import Here

from billow.apps.converge.study import run_study
from billow.apps.converge.sweep import Sweep, make_runs
from billow.case.schema import Case
from trust import injections as inject
from trust.faults import SOUND

PARTICLES = SOUND | {"gas": {"model": "corpuscular"}}


def folder_of_another(here: Here):
    here.write("case.toml", "title = 'mine'\n")
    return make_runs(Sweep.of(Case.from_dict(PARTICLES), [1e3, 2e3], 2), here.place, lambda *_: None)


def none_runs_through(here: Here):
    with inject.nan_position():
        run_study(Sweep.of(Case.from_dict(PARTICLES), [1e3, 2e3], 2), here.place / "out", 0.02, lambda *_: None)


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-CONV-001": lambda here: Sweep.of(Case.from_dict(PARTICLES), [1e3], 2),
    "E-CONV-002": lambda here: Sweep.of(Case.from_dict(SOUND), [1e3, 2e3], 2),
    "E-CONV-003": folder_of_another,
    "E-NUM-007": none_runs_through,
}
