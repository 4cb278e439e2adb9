"""One attempt at one run, in this process, in a local worker, or in a worker of a cluster."""

from __future__ import annotations

import errno
import time
import tomllib
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from billow.base.errors import BillowError, NumericalStop, ResourceError
from billow.results.machine import peak_memory
from billow.results.ownership import discard
from billow.results.run_file import read_run_file
from billow.study.store import RunStore

DISK_FULL = ResourceError.declare(
    "E-STU-012",
    "the disk is full",
    where="{place}",
    why="{problem}; nothing partial was kept",
    cause="results need more room than there is; `billow check` says how much a run needs",
    remedy="free space, then give the same command again: finished runs are kept",
)
ENDED_EARLY = NumericalStop.declare(
    "E-STU-014",
    "the run was {status}",
    where="run {run}",
    cause="a solver other than Billow's own that does not say why it stopped",
    remedy="look at its last frames in failed/{run}/fabric.vtkhdf, then narrow the parameter ranges",
)
SIMULATION_FAILED = BillowError.declare(
    "E-STU-016",
    "the simulation ended with {kind}",
    where="run {run}, {place}",
    cause="a mistake in Billow",
    remedy="make the run by itself, with the values of run {run} in design.csv: billow run CASE.toml --out RUN",
)
WORKER_CANNOT_RUN = ResourceError.declare(
    "E-STU-018",
    "a worker cannot make runs",
    where="Dask worker",
    cause="it does not see the study folder, or has no Billow or another version of it",
    remedy="install the same version of Billow and its dependencies on every worker",
)
CANNOT_WRITE = ResourceError.declare(
    "E-STU-023",
    "the study folder cannot be written",
    where="{path}",
    cause="no permission, a read-only disk, or a file where a folder was expected",
    remedy="check path and permissions, or choose another folder with --out",
)

Runner = Callable[..., Any]
"""`runner(case, folder, *, threads)`: simulates and publishes a run folder, as `billow.run.simulate.simulate` does."""


@dataclass(frozen=True)
class Task:
    """A run to be made, as sent to a worker process: the case as text, which every process reads alike.

    case_toml: the effective case; rebuild: makes a `billow.Case` of its nested dictionaries; threads: it may use.
    """

    run: str
    case_toml: str
    rebuild: Callable[[dict[str, Any]], Any]
    threads: int = 1


@dataclass(frozen=True)
class Outcome:
    """How an attempt ended.

    status: "completed"; "failed" for `error`; "interrupted" by the user; "repeated": it died and is tried again.
    seconds: [s] it took; attempts: how many were begun, this one included. memory: [MB], the most that the process has
    held since it began; 0 where the system does not say.
    """

    run: str
    status: str
    seconds: float = 0.0
    attempts: int = 1
    error: BillowError | None = None
    memory: float = 0.0


def attempt_run(folder: str, task: Task, runner: Runner | None = None) -> Outcome:
    """Make a run of the study in `folder` and publish it. Every failure comes back as an outcome.

    Making a run twice, at once or one after the other, leaves one run.
    """
    store = RunStore(folder)
    if not (store.folder / "study.toml").is_file():
        error = WORKER_CANNOT_RUN(
            what="a worker cannot see the study folder",
            where=store.folder,
            why="there is no study.toml at that path on the worker's machine",
            remedy="put the study on a file system that all workers share, and give it by its full path",
        )
        return Outcome(task.run, "failed", error=error)
    started = time.perf_counter()
    if store.is_published(task.run):
        return Outcome(task.run, "completed")
    attempts, workplace = store.dead_attempts(task.run) + 1, None
    try:
        workplace = store.begin(task.run)
        status, error = _simulate(store, task, workplace / task.run, runner)
    except BillowError as problem:
        status, error = "failed", problem
    except Exception as problem:
        status, error = "failed", _out_of_space(problem, store.folder) or _unexpected(task.run, problem)
    if workplace is not None:
        discard(workplace)
    return Outcome(task.run, status, time.perf_counter() - started, attempts, error, peak_memory())


def _simulate(store: RunStore, task: Task, place: Path, runner: Runner | None) -> tuple[str, BillowError | None]:
    if runner is None:
        from billow.run.simulate import simulate as runner
    case, error = task.rebuild(tomllib.loads(task.case_toml)), None
    try:
        runner(case, place, threads=task.threads)
    except NumericalStop as stop:  # its last frames are still of interest
        error = stop
    if not place.is_dir():
        raise error or RuntimeError("the simulation ended without publishing its run")
    record = read_run_file(place, verify=False)
    if error is None and record["status"] == "completed":
        store.publish(task.run, place)
        return "completed", None
    if record["status"] == "interrupted":
        return "interrupted", None
    store.keep_stopped(task.run, place)
    return "failed", error or ENDED_EARLY(
        status=record["status"], run=task.run, why=record.get("reason") or "no reason was recorded"
    )


def _out_of_space(problem: Exception, place: Path) -> ResourceError | None:
    full = isinstance(problem, OSError) and problem.errno in (errno.ENOSPC, errno.EDQUOT)
    return DISK_FULL(place=place, problem=problem) if full else None


def cannot_write(problem: OSError, place: Path) -> ResourceError:
    """E-STU-012 if the disk is full, else E-STU-023: the study folder refuses for another reason."""
    return _out_of_space(problem, place) or CANNOT_WRITE(path=problem.filename or place, why=problem)


def _unexpected(run: str, problem: Exception) -> BillowError:
    last = traceback.extract_tb(problem.__traceback__)[-1]
    place = f"{Path(last.filename).name}:{last.lineno}"
    return SIMULATION_FAILED(kind=type(problem).__name__, run=run, place=place, why=str(problem) or "no message")
