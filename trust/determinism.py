"""Same bits for any number of threads, for repeated runs, and across a restart.

Run as a program it makes one deployment with parallel kernels and prints the SHA-256 over all states and histories:

    NUMBA_NUM_THREADS=4 python -m trust.determinism GAS THREADS
"""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numba

from billow.base import compiled
from billow.case.build import build_model, build_schedule
from billow.run.checkpoint_file import Start, read_checkpoint, write_checkpoint
from billow.solver.run import run
from trust.scenes import Listener, impact, impact_case, state_sha256

GASES = ("uniform-pressure", "none")
MOST_THREADS = 4


class Reached(Exception):
    """The step a run was to be stopped at."""


def deployment_sha256(gas: str, threads: int) -> str:
    """All states at frames, all histories and the last state of one run, hashed."""
    numba.set_num_threads(threads)
    listener = Listener()
    last = run(*impact(gas), listener)
    return f"{listener.digest.hexdigest()}{state_sha256(last)}"


def in_own_process(*arguments: str) -> str:
    """Output of this file run as a program, with parallel kernels for every size of work."""
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(MOST_THREADS)}
    command = [sys.executable, "-m", "trust.determinism", *arguments]
    done = subprocess.run(
        command, env=environment, cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(done.stderr[-2000:])
    return done.stdout.strip()


def thread_matrix() -> dict[str, set[str]]:
    """Gas -> distinct hashes over 1, 2 and 4 threads, parallel kernels, each twice, and the serial kernels."""
    found: dict[str, set[str]] = {}
    for gas in GASES:
        parallel = {in_own_process(gas, str(threads)) for threads, _ in itertools.product((1, 2, 4), range(2))}
        found[gas] = parallel | {deployment_sha256(gas, 1)}
    return found


def restarts(gas: str) -> dict[int, bool]:
    """Step of the restart -> whether the run ended in the same bits; the thread count changes at the restart."""
    case = impact_case(gas)
    model, schedule = build_model(case), build_schedule(case.run)
    numba.set_num_threads(1)
    straight = run(model, schedule, Listener())
    expected, steps = state_sha256(straight), straight.step
    same = {}
    for k in (1, steps // 3 + 1, 2 * steps // 3, steps - 1):

        def stop(state, k=k):
            if state.step == k:
                with tempfile.TemporaryDirectory() as folder:
                    path = Path(folder) / "checkpoint.safetensors"
                    write_checkpoint(path, Start(state), case.digest())
                    raise Reached(read_checkpoint(path, build_model(case), case.digest()).state)

        numba.set_num_threads(1)
        try:
            run(model, schedule, Listener(stop))
        except Reached as reached:
            numba.set_num_threads(min(2, numba.config.NUMBA_NUM_THREADS))
            same[k] = state_sha256(run(model, schedule, Listener(), reached.args[0])) == expected
    return same


if __name__ == "__main__":
    compiled.PARALLEL_FROM = 1
    gas, threads = sys.argv[1:]
    if gas == "restarts":
        print(all(all(restarts(gas).values()) for gas in GASES))
    else:
        print(deployment_sha256(gas, int(threads)))
