"""Execution of runs: one after the other in this process, or by the worker processes of a Dask cluster.

Both yield an `Outcome` for each run as it ends, and one for each attempt that died and is repeated.
"""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import tempfile
import threading
from collections.abc import Iterator, Sequence
from multiprocessing import resource_tracker
from pathlib import Path

from billow.base.errors import InputError, ResourceError
from billow.study.attempt import WORKER_CANNOT_RUN, Outcome, Runner, Task, attempt_run
from billow.study.store import RunStore

MAX_ATTEMPTS = 3
"""Attempts at a run whose worker process dies, before the run counts as failed."""

_MAX_SUBMISSIONS = 12
"""Submissions of one run to the cluster. A run that waits in a worker killed by another run has not been attempted, but
a cluster whose workers die before they begin anything must end too."""

NO_SCHEDULER = InputError.declare(
    "E-STU-015",
    "the scheduler does not answer",
    cause="a misspelt address, or a cluster that is not running",
    remedy="give an address such as tcp://host:8786, as `dask scheduler` prints it when it starts",
)
CONNECTION_LOST = ResourceError.declare(
    "E-STU-017",
    "the connection to the scheduler was lost",
    where="Dask scheduler",
    why="a run under way was reported as {status}",
    cause="the scheduler ended, or the network failed",
    remedy="give the same command again: finished runs are kept",
)
WORKER_DIED = ResourceError.declare(
    "E-STU-019",
    "the worker process died",
    where="run {run}",
    why="it died in each of {attempts} attempts: killed from outside, out of memory, or a crash in compiled code",
    remedy="check the machine's memory, then: billow study STUDY.toml --out FOLDER --retry-failed",
)
"""The one error of the cluster that is the run's own."""
NO_WORKERS = ResourceError.declare(
    "E-STU-022",
    "worker processes could not be started",
    where="{count} local workers",
    cause="a script that runs a study without the guard of its main module",
    remedy='in a script, call run() under `if __name__ == "__main__":`; or give workers=1',
)

ANSWER_SECONDS = 10.0
"""[s] a scheduler has to answer."""

_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_SOLVER_THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS")
_ONE_THREAD = ("MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")


@contextlib.contextmanager
def _undisturbed() -> Iterator[None]:
    """Ctrl-C and its like wait until the block has ended; processes and threads that begin in it never see them.

    A terminal sends Ctrl-C to every process of a command. Workers are ended by this one; by themselves each would
    print a traceback, from the moment it exists.
    """
    came = []
    listening = threading.current_thread() is threading.main_thread()
    numbers = [n for n in _ENDING if signal.getsignal(n) is not signal.SIG_IGN] if listening else []
    before = {number: signal.signal(number, lambda *_: came.append(True)) for number in numbers}
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in before.items():
            signal.signal(number, handler)
    if came:
        raise KeyboardInterrupt


