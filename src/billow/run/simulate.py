"""`simulate(case, folder)` and `resume(folder)`: the wiring of case, solver, checkpoints and result files."""

from __future__ import annotations

import contextlib
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path

import numba

from billow.base.compiled import telling
from billow.base.errors import BillowError, InputError, IntegrityError, NumericalStop
from billow.case.assumptions import assumptions, header
from billow.case.build import build_model, build_schedule, require_start_clear
from billow.case.concerns import concerns_of
from billow.case.schema import Case
from billow.results.atomic import (
    NOT_WRITTEN,
    PARTIAL,
    new_place,
    publish_folder,
    require_nothing_kept,
    unfinished,
)
from billow.results.ownership import clear
from billow.results.result import Result
from billow.results.run_file import read_run_file
from billow.run.case_folder import keep_case
from billow.run.checkpoint_file import BEGINNING, SLOTS, Start, newest_checkpoint
from billow.run.interrupts import STOP_FILE, Interrupts
from billow.run.names import owners, require_distinct
from billow.run.recorder import LOG, Progress, RunRecorder, Told
from billow.solver.model import Model
from billow.solver.run import run

NOTHING_TO_RESUME = InputError.declare(
    "E-RES-021",
    "there is no interrupted run to resume",
    where="{folder}",
    cause="the run has finished, was stopped before its first checkpoint, or its --out was another folder",
    remedy="give the --out folder of the interrupted run",
)
CASE_NOT_USABLE = IntegrityError.declare(
    "E-RES-033",
    "the case of the interrupted run cannot be used",
    where="{path}",
    cause="its case.toml was changed or damaged",
    remedy="run the case again from the start: billow run CASE.toml --out RUN",
)


def simulate(
    case: Case, folder: str | Path, *, progress: Callable[[Progress], None] | None = None, threads: int | None = None
) -> Result:
    """Run a case and publish its results in `folder`, which must not exist yet.

    progress: called with each line of the log, and each second with a status. threads: of the compiled kernels, all by
    default; results do not depend on it. While it runs, everything lies in `folder`.partial, which belongs to this
    process; status.json there says how far it is. It takes its name when complete. A run that had to be
    stopped is published too, with status "stopped" and a post-mortem, before NumericalStop is raised. An interrupted
    run (Ctrl-C, SIGTERM, SIGHUP, a file STOP in `folder`.partial) leaves a checkpoint there; `resume(folder)` continues
    from it.

    Raises InputError (case, geometry, folder), NumericalStop, ResourceError E-RES-020 (disk).
    """
    with _writing(folder):
        final = new_place(folder)
        with unfinished(final) as partial:
            require_nothing_kept(partial, final)
            clear(partial)  # of an earlier try that never reached a checkpoint
            with telling(_compiling(partial, progress, case.run.end_time)):
                try:
                    model = build_model(case)
                    require_distinct(owners(model, (sensor.name for sensor in case.run.sensors)))
                    require_start_clear(model)
                    case = keep_case(case, partial, header(case))
                except BaseException:
                    clear(partial)
                    raise
                return _run(case, model, partial, final, BEGINNING, progress, threads)


def resume(
    folder: str | Path, *, progress: Callable[[Progress], None] | None = None, threads: int | None = None
) -> Result:
    """Continue an interrupted run from its newest checkpoint; the results are the same bits as without interruption.

    folder: the one given to `simulate`. Other arguments and errors as `simulate`; IntegrityError E-RES-030 to -033 if
    there is no checkpoint, or something the run left behind cannot be used.
    """
    folder = Path(folder).absolute()  # "." has a name only in full
    partial = folder.parent / (folder.name + PARTIAL)  # "/" has no name
    if not partial.is_dir():
        finished = folder.is_dir()
        why = "the run has finished" if finished else "no such folder"
        raise NOTHING_TO_RESUME(folder=partial, why=why, remedy="open its results" if finished else None)
    with _writing(folder):
        final = new_place(folder)
        with unfinished(final) as partial:
            if _is_whole(partial):  # it ended just before it was published
                publish_folder(partial, final)
                return Result.open(final)
            for left in (STOP_FILE, *(path.name for path in partial.glob(".*.partial"))):
                (partial / left).unlink(missing_ok=True)  # it would stop the run again; half a file of a killed process
            try:
                case = Case.load(partial / "case.toml")
            except InputError as error:
                raise CASE_NOT_USABLE(path=partial / "case.toml", why=f"{error.what}: {error.why}") from error
            with telling(_compiling(partial, progress, case.run.end_time)):
                model = build_model(case)
                start = newest_checkpoint(partial, model, case.digest())
                return _run(case, model, partial, final, start, progress, threads)


