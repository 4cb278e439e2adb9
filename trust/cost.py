"""What ledger, guards and checkpoints cost: a run with them against the same run without, in one process."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numba
import numpy as np

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.checkpoint_file import write_checkpoint
from billow.dynamics import run as time_loop
from billow.dynamics import step
from trust.scenes import PLATE, Listener

REPEATS = 5


def share() -> float:
    """(time with - time without) / time without, median over pairs, one thread."""
    numba.set_num_threads(1)
    case = Case.from_dict(
        {"obstacles": [PLATE, {"shape": "super-ellipsoid"}], "run": {"end_time": 0.012, "frames": 12}}
    )
    model, schedule = build_model(case), build_schedule(case.run)
    ratios = []
    for _ in range(REPEATS):
        careful = _seconds(lambda: time_loop.run(model, schedule, Listener(_saver(case))))
        checks = time_loop.check_state, step.close_ledger
        time_loop.check_state = step.close_ledger = lambda *arguments: None
        try:
            careless = _seconds(lambda: time_loop.run(model, schedule, Listener()))
        finally:
            time_loop.check_state, step.close_ledger = checks
        ratios.append(careful / careless - 1.0)
    return float(np.median(ratios))


def _saver(case: Case):
    folder = Path(tempfile.mkdtemp())
    steps = 0

    def save(state) -> None:
        nonlocal steps
        steps += 1
        if steps % 700 == 0:
            write_checkpoint(folder / "checkpoint.safetensors", state, case.digest(), 0)

    return save


def _seconds(work) -> float:
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun
