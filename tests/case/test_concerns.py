"""What looks unintended of a case is told whatever gas model it names."""

from __future__ import annotations

import pytest

from billow.case.build import build_model
from billow.case.concerns import concerns_of
from billow.case.schema import Case

GASES = {
    "uniform pressure": {"model": "uniform-pressure"},
    "particles": {"model": "corpuscular", "particles": 1000},
    "particles, then uniform": {"model": "corpuscular", "particles": 1000, "switch_time": 0.02},
}
ODD = {
    "W-GAS-001": {"run.end_time": 0.002},
    "W-GAS-002": {"inflator.mass_flow": {"time": [0, 2e-5, 8e-5], "value": [0, 100.0, 0]}},
    "W-GAS-003": {"inflator.mass_flow": {"time": [0, 0.008, 0.05], "value": [0, 0.0125, 0]}},
    "W-GAS-004": {"fabric.permeability": 10.0},
    "W-GAS-005": {"bag.vents.opening_pressure": 0.3},
    "W-GAS-006": {"inflator.jets.ring_radius": 0.1},
    "W-GAS-007": {"gas.initial.pressure": 2e4},
}
COARSE = {"bag": {"element_size": 0.06, "initial_gap": 0.01}}


@pytest.mark.parametrize("gas", GASES)
@pytest.mark.parametrize("code", ODD)
def test_a_slip_of_the_supply_is_noticed_with_every_gas(code, gas):
    sound = Case.from_dict(COARSE | {"gas": GASES[gas]})
    assert code not in [concern.code for concern in concerns_of(sound, build_model(sound))]
    odd = sound.vary(ODD[code])
    assert code in [concern.code for concern in concerns_of(odd, build_model(odd))]


@pytest.mark.parametrize("law", ["linear", "curves", "curves-shear"])
def test_a_density_in_another_unit_is_noticed_with_every_law(law):
    """The fabric would weigh 15 g/m^2: this is asked of every fabric."""
    case = Case.from_dict(COARSE | {"fabric": {"law": law, "density": 50.0, "thickness": 3e-4}})
    assert "W-FAB-002" in [concern.code for concern in concerns_of(case, build_model(case))]


@pytest.mark.parametrize("chamber", ["mouth", "first", "chamber_1"])
def test_the_chamber_an_inflator_blows_into_can_be_named_as_the_reference_says(chamber):
    bag = {"shape": "rectangular", "length": 0.6, "width": 0.3, "chambers": 2, "element_size": 0.06}
    model = build_model(Case.from_dict({"bag": bag, "inflator": {"chamber": chamber}}))
    assert model.gas.supply.sources[0].inflator.chamber == 0
