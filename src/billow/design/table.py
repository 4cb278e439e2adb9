"""Responses of all runs of a dataset, as a table."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from billow.base import quality
from billow.base.errors import BillowError, InputError
from billow.design.measures import NOT_IN_RUN, measure, unit_of
from billow.injury.filters import SAMPLED_TOO_SLOWLY
from billow.results.csv_files import csv_text
from billow.results.dataset import Dataset
from billow.results.dataset_files import Parameter, design_columns
from billow.results.result import UNREADABLE_CASE, Result
from billow.study.responses import StudyResponse
from billow.study.study import STUDY_FILE, Study
from billow.study.variables import StudyConstraint

MIXED_SAMPLING = InputError.declare(
    "E-DES-004",
    "runs {one} and {other} have histories of different intervals",
    where="{folder}",
    why="{first:.4g} and {second:.4g} s; a peak between wider samples is smaller, so they cannot be compared",
    cause="run.end_time, run.frames or run.histories_per_frame is varied",
    remedy="keep end_time / (frames * histories_per_frame) the same in all runs",
)
NO_RESPONSE = InputError.declare(
    "E-DES-005",
    "there is nothing to read off these runs",
    where="{folder}",
    why="none of the usual responses is in the first run, and the study names none",
    remedy="name [[responses]] in study.toml; docs/design.md lists what can be measured",
)

MEND = "mend the case as its criteria of quality say, and make the study again"
SAME_INTERVAL = 1e-6
"""Part by which intervals of histories may differ."""


@dataclass(frozen=True, eq=False)
class ResponseTable:
    """Responses of runs.

    parameters: axes of the design space; responses, units: of each column; runs; unseen: how many of the last runs are
    test runs; designs: (runs, parameters); values: (runs, responses), NaN for what did not happen; left_out: run ->
    why; steps: parameter -> step of the study, from its low end; constraints: of the study on every design; digest:
    SHA-256 of designs and values
    """

    title: str
    parameters: tuple[Parameter, ...]
    responses: tuple[StudyResponse, ...]
    units: tuple[str, ...]
    runs: tuple[str, ...]
    unseen: int
    designs: np.ndarray
    values: np.ndarray
    left_out: dict[str, str]
    steps: Mapping[str, float] = field(default_factory=dict)
    constraints: tuple[StudyConstraint, ...] = ()

    @property
    def digest(self) -> str:
        """SHA-256 of what can be learned from it."""
        told = f"{self.runs} {self.responses} {self.units} {self.unseen}".encode()
        return hashlib.sha256(told + self.designs.tobytes() + self.values.tobytes()).hexdigest()

    def csv(self) -> str:
        """A row for each run; an empty cell for what did not happen."""
        head = ["run", "split", *design_columns(self.parameters),
                *(f"{r.name} [{unit}]" for r, unit in zip(self.responses, self.units, strict=True))]  # fmt: skip
        first_unseen = len(self.runs) - self.unseen
        rows = [
            [run, "test" if k >= first_unseen else "train", *map(float, design),
             *("" if np.isnan(value) else float(value) for value in values)]
            for k, (run, design, values) in enumerate(zip(self.runs, self.designs, self.values, strict=True))
        ]  # fmt: skip
        return csv_text([head, *rows])


def respond(folder: str | Path, responses: Sequence[StudyResponse] | None = None) -> ResponseTable:
    """Responses of all completed runs of a study or an imported dataset.

    responses: by default those of study.toml, else the usual ones that the first run holds. Runs that failed or are in
    doubt are left out, as in training. InputError E-DES-001 to -005; E-RES-010 without any run.
    """
    folder = Path(folder)
    dataset = Dataset.open(folder)
    train = dataset.trusted
    test = tuple(run for run in dataset.test if not set(dataset.doubts(run)) - {quality.SHORT})
    runs = (*train, *test)
    left_out = dataset.left_out | {run: "in doubt" for run in dataset.test if run not in test}
    results = [dataset.result(run) for run in runs]
    if not results:
        _ = dataset.reference  # says that no run is complete
        first = next(iter(left_out.values()), "no run")
        raise NO_RESPONSE(folder=folder, why=f"every run is left out, the first for: {first}", remedy=MEND)
    _require_one_interval(folder, runs, results)
    study = Study.open(folder).definition if (folder / STUDY_FILE).is_file() else None
    if responses is None:
        responses = (study and study.responses) or usual_responses(results[0])
    if not responses:
        raise NO_RESPONSE(folder=folder)
    units = tuple(unit_of(results[0], response) for response in responses)
    values = np.array([[measure(result, response, folder) for response in responses] for result in results])
    return ResponseTable(
        dataset.title, tuple(dataset.parameters), tuple(responses), units, runs, len(test), dataset.design(runs),
        values, left_out, study.steps if study else {}, study.constraints if study else (),
    )  # fmt: skip


def usual_responses(result: Result) -> tuple[StudyResponse, ...]:
    """What most users ask of a run, as far as it holds that."""
    tables = [
        {"name": "peak_pressure", "measure": "peak", "quantity": "gauge_pressure", "unit": "kPa"},
        {"name": "final_pressure", "measure": "final", "quantity": "gauge_pressure", "unit": "kPa"},
        {"name": "fill_time", "measure": "fill_time"},
        {"name": "end_volume", "measure": "final", "quantity": "volume", "unit": "l"},
    ]
    for name, free in result.obstacles.items():
        if free:
            tables += [
                {"name": f"{name}_acceleration", "measure": "peak", "of": name, "quantity": "acceleration",
                 "filter": "CFC180"},
                {"name": f"{name}_hic15", "measure": "hic15", "of": name},
                {"name": f"{name}_clip3ms", "measure": "clip3ms", "of": name},
            ]  # fmt: skip
        elif name != "plate":
            tables.append({"name": f"{name}_force", "measure": "peak", "of": name, "quantity": "force"})
    found = []
    for table in tables:
        table["name"] = table["name"].replace("-", "_")
        response = StudyResponse.model_validate(table)
        try:
            measure(result, response, Path())
            found.append(response)
        except BillowError as error:
            if error.code not in (NOT_IN_RUN.code, SAMPLED_TOO_SLOWLY.code, UNREADABLE_CASE.code):
                raise
    return tuple(found)


def _require_one_interval(folder: Path, runs: Sequence[str], results: Sequence[Result]) -> None:
    intervals = [float(np.diff(result.histories.time[:2]).sum()) for result in results]
    for run, interval in zip(runs, intervals, strict=True):
        if abs(interval - intervals[0]) > SAME_INTERVAL * intervals[0]:
            raise MIXED_SAMPLING(one=runs[0], other=run, folder=folder, first=intervals[0], second=interval)
