"""`simulate(case, folder)` and `resume(folder)`: the wiring of case, solver, checkpoints and result files."""

from __future__ import annotations

import contextlib
import shlex
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numba

from billow.base.errors import BillowError, Concern, InputError, IntegrityError, NumericalStop, ResourceError
from billow.case.build import build_model, build_schedule
from billow.case.obstacles.build_obstacle import require_start_clear
from billow.case.schema import Case
from billow.results.atomic import publish_folder, write_atomically
from billow.results.result import Result
from billow.run.checkpoint_file import newest_checkpoint
from billow.run.interrupts import STOP_FILE, Interrupts
from billow.run.recorder import Progress, RunRecorder
from billow.solver.model import Model, State
from billow.solver.run import run


def simulate(
    case: Case,
    folder: str | Path,
    *,
    progress: Callable[[Progress], None] | None = None,
    threads: int | None = None,
) -> Result:
    """Run a case and publish its results in `folder`, which must not exist yet.

    progress: called at each output frame. threads: of the compiled kernels, all by default; results do not depend on
    it. While it runs, everything lies in `folder`.partial; it takes its name when complete. A run that had to be
    stopped is published too, with status "stopped" and a post-mortem, before NumericalStop is raised. An interrupted
    run (Ctrl-C, SIGTERM, a file STOP in `folder`.partial) leaves a checkpoint there; `resume(folder)` goes on from
    it.

    Raises InputError (case, geometry, folder), NumericalStop, ResourceError E-RES-020 (disk).
    """
    folder = Path(folder).absolute()  # "." has a name only in full
    try:
        partial = _make_partial(folder)
    except OSError as error:
        raise _unwritable(folder, error, "choose another folder with --out") from error
    try:
        model = build_model(case)
        require_start_clear(model)
        write_atomically(partial / "case.toml", case.to_toml())
    except BillowError:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    except OSError as error:
        raise _unwritable(partial, error, "free space, or choose another folder with --out") from error
    return _run(case, model, folder, partial, None, 0, progress, threads)


def resume(
    folder: str | Path, *, progress: Callable[[Progress], None] | None = None, threads: int | None = None
) -> Result:
    """Go on with an interrupted run from its newest checkpoint; the results are the same bits as without interruption.

    folder: the one given to `simulate`. Other arguments and errors as `simulate`; IntegrityError E-RES-030 to -033 if
    there is no checkpoint, or something the run left behind cannot be used.
    """
    folder = Path(folder).absolute()
    partial = _partial(folder)
    if not partial.is_dir():
        finished = folder.is_dir()
        raise InputError(
            "E-RES-021",
            "there is no interrupted run to resume",
            where=str(partial),
            why="the run has finished" if finished else "no such folder",
            remedy="give the --out folder of the interrupted run" if not finished else "open its results",
        )
    (partial / STOP_FILE).unlink(missing_ok=True)  # who resumes wants the run to go on
    case = _case_left_in(partial)
    model = build_model(case)
    state, offset = newest_checkpoint(partial, model, case.digest())
    return _run(case, model, folder, partial, state, offset, progress, threads)


def _case_left_in(partial: Path) -> Case:
    try:
        return Case.load(partial / "case.toml")
    except InputError as error:
        raise IntegrityError(
            "E-RES-033",
            "the case of the interrupted run cannot be used",
            where=str(partial / "case.toml"),
            why=f"{error.what}: {error.why}",
            remedy="run the case again from the start: billow run CASE.toml --out RUN",
        ) from error


def _run(
    case: Case,
    model: Model,
    folder: Path,
    partial: Path,
    state: State | None,
    offset: int,
    progress: Callable[[Progress], None] | None,
    threads: int | None,
) -> Result:
    try:
        with _threads(threads), Interrupts(partial) as interrupts:
            recorder = RunRecorder(case, model, partial, interrupts, progress, offset)
            recorder.greet(state)
            status, failure = "completed", None
            try:
                run(model, build_schedule(case.run), recorder, state)
            except NumericalStop as stop:
                status, failure = "stopped", stop
                stop.why += _warned(recorder.warnings)
                recorder.post_mortem(stop)
            except KeyboardInterrupt as interrupt:
                status, failure = "interrupted", interrupt
            recorder.finish(status, None if failure is None else str(failure) or "interrupted by the user")
        if status == "interrupted":
            raise failure
        publish_folder(partial, folder)
        if failure is not None:
            raise failure
    except OSError as error:
        raise _unwritable(partial, error, "free space, then: billow resume RUN") from error
    return Result.open(folder)


def _warned(warnings: list[Concern]) -> str:
    """What was odd about the case from the beginning is often why a run failed."""
    return "".join(f"; warned before: {warning.code} {warning.what} ({warning.where})" for warning in warnings)


def _unwritable(folder: Path, error: OSError, remedy: str) -> ResourceError:
    return ResourceError(
        "E-RES-020",
        "the results could not be written",
        where=str(folder),
        why=error.strerror or str(error),
        remedy=remedy,
    )


def _partial(folder: Path) -> Path:
    return folder.with_name(folder.name + ".partial")


def _make_partial(folder: Path) -> Path:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(
            "E-RES-009",
            "the result folder exists already",
            where=str(folder),
            why="a published result is never overwritten",
            remedy="choose another folder with --out, or delete this one",
        )
    partial = _partial(folder)
    if any((partial / name).exists() for name in ("checkpoint_a.safetensors", "checkpoint_b.safetensors")):
        raise InputError(
            "E-RES-022",
            "an interrupted run is waiting there",
            where=str(partial),
            why="it has a checkpoint; starting over would lose it",
            remedy=f"go on with it: billow resume {shlex.quote(str(folder))}; or delete {partial.name}",
        )
    shutil.rmtree(partial, ignore_errors=True)  # of an earlier try that never reached a checkpoint
    partial.mkdir(parents=True)
    return partial


@contextlib.contextmanager
def _threads(count: int | None) -> Iterator[None]:
    before = numba.get_num_threads()
    numba.set_num_threads(min(count or before, numba.config.NUMBA_NUM_THREADS))
    try:
        yield
    finally:
        numba.set_num_threads(before)
