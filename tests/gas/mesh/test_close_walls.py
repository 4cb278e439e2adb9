"""Walls so close that sound crosses between them many times in a step, as in the folds of a bag."""

from __future__ import annotations

import numpy as np
import pytest

from billow.apps.verification.gas import boxes_in_a_row
from billow.apps.verification.mesh_gas import SCHEMES, books, carry, mesh_in, still
from billow.geometry.shapes.pose import quaternion_about, rotation_matrix
from billow.geometry.surface import Surface
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.ambient import InitialGas
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import OPENING, Passage


def layers(thicknesses, turn=None):
    """Layers [m] on each other, each open to the next over its whole width; turn: rotation in space (3, 3)."""
    bag, count = boxes_in_a_row(thicknesses), len(thicknesses)
    names = ("fabric", *(f"opening_wall_{k}" for k in range(1, count)))
    surface = Surface.build(
        bag.surface.triangles, bag.surface.part, names, len(bag.positions),
        ("fabric", *("opening",) * (count - 1)), bag.surface.chambers,
    )  # fmt: skip
    doors = tuple(
        Passage(f"door {k}", OPENING, ORIFICE, k - 1, k, triangles=surface.triangles_of(names[k]), area=0.06)
        for k in range(1, count)
    )
    positions = bag.positions if turn is None else bag.positions @ turn.T
    return Bag(surface, positions, np.zeros_like(positions)), doors


TURN = rotation_matrix(quaternion_about(np.array([0.36, 0.48, 0.8]), 0.9))


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(
    ("thicknesses", "pressures", "turn"),
    [
        ((4e-4, 4e-4), (1.2e5, 1e5), None), ((4e-4, 4e-4), (5e5, 1e5), TURN), ((4e-4, 2e-3), (5e5, 1e5), None),
        ((5e-3, 5e-3), (5e5, 1e5), None), ((4e-4, 4e-4, 4e-4), (1e5, 3e5, 1e5), TURN),
        ((5e-3, 5e-3, 5e-3), (1e5, 5e5, 1e5), None), ((4e-4,) * 4, (5e5, 1e5, 1e5, 1e5), None),
    ],
)  # fmt: skip
def test_layers_that_are_open_to_each_other_come_to_one_pressure(thicknesses, pressures, turn, scheme):
    """The mean of theirs by volume, since gas of one gamma keeps its energy; and then nothing moves."""
    bag, doors = layers(thicknesses, turn)
    count = len(thicknesses)
    inside = InitialGas(np.array(pressures), np.full(count, 300.0), np.ones((count, 1)))
    gas = mesh_in(bag, 0.03, scheme, passages=doors, initial=inside)
    state = gas.start(bag)
    for _ in still(gas, state, 2e-3):
        pass
    cells = gas.cells(state)
    np.testing.assert_allclose(cells["pressure"], np.average(pressures, weights=thicknesses), rtol=1e-3)
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