@contextlib.contextmanager
def dask_client(workers: int, scheduler: str | None, scratch: Path | None = None, threads: int = 1) -> Iterator:
    """A Dask client: of `workers` new local processes, or of the cluster at the address `scheduler`.

    scratch: a folder for what local workers keep on disk; threads: that a local worker may use. Local workers end with
    the block; a cluster stays as it was.
    InputError E-STU-015 if no scheduler answers there.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise NO_WORKERS(
            what="Dask cannot read its settings",
            where="the files of ~/.config/dask and DASK_CONFIG, and the variables that begin with DASK_",
            why=error if "config file" in str(error) else "they do not say what Dask expects",
            remedy="correct or remove them; a study on this machine needs none",
        ) from error

    if scheduler is not None:
        try:
            client = Client(scheduler, timeout=ANSWER_SECONDS)
        except Exception as error:  # no address, a protocol not installed, or one that needs settings of its own
            why = error if isinstance(error, OSError) else "Dask cannot use such an address"
            raise NO_SCHEDULER(where=f"--scheduler {scheduler!r}", why=why) from error
        with client:
            yield client
        return
    limits = dict.fromkeys(_SOLVER_THREADS, str(threads)) | dict.fromkeys(_ONE_THREAD, "1")
    settings = {
        # This module handles dead workers: it knows which of the worker's runs had begun.
        "distributed.scheduler.allowed-failures": 0,
        "distributed.scheduler.worker-saturation": 1.0,  # runs wait in the scheduler, not in a worker
        # Dask looks at what a worker does a hundred times a second; each look takes the interpreter from the solver.
        "distributed.worker.profile.enabled": False,
        "distributed.admin.tick.interval": "1s",
        "distributed.worker.use-file-locking": False,  # the folder is ours, and its disk may know no locks
        **{f"distributed.nanny.pre-spawn-environ.{name}": count for name, count in limits.items()},
    }
    with contextlib.ExitStack() as stack:
        for name in limits:  # Dask sets them here too and leaves them; numba would then refuse to continue here
            if name in os.environ:
                stack.callback(os.environ.__setitem__, name, os.environ[name])
            else:
                stack.callback(os.environ.pop, name, None)
        scratch = scratch or stack.enter_context(tempfile.TemporaryDirectory(prefix="billow-workers-"))
        stack.enter_context(dask.config.set(settings))
        started = stack.enter_context(contextlib.ExitStack())
        resource_tracker.ensure_running()  # when a worker starts it, the worker's signals are let through again
        try:
            with _undisturbed():
                cluster = LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    # No dashboard, but its server still listens: at a free port, so that studies can run side by side.
                    dashboard_address="127.0.0.1:0",
                    scheduler_kwargs={"dashboard": False},
                    memory_limit=0,  # runs are small; pausing one helps nobody
                    local_directory=str(scratch),
                    silence_logs=logging.CRITICAL,
                )
                started.enter_context(cluster)
                client = started.enter_context(Client(cluster))
        except (RuntimeError, OSError, ValueError, TypeError) as error:
            raise NO_WORKERS(count=workers, why=error) from error
        try:
            yield client
        finally:
            with _undisturbed():
                started.close()


def run_on_dask(client, store: RunStore, tasks: Sequence[Task], runner: Runner | None) -> Iterator[Outcome]:
    """Make runs in the workers of a Dask client, in any order.

    A run whose worker dies is repeated, `MAX_ATTEMPTS` times at most. ResourceError E-STU-017: the scheduler was lost;
    -018: workers cannot run Billow or do not see the study folder.
    """
    from distributed import KilledWorker, as_completed

    folder = str(Path(store.folder).resolve())
    submissions = dict.fromkeys((task.run for task in tasks), 0)

    def submit(task: Task, order: int):
        submissions[task.run] += 1
        key = f"billow-run-{task.run}-{submissions[task.run]}-{os.urandom(4).hex()}"
        # earlier runs first: an unfinished study then holds the first runs of the training sequence
        return client.submit(attempt_run, folder, task, runner, key=key, pure=False, priority=-order)

    waiting = {submit(task, order): (task, order) for order, task in enumerate(tasks)}
    ended = as_completed(list(waiting))
    try:
        for future in ended:
            task, order = waiting.pop(future)
            if future.status == "finished":
                yield future.result()
                continue
            problem = future.exception() if future.status == "error" else None
            if problem is None:
                raise CONNECTION_LOST(status=future.status)
            if not isinstance(problem, KilledWorker):
                raise WORKER_CANNOT_RUN(why=f"{type(problem).__name__}: {problem}")
            attempts = store.dead_attempts(task.run)
            if attempts >= MAX_ATTEMPTS or submissions[task.run] >= _MAX_SUBMISSIONS:
                error = WORKER_DIED(run=task.run, attempts=attempts)
                yield Outcome(task.run, "failed", attempts=attempts, error=error)
                continue
            yield Outcome(task.run, "repeated", attempts=attempts)
            again = submit(task, order)
            waiting[again] = (task, order)
            ended.add(again)
    finally:
        client.cancel(list(waiting))
