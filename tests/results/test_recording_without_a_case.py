"""A model that comes from no case file is run and recorded like any other."""

from __future__ import annotations

import numpy as np

from billow.apps.coupon.bench import build_model
from billow.apps.coupon.specimen import Strip
from billow.parts.fabric.linear_law import LinearFabric
from billow.results.histories import read_histories
from billow.results.run_file import read_run_file
from billow.run.interrupts import Interrupts
from billow.run.recorder import RunRecorder, Told
from billow.solver.run import Schedule, run


def test_a_strip_on_the_bench_leaves_a_run_folder(tmp_path):
    fabric = LinearFabric(800.0, 0.3e-3, 0.40e9, 0.35e9, 0.0, 10e6, compression=False, damping=0.05)
    model = build_model(Strip(0.2, 0.05, 0.0125, "warp"), fabric, lambda time: 0.05 * time / 0.005)
    told = Told(title="A strip", digest="0" * 64, schedule=Schedule(0.005, 2, 5))
    (tmp_path / "case.toml").write_text('title = "A strip"\n', encoding="utf-8")  # every run folder says what was run
    with Interrupts(tmp_path) as interrupts:
        recorder = RunRecorder(told, model, tmp_path, interrupts)
        recorder.greet()
        state = run(model, told.schedule, recorder)
        recorder.finish("completed", None)
    history, record = read_histories(tmp_path / "histories.csv"), read_run_file(tmp_path)
    assert len(history.time) == 11
    assert history.energy("strain")[-1] == state.ledger["strain"] > 0.0
    assert record["quality"]["verdict"] == "PASS"
    assert np.isfinite(list(record["ledger"].values())).all()
