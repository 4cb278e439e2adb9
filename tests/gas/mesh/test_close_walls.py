"""Walls so close that sound crosses between them many times in a step, as in the folds of a bag."""

from __future__ import annotations

import numpy as np
import pytest

from billow.apps.verification.gas import boxes_in_a_row
from billow.apps.verification.mesh_gas import SCHEMES, books, carry, mesh_in, still
from billow.geometry.surface import Surface
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.ambient import InitialGas
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import OPENING, Passage


def layers(thicknesses):
    """Two layers [m] on each other, open to each other over their whole width."""
    bag = boxes_in_a_row(thicknesses)
    surface = Surface.build(
        bag.surface.triangles, bag.surface.part, ("fabric", "opening_wall_1"), len(bag.positions),
        ("fabric", "opening"), bag.surface.chambers,
    )  # fmt: skip
    door = Passage("door", OPENING, ORIFICE, 0, 1, triangles=surface.triangles_of("opening_wall_1"), area=0.06)
    return Bag(surface, bag.positions, np.zeros_like(bag.positions)), door


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("pressure", [1.2e5, 5e5])
@pytest.mark.parametrize("thicknesses", [(4e-4, 4e-4), (4e-4, 2e-3), (5e-3, 5e-3)])
def test_layers_that_are_open_to_each_other_come_to_one_pressure(thicknesses, pressure, scheme):
    """The mean of theirs by volume, since gas of one gamma keeps its energy; and then nothing moves."""
    bag, door = layers(thicknesses)
    inside = InitialGas(np.array([pressure, 1e5]), np.array([400.0, 300.0]), np.ones((2, 1)))
    gas = mesh_in(bag, 0.03, scheme, passages=(door,), initial=inside)
    state = gas.start(bag)
    mean = np.average([pressure, 1e5], weights=thicknesses)
    for _ in still(gas, state, 1.5e-3):
        pass
    cells = gas.cells(state)
    np.testing.assert_allclose(cells["pressure"], mean, rtol=1e-3)
    assert np.abs(cells["velocity"]).max() < 1.0
    for check in books(state):
        assert abs(check.measured - check.expected) <= check.tolerance, check.title


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("mach", [0.1, 1.0, 4.0])
def test_gas_that_meets_close_walls_stops(mach, scheme):
    """However fast it is: it is not thrown back. Its motion becomes heat."""
    bag = boxes_in_a_row((4e-4,))
    gas = mesh_in(bag, 0.03, scheme)
    state = gas.start(bag)
    sound = float(state.sheets[0].sound.max())
    carry(state, np.array([mach * sound, 0.0, 0.0]))
    next(still(gas, state, 1.0))
    assert np.abs(gas.cells(state)["velocity"][:, 0]).max() < 0.2 * mach * sound
    for check in books(state):
        assert abs(check.measured - check.expected) <= check.tolerance, check.title
