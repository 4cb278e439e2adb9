"""Outlets: the probability to pass makes the mass flow that of the law."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from billow.geometry.chambers import Chambers
from billow.parts.gas.corpuscular.outlets import NO_PASSAGE, Outlets
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.outflow import ORIFICE, orifice_flux
from billow.parts.gas.supply.passages import OPENING, VENT, Passage, Passages
from billow.parts.gas.supply.species import Species, thermo_table
from billow.parts.gas.supply.supply import Supply

R, GAMMA = 287.0, 1.4
TABLE = thermo_table([Species.ideal("ideal", R, GAMMA)])
OUTER = Ambient(1e5, 300.0, np.ones(1))
AREA = np.full(8, 0.01)
STRIP = np.arange(8)[:, None] + np.arange(3)
"""Triangles side by side; 0, 1, 4 and 5 touch a vent of 2 and 3."""


def regulated(
    passage, pressure, *, temperature=(600.0, 600.0), flux=None, at_walls=None, particle_mass=1e-9, short=0.0
):
    """Probabilities, what is drawn in over 1 ms, and the incident flux; two chambers, gas at rest by default.

    at_walls: triangle -> pressure [Pa] there, instead of the chamber's."""
    return _regulated(passage, pressure, temperature, flux, at_walls or {}, particle_mass, short)[:3]


def wanted(passage, pressure, **options):
    """Mass flow to the surroundings, whether enough strikes the vent or not."""
    return _regulated(passage, pressure, (600.0, 600.0), options.get("flux"), {}, 1e-9, 0.0)[3]


def _regulated(passage, pressure, temperature, flux, at_walls, particle_mass, short):
    outlets = outlets_of(passage)
    pressure, temperature = np.array(pressure), np.array(temperature)
    incident = pressure / np.sqrt(2.0 * np.pi * R * temperature) if flux is None else np.array(flux)
    sides = [passage.behind, passage.ahead]
    wall = np.tile([pressure[c] if c >= 0 else 0.0 for c in sides], (len(AREA), 1))
    mass_flux = np.tile([incident[c] if c >= 0 else 0.0 for c in sides], (len(AREA), 1))
    for triangle, felt in at_walls.items():
        wall[triangle, 0] = felt
    gas = SimpleNamespace(
        pass_probability=np.zeros(len(AREA)), is_open=np.zeros(1, np.bool_), short=np.array([short]),
        bank=SimpleNamespace(pressure=wall, mass_flux=mass_flux), pressure=pressure, masses=np.array([[1.0], [1.0]]),
        temperature=temperature, gas_time=0.0, owed=np.zeros((1, 1)),
    )  # fmt: skip
    areas = outlets.supply.passages.measure(np.zeros((8, 3), np.int64), np.zeros((1, 3)), None)
    outlets.regulate(gas, areas, AREA, np.full(2, particle_mass), 4e-4, 1e-3)
    return gas.pass_probability, gas.owed[0, 0], incident, gas.wanted[0]


def outlets_of(passage):
    chambers = Chambers.single(len(STRIP))
    return Outlets.build(Supply(TABLE, ("ideal",), (), OUTER, chambers, Passages((passage,))), STRIP)


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
    """A choked hole wants 0.6847/0.3989 times what strikes it at rest: until the gas flows towards it, all pass, and
    the law's flow is still wanted."""
    chance, _, _ = regulated(vent(), [4e5, 1e5], flux=[1.0, 1.0])
    assert (chance[2:4] == 1.0).all()
    law = 0.7 * 0.01 * orifice_flux(4e5, 1e5, GAMMA, R * 600.0)
    assert wanted(vent(), [4e5, 1e5], flux=[1.0, 1.0]) == pytest.approx(law, rel=1e-12)
    assert wanted(vent(), [0.9e5, 1e5]) == 0.0


def test_what_a_vent_is_short_of_leaves_within_the_window():
    calm, _, incident = regulated(vent(), [1.1e5, 1e5])
    more, _, _ = regulated(vent(), [1.1e5, 1e5], short=1e-5)
    less, _, _ = regulated(vent(), [1.1e5, 1e5], short=-1.0)
    assert ((more - calm)[2:4] @ AREA[2:4]) * incident[0] * 4e-4 == pytest.approx(1e-5, rel=1e-9)
    assert not less.any()


def test_a_vent_feels_a_jet_on_the_fabric_around_it():
    """By many hits; by few it may be noise, and what strikes the vent itself streams out anyway."""
    jet = dict.fromkeys((0, 1, 4, 5), 1.5e5)
    law = 0.7 * 0.01 * orifice_flux(1.5e5, 1e5, GAMMA, R * 600.0)
    calm = 0.7 * 0.01 * orifice_flux(1.2e5, 1e5, GAMMA, R * 600.0)

    def flow(**options):
        chance, _, incident = regulated(vent(), [1.2e5, 1e5], **options)
        return (chance[2:4] @ AREA[2:4]) * incident[0]

    assert flow(at_walls=jet) == pytest.approx(law, rel=1e-9)
    struck = 4e-4 * 0.04 * 1.2e5 / np.sqrt(2.0 * np.pi * R * 600.0)  # kg, around it in the window
    for hits, felt in ((530.0, law), (490.0, calm)):  # 1.5e5 is a quarter more: 5.09 and 4.9 standard deviations
        assert flow(at_walls=jet, particle_mass=struck / hits) == pytest.approx(felt, rel=1e-9)
    assert flow(at_walls={2: 1.5e5, 3: 1.5e5, 6: 1.5e5, 7: 1.5e5}) == pytest.approx(calm, rel=1e-9)


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
    assert outlets_of(hole).passage.tolist() == [NO_PASSAGE] * 5 + [0, NO_PASSAGE, NO_PASSAGE]


@pytest.mark.parametrize("drift", [0.0, 0.5, 1.18, 3.0])
def test_missing_heat_is_that_of_a_drifting_maxwellian(drift):
    """Against the integrals of v f, v^2 f and v^3 f themselves."""
    v = np.linspace(0.0, drift + 12.0, 200_001)
    f = np.exp(-0.5 * (v - drift) ** 2) / np.sqrt(2.0 * np.pi)
    first, second, third = (np.trapezoid(v**k * f, v) for k in (1, 2, 3))
    outflow, carried = 2.5 + 0.5 * drift**2, 1.0 + 0.5 * third / first
    flux = np.full((8, 2), 3.0)
    pressure = 2.0 * flux * second / first * np.sqrt(R * 600.0)
    bank = SimpleNamespace(pressure=pressure, mass_flux=flux)
    gas = SimpleNamespace(bank=bank, masses=np.ones((1, 1)), temperature=np.full(1, 600.0))
    missing = outlets_of(vent()).missing_heat(gas, AREA)
    assert missing == pytest.approx([outflow - carried], abs=1e-6)
