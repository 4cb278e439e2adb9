"""What is wrong with responses, their surfaces, or what is asked of them."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from here import Here
from triggers_surrogates import without

from billow.design import verify
from billow.design.adaptive import Aim
from billow.design.measures import measure
from billow.design.optimum import Goal, pareto
from billow.design.publish import publish
from billow.design.report import rounds_of
from billow.design.surfaces import ResponseSurfaces
from billow.design.table import _require_one_interval, respond
from billow.results.result import Result
from billow.study.responses import StudyResponse
from trust.small_surfaces import small_surfaces, small_table

POINT = {"vent": 35.0, "speed": 5.0, "gas": 0}
SMALL = functools.cache(small_surfaces)


def reading(**table) -> Callable[[Here], object]:
    """A response of a sound run."""
    response = {"name": "x", "measure": "peak", "quantity": "gauge_pressure"} | table
    return lambda here: measure(Result.open(here.bench.run), StudyResponse.model_validate(response), here.place)


def mixed(here: Here):
    results = [SimpleNamespace(histories=SimpleNamespace(time=np.array([0.0, step]))) for step in (1e-4, 2e-4)]
    _require_one_interval(Path("study"), ("0000", "0001"), results)


def one_value(here: Here):
    table = small_table()
    designs = table.designs.copy()
    designs[:, 1] = 5.0
    ResponseSurfaces.learn(dataclasses.replace(table, designs=designs))


def no_run(here: Here):
    """The solver fails at the optimum."""
    study = here.study()
    failed = SimpleNamespace(missing={"0007": "E-NUM-001: it blew up"}, left_out={}, train=(), doubts=lambda run: ())
    failed.design = lambda runs: np.empty((0, 3))
    variables = [SimpleNamespace(stepped=float)] * 3
    opened = SimpleNamespace(definition=SimpleNamespace(variables=variables))
    opened.with_run = lambda row: (SimpleNamespace(run=lambda workers: None), "0007")
    here.patch.setattr(verify, "Study", SimpleNamespace(open=lambda folder: opened))
    here.patch.setattr(verify, "Dataset", SimpleNamespace(open=lambda folder: failed))
    verify.verified(SMALL(), Goal(minimise="hard"), study.folder)


def no_pymoo(here: Here):
    without(here, "pymoo.algorithms.moo.nsga2")
    pareto(SMALL(), ("hard", "pressure"))


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-DES-001": reading(of="nobody", quantity="velocity"),
    "E-DES-002": reading(unit="K"),
    "E-DES-003": reading(measure="rating", reference="none.csv"),
    "E-DES-004": mixed,
    "E-DES-005": lambda here: respond(here.bench.study.folder, []),
    "E-DES-010": lambda here: SMALL().interval("contact", POINT),
    "E-DES-011": lambda here: SMALL().interval("hard", POINT, level=0.3),
    "E-DES-012": lambda here: ResponseSurfaces.load(here.write("x.safetensors", b"none")),
    "E-DES-013": lambda here: ResponseSurfaces.load(here.place / "none.safetensors"),
    "E-DES-014": one_value,
    "E-DES-020": lambda here: SMALL().sensitivity("hard", samples=1000),
    "E-DES-030": lambda here: Goal.load(here.write("goals.toml", "minimize = 'hard'"), SMALL()),
    "E-DES-031": lambda here: SMALL().optimise(minimise="hard", below={"pressure": 5.0}),
    "E-DES-032": no_pymoo,
    "E-DES-033": no_run,
    "E-DES-034": lambda here: rounds_of(here.place),
    "E-DES-040": lambda here: SMALL().exceed("hard", 400.0, POINT, {"vant": 1.0}),
    "E-DES-050": lambda here: Aim.read("rmse below 3"),
    "E-DES-170": lambda here: publish(here.bench.study.folder, here.place / "open", precision=0.05),
    "E-DES-041": lambda here: SMALL().exceed("hard", 400.0, POINT, {"vent": 30.0}),
}
