"""What gas that comes to a hole loses on the way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from billow.geometry.lattice_clipping import COLUMNS, NORMAL
from billow.parts.gas.mesh.passages import _throttled
from billow.parts.gas.mesh.thermodynamics import RHO, P, Y


@pytest.mark.parametrize(("discharge", "at_hole", "share"), [
    (0.7, 1.0, 1.0), (0.7, 0.51, 1.0), (0.7, 0.255, 0.5), (0.7, 0.0, 0.0), (0.7, -0.2, 0.0), (1.0, 0.0, 1.0),
])  # fmt: skip
@pytest.mark.parametrize("forth", [True, False])
def test_only_what_bernoulli_does_not_explain_is_a_loss(discharge, at_hole, share, forth):
    """Gas of 120 kPa before an orifice to 100 kPa keeps 1 - Cd^2 of its lead there."""
    outside, lead, density = 1e5, 2e4, 1.2
    rows, fragments = np.zeros((2, COLUMNS)), np.arange(2)
    rows[:, NORMAL] = 0.3, 0.1

    def side(pressure, coming):
        state, gas = np.zeros((1, Y + 1)), np.zeros(P + 1)
        state[0, P], gas[P], gas[RHO] = pressure, coming, density
        return state, state, np.ones(1), np.zeros(2, np.int32), gas, fragments.astype(np.int32), np.zeros(2)

    bag, out = side(outside + at_hole * lead, outside + lead), side(outside, outside)
    flux = discharge * math.sqrt(2.0 * density * lead)
    found = _throttled(*((bag, out) if forth else (out, bag)), rows, fragments, flux)
    assert found == pytest.approx(share, abs=1e-9)
