"""Between two steps of the particles the walls move on: the gas must answer them all the same."""

from __future__ import annotations

import numpy as np
import pytest

from billow.apps.verification.gas import GAMMA, IDEAL
from billow.apps.verification.particles import LID, in_a_box
from billow.apps.verification.scenes import bag_of_height
from billow.parts.part import Loads

PRESSURE = 1.5e5
FLAT = 0.03


def test_walls_that_close_in_meet_the_adiabatic_pressure_in_every_step():
    """A flat box loses 0.1 % of its height in each step of the structure, and its particles move in every eighth step
    at most. The push on the lid must rise by d(p A) = -gamma p A dV/V in each step, not in jumps: its median rise is
    compared, which the noise of the particles' own steps does not touch.
    """
    gas = in_a_box(IDEAL, 4000, PRESSURE, 300.0, FLAT, outside=PRESSURE)
    state = gas.start(bag_of_height(FLAT))
    dt, closing = 1e-6, 1e-3
    push = []
    for step in range(41):
        bag = bag_of_height(FLAT * (1.0 - closing) ** max(step, 1))
        bag.velocities[bag.positions[:, 2] > 0.0, 2] = -closing * bag.positions[:, 2].max() / dt
        loads = Loads(0, bag.surface)
        gas.advance(state, bag, step * dt, dt, loads)
        push.append(loads.corner_force[LID, :, 2].sum())
    area = np.ptp(bag.positions[:, 0]) * np.ptp(bag.positions[:, 1])
    rise = np.median(np.diff(push)) / (PRESSURE * area)
    assert rise == pytest.approx(GAMMA * closing, rel=0.15)
