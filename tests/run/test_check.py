"""What `billow check` expects a run to cost is what it costs, within a factor of two."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from billow.case.schema import Case
from billow.run.check import describe

EXAMPLES = Path(__file__).parents[2] / "examples"


def expected_seconds(case: Case) -> float:
    return float(re.search(r"run time  about (\d+) s", describe(case))[1])


def flat_bag(**gas) -> Case:
    return Case.from_dict({"bag": {"element_size": 0.03}, "gas": {"model": "corpuscular"} | gas})


def test_a_bag_with_250_000_particles():
    """Example 6.1 of the LS-DYNA paper, 31,224 triangles: 509 s on one core of an AMD EPYC, measured once."""
    assert 0.5 < expected_seconds(Case.load(EXAMPLES / "paper" / "flat_driver_particles.toml")) / 509.0 < 2.0


def test_particles_and_their_switch_are_counted():
    """Flight is nearly all the cost of 60,000 particles, a fifth of which is left when they fly for a fifth of the run.

    Measured on a slower core: 70 s with 60,000 for 30 ms, 27 s with 20,000, 9 to 11 s with 2,000.
    """
    few, many = (expected_seconds(flat_bag(particles=count)) for count in (2000, 60000))
    assert many / few == pytest.approx(7.0, rel=0.5)
    end = flat_bag().run.end_time
    assert expected_seconds(flat_bag(particles=60000, switch_time=0.2 * end)) < 0.5 * many


HELD = """
import json, sys
from billow.case.schema import Case
from billow.results.machine import peak_memory
from billow.run.simulate import simulate
simulate(Case.from_dict(json.loads(sys.argv[1])), sys.argv[2], threads=1)
print(peak_memory())
"""


@pytest.mark.parametrize(
    "gas", [{"model": "uniform-pressure"}, {"model": "corpuscular", "particles": 200_000}], ids=lambda gas: gas["model"]
)
def test_memory_is_what_a_process_holds(gas, tmp_path):
    """A process that has its kernels; compiling takes more."""
    case = {"bag": {"element_size": 0.02}, "gas": gas, "run": {"end_time": 1e-5, "frames": 1}}
    for folder in (tmp_path / "first", tmp_path / "second"):
        told = subprocess.run(
            [sys.executable, "-c", HELD, json.dumps(case), str(folder)], check=True, capture_output=True, text=True
        )
    stated = float(re.search(r"needs     about (\d+) MB of memory", describe(Case.from_dict(case)))[1])
    assert 0.5 * stated < float(told.stdout) < 1.2 * stated
