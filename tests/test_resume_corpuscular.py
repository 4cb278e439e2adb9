"""A run with the corpuscular gas: the same bits twice, with one thread and two, and after it was stopped half-way."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from run_fingerprint import fingerprint

from billow.case.build import build_model
from billow.run.simulate import simulate
from billow.solver.checkpoint import flatten, restore
from billow.solver.model import start_state


@pytest.fixture(scope="module")
def brief(small_case):
    """Jets, vents, porous fabric and two obstacles for 2 ms; the gap holds some 500 particles of air."""
    return small_case.vary(
        {"gas.model": "corpuscular", "gas.particles": 5000, "bag.initial_gap": 0.04, "run.end_time": 0.002}
    )


@pytest.fixture(scope="module")
def straight(brief, tmp_path_factory):
    return simulate(brief, tmp_path_factory.mktemp("straight") / "run", threads=1)


def test_twice(brief, straight, tmp_path):
    again = simulate(brief, tmp_path / "run", threads=1)
    assert fingerprint(again.folder) == fingerprint(straight.folder)


def test_stopped_half_way_and_resumed(in_two, brief, straight, tmp_path):
    resumed = in_two(brief, tmp_path / "run")
    assert fingerprint(resumed.folder) == fingerprint(straight.folder)
    assert resumed.record["ledger"] == straight.record["ledger"]


def test_a_checkpoint_may_hold_more_particles_than_a_fresh_state_has_room_for(brief):
    model = build_model(brief)
    grown = start_state(model)
    grown.gas.content.particles.make_room(2 * grown.gas.content.particles.capacity)
    arrays, numbers = flatten(grown)
    restored = restore(start_state(model), arrays, numbers)
    assert restored.gas.content.particles.capacity == grown.gas.content.particles.capacity
    for path in ("gas.content.pool", "gas.content.particles.position"):  # other shapes are refused
        wrong = arrays | {path: np.zeros((7, 2))}
        with pytest.raises(ValueError, match=path):
            restore(start_state(model), wrong, numbers)


def test_one_thread_and_two():
    """Two threads take the parallel compilation of every kernel that has one, and so does one thread here."""
    script = Path(__file__).parent / "dynamics" / "run_particles_with_threads.py"
    done = subprocess.run(
        [sys.executable, script, "1", "2"],
        env={**os.environ, "NUMBA_NUM_THREADS": "2"},
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    one, two = (line.split() for line in done.stdout.splitlines())
    assert (one[0], two[0]) == ("1", "2")
    assert one[1:] == two[1:]
    assert int(one[2]) > 10
