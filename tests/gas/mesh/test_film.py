"""Friction in films beyond the closed forms of M8: where there is none, and how hard it may brake."""

from __future__ import annotations

import numpy as np
import pytest

from billow.case.build import build_model
from billow.case.schema import Case
from billow.parts.gas.mesh.film import find_drag
from billow.parts.gas.mesh.patches import AREA, COLUMNS, SIDE, SPEED
from billow.parts.gas.mesh.thermodynamics import RHO, P, T, U, Y

H = 0.02


def drag_on(normals, areas, volume, velocity, walls=0.0, dt=1e-6):
    """Of gas with a velocity along x in a single cluster between these patches; walls: their speed along x."""
    rows, state = np.zeros((len(areas), COLUMNS)), np.zeros((1, Y + 1))
    rows[:, SIDE : SIDE + 3], rows[:, AREA], rows[:, SPEED] = normals, areas, walls
    state[0, [RHO, P, T, U]] = 1.2, 1e5, 300.0, velocity
    own = np.zeros(len(areas), np.int64)
    return find_drag(own, rows, np.ones(len(areas), bool), state, np.array([volume]), H, dt)


UP, DOWN, SIDEWAYS = [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]


def test_a_case_can_ask_for_it():
    for asked in (False, True):
        case = Case.from_dict(
            {"bag": {"element_size": 0.1}, "gas": {"model": "mesh", "cell": 0.1, "film_friction": asked}}
        )
        assert build_model(case).gas.model.film_friction is asked


@pytest.mark.parametrize(
    ("normals", "areas", "volume"),
    [([UP], [1.0], 0.05), ([UP, SIDEWAYS], [0.3, 0.3], 0.09), ([UP, DOWN], [1.0, 1.0], 1.2)],
    ids=["one wall", "a corner", "walls farther apart than a cell"],
)
def test_no_film_no_friction(normals, areas, volume):
    found = drag_on(normals, areas, volume, 10.0)
    assert len(found.patches) == 0


def test_a_film_stops_at_most():
    """0.02 mm between walls, in a part of a step of 0.1 ms: what it has of momentum, and no more."""
    dt, volume = 1e-4, 1e-3
    found = drag_on([UP, DOWN], [1.0, 1.0], volume, 10.0, dt=dt)
    impulse = dt * H**2 * found.traction.sum(axis=0)
    np.testing.assert_allclose(impulse, [1.2 * volume * H**3 * 10.0, 0.0, 0.0], rtol=1e-12)


def test_gas_that_moves_with_its_walls_feels_nothing():
    found = drag_on([UP, DOWN], [1.0, 1.0], 0.05, 10.0, walls=10.0)
    assert len(found.patches) == 2
    np.testing.assert_allclose(found.traction, 0.0, atol=1e-15)
