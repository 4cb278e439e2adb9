"""What `billow check` expects a run to cost is what it costs, within a factor of two."""

from __future__ import annotations

import re
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
