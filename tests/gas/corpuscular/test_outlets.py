"""Outlets: the probability to pass makes the mass flow that of the law."""

from __future__ import annotations

import numpy as np
import pytest

from billow.gas.ambient import Ambient
from billow.gas.corpuscular.outlets import NO_PASSAGE, Outlets
from billow.gas.outflow import ORIFICE, orifice_flux
from billow.gas.passages import OPENING, VENT, Passage, Passages
from billow.gas.species import Species, thermo_table

R, GAMMA = 287.0, 1.4
TABLE = thermo_table([Species.ideal("ideal", R, GAMMA)])
OUTER = Ambient(1e5, 300.0, np.ones(1))
AREA = np.full(8, 0.01)


def regulated(passage, pressure, *, temperature=(600.0, 600.0), flux=None):
    """Probabilities, what is drawn in over 1 ms, and the incident flux; two chambers, gas at rest by default."""
    passages = Passages((passage,))
    outlets = Outlets.build(TABLE, passages, OUTER, len(AREA))
    pressure, temperature = np.array(pressure), np.array(temperature)
    incident = pressure / np.sqrt(2.0 * np.pi * R * temperature) if flux is None else np.array(flux)
    sides = [passage.behind, passage.ahead]
    wall = np.tile([pressure[c] if c >= 0 else 0.0 for c in sides], (len(AREA), 1))
    mass_flux = np.tile([incident[c] if c >= 0 else 0.0 for c in sides], (len(AREA), 1))
    chance, is_open = np.zeros(len(AREA)), np.zeros(1, np.bool_)
    drawn, _ = outlets.regulate(
        chance, is_open, passages.measure(np.zeros((8, 3), np.int64), np.zeros((1, 3)), None), AREA, wall, mass_flux,
        pressure, np.array([[1.0], [1.0]]), temperature, 0.0, 1e-3,
    )  # fmt: skip
    return chance, drawn[0], incident


def vent(**options):
    return Passage("vent", VENT, ORIFICE, 0, triangles=np.array([2, 3]), area=0.01, coefficient=0.7, **options)


@pytest.mark.parametrize("pressure", [1.001e5, 1.1e5, 1.5e5, 4e5])
def test_flow_through_a_vent_is_that_of_the_law(pressure):
    chance, drawn, incident = regulated(vent(), [pressure, 1e5])
    law = 0.7 * 0.01 * orifice_flux(pressure, 1e5, GAMMA, R * 600.0)
    assert (chance[2:4] @ AREA[2:4]) * incident[0] == pytest.approx(law, rel=1e-9)
    assert drawn == 0.0
    assert not chance[[0, 1, 4, 5, 6, 7]].any()


def test_a_choked_hole_passes_at_most_what_strikes_it():
    """A choked hole wants 0.6847/0.3989 times what strikes it at rest: until the gas flows towards it, all pass."""
    chance, _, _ = regulated(vent(), [4e5, 1e5], flux=[1.0, 1.0])
    assert (chance[2:4] == 1.0).all()


def test_air_is_drawn_in_where_the_surroundings_press_more():
    chance, drawn, _ = regulated(vent(), [0.9e5, 1e5])
    assert not chance.any()
    assert drawn == pytest.approx(1e-3 * 0.7 * 0.01 * orifice_flux(1e5, 0.9e5, GAMMA, R * 300.0), rel=1e-9)


def test_a_vent_opens_at_its_pressure():
    assert not regulated(vent(opens_at=2e4), [1.1e5, 1e5])[0].any()
    assert regulated(vent(opens_at=2e4), [1.3e5, 1e5])[0][2:4].all()


@pytest.mark.parametrize("pressure", [[1.5e5, 1.2e5], [1.2e5, 1.5e5]])
def test_net_flow_through_fabric_between_chambers(pressure):
    """Both sides are struck and pass alike: the net flow is P (incident from one side - that from the other)."""
    wall = Passage("wall", VENT, ORIFICE, 0, 1, triangles=np.array([2, 3]), area=2e-3)
    chance, _, incident = regulated(wall, pressure)
    law = 2e-3 * orifice_flux(max(pressure), min(pressure), GAMMA, R * 600.0)
    net = (chance[2:4] @ AREA[2:4]) * abs(incident[0] - incident[1])
    assert net == pytest.approx(law, rel=1e-9)


def test_an_opening_lets_all_pass():
    hole = Passage("hole", OPENING, ORIFICE, 0, 1, triangles=np.array([5]), area=0.01)
    chance, _, _ = regulated(hole, [1e5, 1e5])
    assert chance.tolist() == [0.0] * 5 + [1.0, 0.0, 0.0]
    outlets = Outlets.build(TABLE, Passages((hole,)), OUTER, len(AREA))
    assert outlets.passage.tolist() == [NO_PASSAGE] * 5 + [0, NO_PASSAGE, NO_PASSAGE]
