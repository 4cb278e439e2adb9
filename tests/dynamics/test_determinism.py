"""Same case, same bits: twice, with any number of threads, and across a copy of the state."""

from __future__ import annotations

import copy
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from free_scene import EachStep, fingerprint, free_model

from billow.case.build import build_model
from billow.solver.run import Schedule, run

SCHEDULE = Schedule(0.009, 3, 2)  # past the moment when the bag reaches the impactor


@pytest.fixture(scope="module")
def straight(small_case):
    """The last state of the small case, run through."""
    return run(build_model(small_case), SCHEDULE)


def test_twice(small_case, straight):
    assert fingerprint(run(build_model(small_case), SCHEDULE)) == fingerprint(straight)
    assert straight.bodies.contact.force[1].any()


@pytest.mark.parametrize("at_step", [1, 137])
def test_a_copied_state_goes_on_with_the_same_bits(small_case, straight, at_step):
    model, copies = build_model(small_case), []

    def step(model, state):
        if state.step == at_step:
            copies.append(copy.deepcopy(state))

    run(model, SCHEDULE, EachStep(step))
    before = fingerprint(copies[0])
    final = run(build_model(small_case), SCHEDULE, state=copy.deepcopy(copies[0]))
    assert fingerprint(final) == fingerprint(straight)
    assert fingerprint(copies[0]) == before != fingerprint(straight)


def test_the_fingerprint_sees_a_single_bit():
    model = free_model()
    state = run(model, Schedule(1e-4, 1, 1))
    before = fingerprint(state)
    for array in (state.positions, state.velocities, state.nodal_force, state.bodies.motion[0].quaternion):
        old = array.flat[3]
        array.flat[3] = np.nextafter(old, np.inf)
        assert fingerprint(state) != before
        array.flat[3] = old
    energies = state.ledger.energies
    energies["friction"] = np.nextafter(energies["friction"], 1.0)
    assert fingerprint(state) != before


def test_one_thread_and_two():
    """Two threads take the parallel compilation of every kernel, one thread the serial one."""
    done = subprocess.run(
        [sys.executable, Path(__file__).with_name("run_with_threads.py"), "1", "2"],
        env={**os.environ, "NUMBA_NUM_THREADS": "2"},
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    one, two = (line.split() for line in done.stdout.splitlines())
    assert (one[0], two[0]) == ("1", "2")
    assert one[1:] == two[1:]
    assert one[2] == "True"  # the obstacle was touched
