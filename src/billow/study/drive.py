"""One drive through a study: find out which runs are missing, have them made, check and count what comes in."""

from __future__ import annotations

import contextlib
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

from billow.base.cores import available_cores
from billow.base.errors import IntegrityError, ResourceError
from billow.base.quality import VERDICTS, doubts
from billow.results.dataset import difference, why_failed
from billow.results.dataset_files import DATASET_FILE, DatasetRecord, fingerprint, read_dataset_file, write_dataset_file
from billow.results.ownership import discard
from billow.results.result import Result
from billow.study.attempt import Outcome, Runner, Task, attempt_run
from billow.study.execute import WORKER_DIED, dask_client, run_on_dask

OTHER_RUN = IntegrityError.declare(
    "E-STU-010",
    "run {run} on disk is not the run of this design",
    where="{folder}",
    why="it was made from another case, or the study's files were changed since",
    remedy="restore study.toml, case.toml and design.csv; or move {folder} away to make it again",
)
OTHER_MESH = IntegrityError.declare(
    "E-STU-011",
    "run {run} has another mesh or other times than the runs before it",
    where="{folder}",
    why="{difference}; a surrogate needs all runs on one mesh at the same times",
    cause="a parameter that changes the mesh or the recorded times is varied",
    remedy="vary only parameters that change neither, or set same_mesh = false; start anew in another folder",
)


MOST_NAMED = 8
"""Runs that a line names."""


@dataclass(frozen=True)
class ProgressEvent:
    """Something that happened in `Study.run`.

    status: "started", "completed", "failed", "repeated" (its worker died), "set aside" (damaged, is made again),
    "finished"; run: which, or "" for the study; done: runs completed or failed so far, of `total`; seconds: [s] the
    run took, for "finished" the whole call; message: one line for people. memory: [MB], the most that one worker has
    held so far; 0 if it is not known.
    """

    status: str
    run: str
    done: int
    total: int
    seconds: float
    message: str
    memory: float = 0.0


