"""A folder of runs that differ only in their design: the one place where solver and reduced-order model meet."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from functools import cached_property
from operator import attrgetter
from pathlib import Path

import numpy as np

from billow.base import quality
from billow.base.errors import BillowError, InputError, IntegrityError
from billow.base.input_file import read_text
from billow.results.dataset_files import (
    NO_COMPLETED_RUN,
    DatasetRecord,
    MeshParts,
    Parameter,
    read_dataset_file,
    read_design,
    read_split,
    same_times,
)
from billow.results.floor_file import Floor, read_floor
from billow.results.result import Result
from billow.results.run_file import read_run_file

OTHER_MESH_OR_TIMES = IntegrityError.declare(
    "E-RES-012",
    "run {run} does not fit its dataset",
    where="{folder}",
    cause="a parameter that changes the mesh or the recorded times was varied",
    remedy="vary only parameters that keep the mesh and the recorded times; use one dataset for each mesh",
)
NO_SUCH_FIELD = InputError.declare(
    "E-RES-013",
    "there is no field {field!r}",
    where="{folder}",
    why="a dataset offers {known}",
    remedy='ask for "displacement" or "contact_force"',
)
NO_SUCH_RUN = InputError.declare(
    "E-RES-014",
    "run {run!r} is not available",
    where="{folder}",
    cause="it failed, has not been made yet, or does not belong to the dataset",
    remedy="use runs listed in Dataset.train and Dataset.test",
)

SNAPSHOT_FIELDS = ("displacement", "contact_force")


class Dataset:
    """Runs on one mesh at the same times, with the design values that made them differ.

        dataset = Dataset.open("my_study")
        dataset.design(dataset.train)                      # (runs, parameters)
        dataset.snapshots("displacement", dataset.train)   # [m], (runs, times, nodes, 3)

    parameters: the axes of the design space; times: [s], (times,) float64, without the start; reference_length: [m];
    title; seed; train, test: runs that exist, completed and verify, in the order drawn; missing: the other runs ->
    why.
    """

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
        self._shared = shared = read_dataset_file(folder)
        self._design, split = read_design(folder, shared.parameters), read_split(folder)
        self.title, self.seed, self.reference_length = shared.title, shared.seed, shared.reference_length
        self.parameters: tuple[Parameter, ...] = shared.parameters
        # The start shape is the same in every run: nothing to learn from it, and it would flatter every mean error.
        self.times = np.array([time for time in shared.times if time > 0.0])
        self._records: dict[str, dict] = {}
        self.missing: dict[str, str] = {}
        for run in (*split[0], *split[1]):
            self._look_up(run)
        self.train, self.test = (tuple(run for run in part if run in self._records) for part in split)
        self._planned_train = tuple(run for run in split[0] if run in self._design)

    @classmethod
    def open(cls, folder: str | Path) -> Dataset:
        """Open a dataset; every file of every run is verified.

        InputError E-RES-010 if no run is complete yet; IntegrityError E-RES-011 if dataset.toml, design.csv or
        split.toml is damaged. Runs that are absent, failed or damaged are no error: they are listed in `missing`.
        """
        return cls(folder)

    def __repr__(self) -> str:
        counts = f"{len(self.train)} train, {len(self.test)} test, {len(self.missing)} missing"
        return f"Dataset({str(self.folder)!r}, {counts})"

    @cached_property
    def _first(self) -> Result:
        run = next(iter(self._records), None)
        if run is None:
            first = next(iter(self.missing.values()), "no run")
            raise NO_COMPLETED_RUN(folder=self.folder, why=f"{len(self.missing)} runs are missing; the first: {first}")
        return self._checked(run)

    @property
    def trusted(self) -> tuple[str, ...]:
        """Training runs with nothing against what they hold: those that left_out does not name."""
        return tuple(run for run in self.train if run not in self.left_out)

    @cached_property
    def left_out(self) -> dict[str, str]:
        """Training runs of the design that nothing should be learned from -> why: missing ones, and those in doubt.

        A run that only ends before 1.2 times its pressure peak is not in doubt (`quality.SHORT`): a surrogate answers
        for the recorded times alone, and leaving out slow bags would bias it. Runs of other solvers carry no verdict.
        """
        why = {}
        for run in self._planned_train:
            if run in self.missing:
                why[run] = self.missing[run]
            elif doubts := [name for name in self.doubts(run) if name != quality.SHORT]:
                why[run] = f"{self.verdict(run)}: {', '.join(doubts)}"
        return why

    def doubts(self, run: str) -> tuple[str, ...]:
        """Names of the criteria a run did not pass, none where it carries no verdict. InputError E-RES-014: unknown."""
        return quality.doubts(self._record(run).get("quality", {}))

    def verdict(self, run: str) -> str | None:
        """PASS, REVIEW or FAIL, or None where a run carries no verdict. InputError E-RES-014: unknown run."""
        return self._record(run).get("quality", {}).get("verdict")

    @property
    def reference(self) -> np.ndarray:
        """[m], (nodes, 3) float32: the start shape, the same in every run. InputError E-RES-010 without any run."""
        return self._first.reference

    @property
    def own_starts(self) -> bool:
        """Whether each run has a start shape of its own; `reference` is then that of the first."""
        return self._shared.own_starts

    @property
    def floor(self) -> Floor | None:
        """How far runs are off when they are made again, if `billow floor` measured it. IntegrityError E-RES-170."""
        return read_floor(self.folder, self.times)

    def starts(self, runs: Sequence[str]) -> np.ndarray:
        """Start shapes of several runs: [m], (runs, nodes, 3) float32. Errors as `snapshots`."""
        return np.array([self._checked(run).reference for run in runs], np.float32).reshape(len(runs), -1, 3)

    triangles = property(attrgetter("_first.triangles"), doc="(triangles, 3) int64: nodes of each triangle.")

    @property
    def parts(self) -> MeshParts:
        """Parts of the mesh, the same in every run. InputError E-RES-010 without any run."""
        fabric = self._first.fabric
        return MeshParts(fabric.part.astype(np.int64), tuple(fabric.part_names))

    def obstacles(self, runs: Sequence[str]) -> list[list[dict]]:
        """Of each run, its obstacles as run.json describes them. Errors as `snapshots`."""
        return [self._record(run).get("obstacles", []) for run in runs]

    def design(self, runs: Sequence[str]) -> np.ndarray:
        """(runs, parameters) float64: design values, in each parameter's unit, of missing runs too.

        InputError E-RES-014: a run that the design does not have.
        """
        for run in runs:
            if run not in self._design:
                self._record(run)
        rows = [self._design[run] for run in runs]
        return np.array(rows, dtype=np.float64).reshape(len(rows), len(self.parameters))

    def snapshots(self, field: str, runs: Sequence[str]) -> np.ndarray:
        """One field of several runs: "displacement" [m] or "contact_force" [N], (runs, times, nodes, 3) float32.

        InputError E-RES-013: no such field, E-RES-014: no such run; IntegrityError E-RES-012: a run has another mesh
        or other times than the dataset.
        """
        if field not in SNAPSHOT_FIELDS:
            raise NO_SUCH_FIELD(field=field, folder=self.folder, known=" and ".join(SNAPSHOT_FIELDS))
        snapshots = np.empty((len(runs), len(self.times), len(self.reference), 3), dtype=np.float32)
        for row, run in enumerate(runs):
            snapshots[row] = self._checked(run).fabric.point_data(field)[-len(self.times) :]
        return snapshots

    def computing_seconds(self, runs: Sequence[str]) -> np.ndarray:
        """[s], (runs,) float64: what each simulation took, as `Result.computing_seconds`."""
        return np.array([self.result(run).computing_seconds for run in runs], dtype=np.float64)

    def result(self, run: str) -> Result:
        """One run, everything it recorded. InputError E-RES-014 if it is not among train and test."""
        return Result(self.folder / "runs" / run, self._record(run))

    def content_sha256(self) -> str:
        """SHA-256 of all that can be learned: axes, times, mesh, split, designs and every field of every run.

        The same for two studies of the same runs, whenever, wherever and in however many pieces they were made.
        """
        digest = hashlib.sha256()
        for part in (self.parameters, self._shared.times, self._shared.mesh_sha256, self.train, self.test):
            digest.update(repr(part).encode())
        for run in (*self.train, *self.test):
            digest.update(f"{run} {self._design[run]}".encode())
            if self.own_starts:
                digest.update(self.starts([run]).tobytes())
            for field in SNAPSHOT_FIELDS:
                digest.update(self.snapshots(field, [run]).tobytes())
        return digest.hexdigest()

    def _look_up(self, run: str) -> None:
        folder, failure = self.folder / "runs" / run, self.folder / "failed" / f"{run}.json"
        if run not in self._design:
            self.missing[run] = "split.toml names it, design.csv does not"
        elif folder.is_dir():
            try:
                record = read_run_file(folder)
                if record["status"] == "completed":
                    self._records[run] = record
                else:
                    self.missing[run] = f"{record['status']}: {record.get('reason')}"
            except BillowError as error:
                self.missing[run] = f"{error.code}: {error.what}; {error.why}"
        elif failure.is_file():
            self.missing[run] = why_failed(failure) or f"failed; {failure.name} cannot be read"
        else:
            self.missing[run] = "not run yet"

    def _record(self, run: str) -> dict:
        if run not in self._records:
            raise NO_SUCH_RUN(run=run, folder=self.folder, why=self.missing.get(run, "the dataset has no such run"))
        return self._records[run]

    def _checked(self, run: str) -> Result:
        """A run that has this dataset's mesh and times."""
        result = self.result(run)
        if why := difference(self._shared, result):
            raise OTHER_MESH_OR_TIMES(run=run, folder=result.folder, why=why)
        return result


def difference(shared: DatasetRecord, result: Result) -> str:
    """What a run has other than its dataset, mesh or times; empty if it has the same."""
    if not shared.has_mesh(result.reference, result.triangles):
        return f"its {shared.mesh} is not the one in dataset.toml"
    if not same_times(result.times, shared.times):
        return f"it recorded {len(result.times)} times up to {result.times[-1:]} s, not those in dataset.toml"
    return ""


def why_failed(path: Path) -> str | None:
    """Code and reason of a failed run from failed/<run>.json; None if it is missing or unreadable."""
    try:
        record = json.loads(read_text(path))
        return f"{record['code']}: {record['what']}; {record['why']}"
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return None
