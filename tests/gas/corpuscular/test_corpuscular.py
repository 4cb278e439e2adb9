"""The whole corpuscular gas in a box: books, the start, and caches that may be lost."""

from __future__ import annotations

import numpy as np
import pytest

from billow.gas.outflow import ORIFICE
from billow.gas.passages import VENT, Passage
from billow.verification.gas import HEIGHT, IDEAL, VOLUME, bag_of_height, inflow
from billow.verification.particles import LID, in_a_box, over_walls, steps

WHOLE = np.ones(1)


def blowing(passages=(), outside=1e5):
    flow = inflow(1.0, 0.002, 600.0, WHOLE)
    return in_a_box(IDEAL, 2000, 1e5, 300.0, inflator=flow, passages=passages, outside=outside)


def test_gas_starts_at_its_pressure_everywhere():
    """To the nearest particle, and to the share of flight in its energy: 4 x 0.52/sqrt(N)."""
    gas = in_a_box(IDEAL, 4000, 1.2e5, 350.0)
    state = gas.start(bag_of_height(HEIGHT))
    assert state.temperature[0] == pytest.approx(350.0, rel=1e-10)
    assert state.pressure[0] == pytest.approx(1.2e5, rel=4.0 * 0.52 / np.sqrt(4000))
    assert over_walls(state.bank.pressure[:, 0]) == pytest.approx(state.pressure[0], rel=1e-12)
    assert np.abs(state.start_momentum).max() < 1e-12


@pytest.mark.parametrize("outside", [1e5, 5e5])
def test_books_close_while_the_lid_moves_and_gas_goes_both_ways(outside):
    hole = Passage("hole", VENT, ORIFICE, 0, triangles=LID, area=2e-3)
    gas = blowing((hole,), outside)
    state = gas.start(bag_of_height(HEIGHT))
    for _ in steps(gas, state, 150, 4e-5, lambda t: HEIGHT * (1.0 + 0.1 * np.sin(600.0 * t))):
        pass
    assert state.mass_error < 1e-12
    assert state.energy_error < 1e-9
    assert state.momentum_error < 1e-11
    assert state.escaped == 0
    if outside > 1e5:
        assert state.drawn.sum() > 0.0
    else:
        assert state.left.sum() > 0.0


def test_an_evacuated_box_takes_the_first_particles():
    gas = in_a_box(IDEAL, 1000, 1e-9, 300.0, inflator=inflow(1.0, 0.003, 600.0, WHOLE))
    state = gas.start(bag_of_height(HEIGHT))
    assert state.particles.count == 0
    for _ in steps(gas, state, 240, 5e-5):  # until the jet has come to rest
        pass
    assert state.particles.count == pytest.approx(1000, abs=1)
    assert state.temperature[0] == pytest.approx(840.0, rel=3e-3)  # the last particle may be missing
    assert state.volume[0] == pytest.approx(VOLUME, rel=1e-14)


def test_caches_are_made_anew_with_the_same_bits():
    def end(forget):
        gas = blowing()
        state = gas.start(bag_of_height(HEIGHT))
        for k, _ in enumerate(steps(gas, state, 60, 4e-5)):
            if forget and k in (13, 30):
                state.grid = state.hits = state.sums = state.patches = None
        n = state.particles.count
        return state.particles.position[:n].tobytes() + state.load.force.tobytes()

    assert end(True) == end(False)
