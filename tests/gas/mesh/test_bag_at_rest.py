"""A flat bag with open vents before its inflator fires: nothing happens."""

from __future__ import annotations

import pytest

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.solver.run import run

VENTS = {"count": 2, "diameter": 0.05}


@pytest.mark.parametrize(("cell", "scheme"), [(0.05, "van_leer"), (0.05, "donor"), (0.03, "van_leer")])
def test_air_at_rest_does_not_pump_up_a_flat_bag_through_its_vents(cell, scheme):
    """Through a hole of 50 mm over a layer of 2 mm flows, in one part of a step, more than lifts the pressure there to
    that outside. By the flow at the start of each part the bag grew by a fifth."""
    case = Case.from_dict(
        {
            "bag": {
                "diameter": 0.6,
                "element_size": 0.05,
                "vents": {"count": 2, "diameter": 0.05},
                "straps": {"count": 0},
            },
            "gas": {"model": "mesh", "cell": cell, "advection": scheme},
            "inflator": {"delay": 0.01},
            "obstacles": [],
            "run": {"end_time": 0.0015, "frames": 1},
        }
    )
    model = build_model(case)
    state = run(model, build_schedule(case.run))
    gas = model.gas.totals(state.gas)
    assert gas.volume == pytest.approx(model.surface.volume(model.start), rel=1e-3)
    assert gas.drawn_in < 1e-3 * gas.mass
    assert gas.mass_error < 1e-12


@pytest.mark.parametrize("permeability", [0.03, 0.3])
def test_air_at_rest_stays_at_rest_in_porous_fabric(permeability):
    """Near the seam two sheets lie so close that a few pascals let through, in one part of a step, more than makes the
    pressures equal: the fabric was shaken, and with the larger permeability the run stopped."""
    case = Case.from_dict(
        {
            "bag": {"element_size": 0.03},
            "fabric": {"permeability": permeability},
            "gas": {"model": "mesh", "cell": 0.03},
            "inflator": {"delay": 0.01},
            "obstacles": [],
            "run": {"end_time": 0.004, "frames": 1},
        }
    )
    model = build_model(case)
    state = run(model, build_schedule(case.run))
    assert model.gas.totals(state.gas).volume == pytest.approx(model.surface.volume(model.start), rel=1e-3)
    assert state.ledger["kinetic"] < 2e-5
