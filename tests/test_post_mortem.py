"""A run that had to be stopped leaves what is needed to find out why."""

from __future__ import annotations

import json

import numpy as np
import pytest

from billow.base.errors import NumericalStop
from billow.case.build import build_model
from billow.results.result import Result
from billow.run.checkpoint_file import read_checkpoint
from billow.run.recorder import LAST_GOOD
from billow.run.simulate import simulate
from billow.solver import run as time_loop

SICK_NODE, SICK_STEP = 100, 400


@pytest.fixture
def stopped(small_case, tmp_path, monkeypatch):
    healthy = time_loop.advance

    def sick(model, state, dt):
        healthy(model, state, dt)
        if state.step == SICK_STEP:
            state.velocities[SICK_NODE] = np.nan

    monkeypatch.setattr(time_loop, "advance", sick)
    with pytest.raises(NumericalStop, match="E-NUM-001"):
        simulate(small_case, tmp_path / "run")
    return tmp_path / "run"


def test_the_post_mortem_names_the_node_and_its_surroundings(stopped):
    record = json.loads((stopped / "postmortem.json").read_text())
    assert record["code"] == "E-NUM-001"
    assert SICK_NODE in record["nodes"]
    assert SICK_NODE in [place["node"] for place in record["surroundings"]]
    assert len(record["surroundings"]) > 5
    assert len(record["last_steps"]["rows"]) == 100
    assert Result.open(stopped).status == "stopped"


def test_the_last_good_state_is_whole(stopped, small_case):
    state = read_checkpoint(stopped / LAST_GOOD, build_model(small_case), small_case.digest()).state
    assert 0 < state.step < SICK_STEP
    assert state.time == pytest.approx(Result.open(stopped).times[-1])
    assert np.isfinite(state.velocities).all()