@dataclass(frozen=True)
class StudySummary:
    """Where a study stands. completed: runs; failed: run -> reason; seconds: [s] the call took. verdicts: run -> PASS,
    REVIEW or FAIL, of those that carry one; doubts: run -> criteria it did not pass."""

    completed: tuple[str, ...]
    failed: dict[str, str]
    seconds: float
    verdicts: dict[str, str] = field(default_factory=dict)
    doubts: dict[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def counts(self) -> str:
        """How many runs there are of each verdict, such as "12 runs completed: 10 PASS, 2 REVIEW; 1 failed"."""
        found = Counter(self.verdicts.values())
        verdicts = ", ".join(f"{found[verdict]} {verdict}" for verdict in VERDICTS if found[verdict])
        runs = f"{len(self.completed)} run{'' if len(self.completed) == 1 else 's'} completed"
        return f"{runs}{': ' + verdicts if verdicts else ''}; {len(self.failed)} failed"

    @property
    def reasons(self) -> list[str]:
        """One line for each verdict and criterion that was not passed, with its runs."""
        runs: dict[tuple[str, str], list[str]] = {}
        for run, names in self.doubts.items():
            for name in names:
                runs.setdefault((self.verdicts[run], name), []).append(run)
        ordered = sorted(runs.items(), key=lambda item: (-VERDICTS.index(item[0][0]), -len(item[1])))
        return [f"{verdict} by {name}: {_some(names)}" for (verdict, name), names in ordered]


def _some(runs: list[str]) -> str:
    rest = f" and {len(runs) - MOST_NAMED} more" if len(runs) > MOST_NAMED else ""
    return f"run{'' if len(runs) == 1 else 's'} {', '.join(runs[:MOST_NAMED])}{rest}"


class Drive:
    """One call of `Study.run`; study: the study itself."""

    def __init__(self, study, report: Callable[[ProgressEvent], None], retry_failed: bool):
        self.study, self.store, self.report, self.retry_failed = study, study.store, report, retry_failed
        self.started = time.perf_counter()
        self.completed: set[str] = set()
        self.quality: dict[str, dict] = {}
        self.failed: dict[str, str] = {}
        self.memory = 0.0

    def go(self, workers: int | None, scheduler: str | None, runner: Runner | None) -> StudySummary:
        """Make what is missing; errors as `Study.run`."""
        tasks, runs = self._survey(), self.study.runs
        cores = workers or available_cores()
        # never more processes than runs: starting one costs seconds; runs that are fewer than the cores share them
        workers = min(cores, max(len(tasks), 1))
        threads = 1 if scheduler else cores // workers
        tasks = [replace(task, threads=threads) for task in tasks]
        place = f"the cluster at {scheduler}" if scheduler else f"{workers} worker{'s' if workers > 1 else ''}"
        self._tell("started", "", 0.0, f"{len(tasks)} of {len(runs)} runs to make, by {place}")
        with contextlib.closing(self._outcomes(tasks, workers, threads, scheduler, runner)) as outcomes:
            for outcome in outcomes:
                self._take(outcome)
        seconds = time.perf_counter() - self.started
        completed = tuple(run for run in runs if run in self.completed)
        judged = {run: self.quality[run] for run in completed if self.quality[run].get("verdict") in VERDICTS}
        summary = StudySummary(
            completed, dict(sorted(self.failed.items())), seconds,
            {run: quality["verdict"] for run, quality in judged.items()},
            {run: doubts(quality) for run, quality in judged.items()},
        )  # fmt: skip
        self._tell("finished", "", seconds, summary.counts)
        return summary

    def _outcomes(self, tasks, workers, threads, scheduler, runner) -> Iterator[Outcome]:
        if scheduler is None and workers == 1:
            yield from (attempt_run(str(self.store.folder), task, runner) for task in tasks)
        elif tasks:
            scratch = self.store.begin("workers")  # in the study, where the next start finds it after a kill
            try:
                with dask_client(workers, scheduler, scratch, threads) as client:
                    yield from run_on_dask(client, self.store, tasks, runner)
            finally:
                discard(scratch)

    def _survey(self) -> list[Task]:
        """Look at what is on disk; returns what is missing."""
        tasks = []
        for run in self._most_telling_first():
            case = self.study.case(run)
            if self.store.is_published(run) and self._admit(run, case.digest()):
                continue
            failure = why_failed(self.store.failed / f"{run}.json")
            if failure and not self.retry_failed:
                self.failed[run] = failure
            else:
                tasks.append(Task(run, case.to_toml(), type(case).from_dict))
        return tasks

    def _most_telling_first(self) -> list[str]:
        """The smallest nested design, the test runs, then the rest: half a study is already worth learning from."""
        train, first = list(self.study.train), min(self.study.definition.sizes)
        return [*train[:first], *self.study.test, *train[first:]]

    def _admit(self, run: str, digest: str) -> bool:
        """Check a published run and count it; False if it was damaged and has been set aside."""
        try:
            result = Result.open(self.store.runs / run)
        except IntegrityError as error:
            place = self.store.set_aside(run)
            self._tell("set aside", run, 0.0, f"{error.code}: {error.what}; {error.why}; moved to {place}")
            return False
        if result.record["case_digest"] != digest or result.status != "completed":
            raise OTHER_RUN(run=run, folder=result.folder)
        folder, d = self.study.folder, self.study.definition
        if not (folder / DATASET_FILE).is_file():  # the first run in sets mesh and times; the others must have the same
            own = d.own_starts
            mesh, times = fingerprint(result.reference, result.triangles, own), tuple(result.times.tolist())
            write_dataset_file(folder, DatasetRecord(d.title, d.reference_length, d.seed, mesh, times, d.axes, own))
        elif d.same_mesh and (other := difference(read_dataset_file(folder), result)):
            raise OTHER_MESH(run=run, folder=result.folder, difference=other)
        self.completed.add(run)
        self.quality[run] = result.record.get("quality", {})
        self.store.forget_failure(run)
        return True

    def _take(self, outcome: Outcome) -> None:
        run, error = outcome.run, outcome.error
        self.memory = max(self.memory, outcome.memory)
        if outcome.status == "interrupted":
            raise KeyboardInterrupt
        if isinstance(error, ResourceError) and error.code != WORKER_DIED.code:  # the other runs would fail as well
            error.what += f" after {len(self.completed)} of {len(self.study.runs)} runs"
            raise error
        if outcome.status == "repeated":
            self._tell("repeated", run, 0.0, f"its worker died; {outcome.attempts} attempts so far")
        elif error is not None:
            self.store.record_failure(run, error, outcome.attempts)
            self.failed[run] = f"{error.code}: {error.what}; {error.why}"
            self._tell("failed", run, outcome.seconds, self.failed[run])
        elif self._admit(run, self.study.case(run).digest()):
            self._tell("completed", run, outcome.seconds, "")

    def _tell(self, status: str, run: str, seconds: float, message: str) -> None:
        done = len(self.completed) + len(self.failed)
        self.report(ProgressEvent(status, run, done, len(self.study.runs), seconds, message, self.memory))