def _run(
    case: Case,
    model: Model,
    partial: Path,
    final: Path,
    start: Start,
    progress: Callable[[Progress], None] | None,
    threads: int | None,
) -> Result:
    with _threads(threads), Interrupts(partial) as interrupts:
        told = told_by(case, model)
        recorder = RunRecorder(told, model, partial, interrupts, progress, start)
        recorder.greet(start.state)
        status, failure = "completed", None
        try:
            run(model, told.schedule, recorder, start.state)
        except NumericalStop as stop:
            status, failure = "stopped", stop
            # What was odd about the case from the beginning is often why a run failed.
            stop.why += "".join(f"; warned before: {c.code} {c.what} ({c.where})" for c in told.concerns)
            recorder.post_mortem(stop)
        except KeyboardInterrupt as interrupt:
            status, failure = "interrupted", interrupt
        recorder.finish(status, None if failure is None else str(failure) or "interrupted by the user")
    if status == "interrupted":
        raise failure
    publish_folder(partial, final)
    if failure is not None:
        raise failure
    return Result.open(final)


def _compiling(partial: Path, progress: Callable[[Progress], None] | None, end: float) -> Callable[[str], None]:
    """What says in the log, and to whoever watches, that kernels are compiled: that can begin before there is a
    recorder."""

    def tell(line: str) -> None:
        with open(partial / LOG, "a", encoding="utf-8") as log:
            log.write(line + "\n")
        if progress is not None:
            with contextlib.suppress(BrokenPipeError):  # nobody watches any more
                progress(Progress(0.0, end, line))

    return tell


@contextlib.contextmanager
def _writing(folder: str | Path) -> Iterator[None]:
    """What the operating system refuses becomes ResourceError E-RES-020, which says whether the run can be resumed."""
    try:
        yield
    except OSError as error:
        folder = Path(folder).absolute()
        partial = folder.parent / (folder.name + PARTIAL)  # "/" has no name
        remedy = None
        if any((partial / name).exists() for name in SLOTS):
            remedy = f"free space, then: billow resume {shlex.quote(str(folder))}"
        elif not partial.is_dir():
            remedy = "check path and permissions, or choose another folder with --out"
        raise NOT_WRITTEN(folder=error.filename or partial, why=error, remedy=remedy) from error


def _is_whole(partial: Path) -> bool:
    """Whether a run has ended, with all its files as they should be."""
    with contextlib.suppress(BillowError):
        return read_run_file(partial)["status"] != "interrupted"
    return False


def told_by(case: Case, model: Model) -> Told:
    """What the record of a run says of its case."""
    return Told(
        title=case.title,
        digest=case.digest(),
        schedule=build_schedule(case.run),
        concerns=tuple(concerns_of(case, model)),
        assumptions=assumptions(case),
        ambient_pressure=case.ambient.pressure,
        sensors={sensor.name: sensor.position for sensor in case.run.sensors},
        particle_times=case.run.particle_times,
        gas_frames=case.run.gas_frames,
        guard_crossings=case.run.guard_crossings,
    )


@contextlib.contextmanager
def _threads(count: int | None) -> Iterator[None]:
    before = numba.get_num_threads()
    numba.set_num_threads(min(count or before, numba.config.NUMBA_NUM_THREADS))
    try:
        yield
    finally:
        numba.set_num_threads(before)
