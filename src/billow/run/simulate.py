"""`simulate(case, folder)` and `resume(folder)`: the wiring of case, solver, checkpoints and result files."""

from __future__ import annotations

import contextlib
import shlex
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numba

from billow.base.errors import BillowError, InputError, IntegrityError, NumericalStop, ResourceError
from billow.case.assumptions import assumptions, header
from billow.case.build import build_model, build_schedule, require_start_clear
from billow.case.concerns import concerns_of
from billow.case.schema import Case
from billow.results.atomic import FOLDER_EXISTS, publish_folder, write_atomically
from billow.results.result import Result
from billow.run.checkpoint_file import SLOTS, newest_checkpoint
from billow.run.interrupts import STOP_FILE, Interrupts
from billow.run.names import owners, require_distinct
from billow.run.recorder import Progress, RunRecorder, Told
from billow.solver.model import Model, State
from billow.solver.run import run

NOT_WRITTEN = ResourceError.declare(
    "E-RES-020",
    "the results could not be written",
    where="{folder}",
    cause="a full disk, or a folder without permission to write",
    remedy="free space, then: billow resume RUN",
)
NOTHING_TO_RESUME = InputError.declare(
    "E-RES-021",
    "there is no interrupted run to resume",
    where="{folder}",
    cause="the run has finished, or its --out was another folder",
    remedy="give the --out folder of the interrupted run",
)
INTERRUPTED_RUN_EXISTS = InputError.declare(
    "E-RES-022",
    "the folder belongs to an interrupted run",
    where="{folder}",
    why="it has a checkpoint; starting over would lose it",
    cause="the command of an interrupted run was given again",
    remedy="continue it: billow resume {final}; or delete {name}",
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

    progress: called at each output frame. threads: of the compiled kernels, all by default; results do not depend on
    it. While it runs, everything lies in `folder`.partial; it takes its name when complete. A run that had to be
    stopped is published too, with status "stopped" and a post-mortem, before NumericalStop is raised. An interrupted
    run (Ctrl-C, SIGTERM, a file STOP in `folder`.partial) leaves a checkpoint there; `resume(folder)` continues
    from it.

    Raises InputError (case, geometry, folder), NumericalStop, ResourceError E-RES-020 (disk).
    """
    folder = Path(folder).absolute()  # "." has a name only in full
    partial = _partial(folder)
    try:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise FOLDER_EXISTS(folder=folder)
        if any((partial / name).exists() for name in SLOTS):
            raise INTERRUPTED_RUN_EXISTS(folder=partial, final=shlex.quote(str(folder)), name=partial.name)
        shutil.rmtree(partial, ignore_errors=True)  # of an earlier try that never reached a checkpoint
        partial.mkdir(parents=True)
    except OSError as error:
        raise NOT_WRITTEN(folder=folder, why=error, remedy="choose another folder with --out") from error
    try:
        model = build_model(case)
        require_distinct(owners(model, (sensor.name for sensor in case.run.sensors)))
        require_start_clear(model)
        write_atomically(partial / "case.toml", header(case) + case.to_toml())
    except BillowError:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    except OSError as error:
        remedy = "free space, or choose another folder with --out"
        raise NOT_WRITTEN(folder=partial, why=error, remedy=remedy) from error
    return _run(case, model, folder, (None, 0), progress, threads)


def resume(
    folder: str | Path, *, progress: Callable[[Progress], None] | None = None, threads: int | None = None
) -> Result:
    """Continue an interrupted run from its newest checkpoint; the results are the same bits as without interruption.

    folder: the one given to `simulate`. Other arguments and errors as `simulate`; IntegrityError E-RES-030 to -033 if
    there is no checkpoint, or something the run left behind cannot be used.
    """
    folder = Path(folder).absolute()
    partial = _partial(folder)
    if not partial.is_dir():
        finished = folder.is_dir()
        why = "the run has finished" if finished else "no such folder"
        raise NOTHING_TO_RESUME(folder=partial, why=why, remedy="open its results" if finished else None)
    (partial / STOP_FILE).unlink(missing_ok=True)  # it would stop the run again
    try:
        case = Case.load(partial / "case.toml")
    except InputError as error:
        raise CASE_NOT_USABLE(path=partial / "case.toml", why=f"{error.what}: {error.why}") from error
    model = build_model(case)
    return _run(case, model, folder, newest_checkpoint(partial, model, case.digest()), progress, threads)


def _run(
    case: Case,
    model: Model,
    folder: Path,
    start: tuple[State | None, int],
    progress: Callable[[Progress], None] | None,
    threads: int | None,
) -> Result:
    """start: the state to go on from, and where the journal stood then."""
    partial, (state, offset) = _partial(folder), start
    try:
        with _threads(threads), Interrupts(partial) as interrupts:
            told = told_by(case, model)
            recorder = RunRecorder(told, model, partial, interrupts, progress, offset)
            recorder.greet(state)
            status, failure = "completed", None
            try:
                run(model, told.schedule, recorder, state)
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
        publish_folder(partial, folder)
        if failure is not None:
            raise failure
    except OSError as error:
        raise NOT_WRITTEN(folder=partial, why=error) from error
    return Result.open(folder)


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
    )


def _partial(folder: Path) -> Path:
    return folder.with_name(folder.name + ".partial")


@contextlib.contextmanager
def _threads(count: int | None) -> Iterator[None]:
    before = numba.get_num_threads()
    numba.set_num_threads(min(count or before, numba.config.NUMBA_NUM_THREADS))
    try:
        yield
    finally:
        numba.set_num_threads(before)
