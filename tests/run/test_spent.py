"""What a run costs counts what it took before it was resumed."""

from __future__ import annotations

import pytest

from billow.case.build import build_model
from billow.run.checkpoint_file import SLOTS, read_checkpoint, write_checkpoint
from billow.run.interrupts import STOP_FILE, RunInterrupted
from billow.run.simulate import resume, simulate
from billow.run.spent import Spent, Stopwatch


def test_a_resumed_run_cost_all_its_sittings(small_case, tmp_path):
    case, partial = small_case.vary({"run.end_time": 0.004}), tmp_path / "run.partial"
    with pytest.raises(RunInterrupted):
        simulate(case, tmp_path / "run", progress=lambda _: (partial / STOP_FILE).touch(), threads=1)
    start = read_checkpoint(partial / SLOTS[0], build_model(case), case.digest())
    assert 0.0 < start.spent.wall < 60.0
    assert start.spent.processor > 0.0
    write_checkpoint(partial / SLOTS[0], start._replace(spent=Spent(500.0, 300.0)), case.digest())
    record = resume(tmp_path / "run", threads=1).record
    assert 500.0 < record["wall_seconds"] < 600.0
    assert 300.0 < record["processor_seconds"] < 400.0


def test_a_stopwatch_goes_on_from_what_was_spent():
    spent = Stopwatch(Spent(10.0, 4.0)).spent
    assert spent.wall >= 10.0
    assert spent.processor >= 4.0
