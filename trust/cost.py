"""What ledger, guards and checkpoints cost: a run with them against the same run without, in one process."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numba
import numpy as np

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.run.checkpoint_file import Start, write_checkpoint
from billow.run.recorder import CHECKPOINT_SECONDS
from billow.solver import run as time_loop
from billow.solver.ledger import Ledger
from trust.scenes import PLATE

REPEATS = 7


def share() -> tuple[float, float]:
    """(ledger and guards, checkpoints) as parts of the time of a run, one thread.

    Ledger and guards: median over pairs of a run with them and the same run without. Checkpoints: the median time of
    one over the time between two.
    """
    numba.set_num_threads(1)
    case = Case.from_dict({"obstacles": [PLATE, {"shape": "super-ellipsoid"}], "run": {"end_time": 0.010, "frames": 1}})
    model, schedule = build_model(case), build_schedule(case.run)
    time_loop.run(model, schedule)
    ratios = []
    for _ in range(REPEATS):
        careful = _seconds(lambda: time_loop.run(model, schedule))
        checks = time_loop.check_state, Ledger.close
        time_loop.check_state = Ledger.close = lambda *arguments: None
        try:
            careless = _seconds(lambda: time_loop.run(model, schedule))
        finally:
            time_loop.check_state, Ledger.close = checks
        ratios.append(careful / careless - 1.0)
    state = time_loop.begin(model, schedule)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "checkpoint.safetensors"
        start = Start(state)
        save = np.median([_seconds(lambda: write_checkpoint(path, start, case.digest())) for _ in range(REPEATS)])
    return float(np.median(ratios)), float(save / CHECKPOINT_SECONDS)


def _seconds(work) -> float:
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun
