"""From the tables of the gas to its passages, inflators and species: what was written is what flows."""

from __future__ import annotations

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.gas.build_gas import build_gas
from billow.case.schema import Case
from billow.geometry.chambers import OUTSIDE
from billow.geometry.flat_cut import flat_area
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.mixture import mixture_enthalpy, species_cp
from billow.parts.gas.supply.outflow import ORIFICE, PERMEABILITY, POROUS_MEDIUM
from billow.parts.gas.supply.passages import FABRIC, OPENING, VENT
from billow.parts.part import Loads

SMALL = {"element_size": 0.05}
TWO_CHAMBERS = {"shape": "rectangular", "chambers": 2, "element_size": 0.05, "vents": {"chambers": [2]}}


def built(**tables):
    case = Case.from_dict({"bag": SMALL} | tables)
    shape = build_shape(case.bag)
    return build_gas(case, shape).model, shape


def rows(gas):
    return {row.name: row for row in gas.supply.passages.rows}


def test_a_driver_bag_has_its_panels_and_vents():
    gas, shape = built(fabric={"permeability": 0.03})
    found = rows(gas)
    assert {name: row.kind for name, row in found.items()} == {
        "front": FABRIC, "rear": FABRIC, "vent_1": VENT, "vent_2": VENT,
    }  # fmt: skip
    assert all((row.behind, row.ahead) == (0, OUTSIDE) for row in found.values())
    area = flat_area(shape.reference)
    for name, row in found.items():
        assert row.area == pytest.approx(area[shape.surface.triangles_of(name)].sum(), rel=1e-12)
    assert found["vent_1"].area == pytest.approx(np.pi * 0.0175**2, rel=1e-9)
    assert (found["front"].law, found["front"].coefficient) == (PERMEABILITY, 0.03)
    assert (found["vent_1"].law, found["vent_1"].coefficient, found["vent_1"].through_blocked) == (ORIFICE, 0.7, 1.0)


def test_coated_panels_do_not_leak():
    gas, _ = built(bag=SMALL | {"coated": ["front"]}, fabric={"permeability": 0.03})
    assert rows(gas)["front"].area == 0.0
    assert rows(gas)["rear"].area > 0.0


def test_chambers_are_joined_by_openings_and_named_in_the_passages():
    gas, _ = built(bag=TWO_CHAMBERS, gas={"opening_discharge": 0.8})
    found = rows(gas)
    assert set(found) == {f"{p}_chamber_{k}" for p in ("front", "rear") for k in (1, 2)} | {"opening_1", "vent_1"}
    opening = found["opening_1"]
    assert (opening.kind, {opening.behind, opening.ahead}, opening.coefficient) == (OPENING, {0, 1}, 0.8)
    assert (found["vent_1"].behind, found["vent_1"].ahead) == (1, OUTSIDE)


def test_vents_take_curves_and_ways_to_open():
    vents = {
        "discharge": {"time": [0, "10 ms"], "value": [0.5, 0.9]},
        "area_factor": {"gauge_pressure": [0, "20 kPa"], "value": [0.2, 1.0]},
        "blockage": True,
        "through_blocked": 0.1,
    }
    vent = rows(built(bag=SMALL | {"vents": vents})[0])["vent_1"]
    assert vent.over_time[0].y.tolist() == [0.5, 0.9]
    assert vent.over_pressure.x.tolist() == [0.0, 20e3]
    assert (vent.through_blocked, vent.opens_at, vent.bursts_at) == (0.1, 0.0, np.inf)
    for keys, opens in (
        ({"opening_pressure": "5 kPa"}, (5e3, np.inf)),
        ({"burst_time": "3 ms"}, (np.inf, 3e-3)),
        ({"burst_time": "3 ms", "opening_pressure": "5 kPa"}, (5e3, 3e-3)),
    ):
        vent = rows(built(bag=SMALL | {"vents": keys})[0])["vent_1"]
        assert (vent.opens_at, vent.bursts_at) == opens


def test_leakage_of_single_parts_stands_for_itself():
    front = {
        "law": "porous-medium",
        "pressure_factor": {"pressure": [1e5, 2e5], "value": [0, 1e-4]},
        "area": "deformed",
    }
    gas, _ = built(leakage={"law": "graefe", "pressure_factor": 0.02, "blockage": True, "parts": {"front": front}})
    found = rows(gas)
    assert (found["front"].law, found["front"].area_terms, found["front"].through_blocked) == (
        POROUS_MEDIUM, (0.0, 1.0, 0.0, 0.0), 1.0,
    )  # fmt: skip
    assert (found["rear"].coefficient, found["rear"].through_blocked) == (0.02, 0.0)


def test_orifices_join_chambers_by_name():
    orifices = [
        {"name": "hole", "between": ["ambient", "chamber_1"], "area": "2 cm^2", "discharge": 0.6},
        {"name": "duct", "between": ["chamber_2", "chamber_1"], "area": 1e-3},
    ]
    found = rows(built(bag=TWO_CHAMBERS, gas={"orifices": orifices})[0])
    assert (found["hole"].kind, found["hole"].behind, found["hole"].ahead, found["hole"].area) == (
        VENT,
        0,
        OUTSIDE,
        2e-4,
    )
    assert (found["duct"].kind, found["duct"].behind, found["duct"].ahead) == (OPENING, 1, 0)


TWO_INFLATORS = [
    {"name": "main", "mass_flow": {"time": [0, 0.01], "value": [2, 0]}, "gas": {"N2": 1.0}, "jets": {"count": 0}},
    {
        "name": "late", "delay": "5 ms", "mass_flow": {"time": [0, 0.01], "value": [1, 0]}, "chamber": "chamber_2",
        "temperature": {"time": [0, 0.01], "value": [900, 500]}, "gas": {"Ar": 0.5, "He": 0.5}, "fractions": "mass",
        "jets": {"count": 0},
    },
]  # fmt: skip


def test_several_inflators_blow_each_into_its_chamber_from_its_time_on():
    gas, shape = built(bag=TWO_CHAMBERS, inflator=TWO_INFLATORS)
    main, late = gas.supply.inflators
    assert (main.chamber, late.chamber) == (0, 1)
    assert late.flow_time.tolist() == pytest.approx([0.005, 0.015], rel=1e-12)
    assert late.temperature_time.tolist() == pytest.approx([0.005, 0.015], rel=1e-12)
    assert late.mass_fractions[gas.supply.species_names.index("Ar")] == pytest.approx(0.5, rel=1e-15)
    still = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    state, loads = gas.start(still), Loads(0, shape.surface)
    for k in range(200):
        gas.advance(state, still, k * 1e-4, 1e-4, loads)
        if k == 40:
            assert gas.totals(state).mass_by_species[gas.supply.species_names.index("He")] == 0.0
    totals = gas.totals(state)
    assert totals.injected == pytest.approx(0.015, rel=1e-12)
    assert totals.mass_error <= 1e-12
    assert totals.energy_error <= 1e-12


def test_inflators_are_varied_by_name():
    case = Case.from_dict({"bag": TWO_CHAMBERS, "inflator": TWO_INFLATORS})
    varied = case.vary({"inflator.late.temperature": 700.0, "inflator.main.jets.count": 4})
    assert varied.inflator[1].temperature == 700.0
    assert varied.inflator[0].jets.count == 4
    assert Case.from_dict(varied.to_dict()) == varied
    for key in ("inflator.temperature", "inflator.third.temperature"):
        with pytest.raises(InputError) as caught:
            case.vary({key: 700.0})
        assert caught.value.code == "E-CASE-006"
        assert "late, main" in caught.value.remedy


def test_a_gas_of_ones_own_has_its_heat_capacity():
    smoke = {"molar_mass": 0.04, "a": 30.0, "b": 0.01, "c": -1e-6}
    gas, _ = built(inflator={"gas": {"smoke": 0.4, "N2": 0.6}, "jets": {"count": 0}}, gas={"species": {"smoke": smoke}})
    row = gas.supply.table[gas.supply.species_names.index("smoke")]
    for t in (250.0, 650.0, 999.0, 1001.0, 2500.0):
        assert species_cp(row, t) == pytest.approx((30.0 + 0.01 * t - 1e-6 * t * t) / 0.04, rel=1e-13)
    only = np.zeros(len(gas.supply.species_names))
    only[gas.supply.species_names.index("smoke")] = 1.0
    rise = mixture_enthalpy(gas.supply.table, only, 1200.0) - mixture_enthalpy(gas.supply.table, only, 300.0)
    expected = (30.0 * 900.0 + 0.005 * (1200.0**2 - 300.0**2) - 1e-6 / 3.0 * (1200.0**3 - 300.0**3)) / 0.04
    assert rise == pytest.approx(expected, rel=1e-12)
    share = gas.supply.inflators[0].mass_fractions[gas.supply.species_names.index("smoke")]
    assert share == pytest.approx(0.4 * 0.04 / (0.4 * 0.04 + 0.6 * 28.0134e-3), rel=1e-12)


def test_the_bag_starts_with_what_was_asked_for():
    gas, shape = built(gas={"initial": {"gas": {"Ar": 1.0}, "temperature": 350.0, "pressure": "1.2 bar"}})
    still = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    totals = gas.totals(gas.start(still))
    argon = gas.supply.species_names.index("Ar")
    assert totals.mass == totals.mass_by_species[argon]
    assert (totals.pressure, totals.temperature) == (1.2e5, 350.0)
    assert totals.mass == pytest.approx(1.2e5 * totals.volume / (gas.supply.table[argon, 0] * 350.0), rel=1e-12)


def test_heat_goes_through_the_outer_fabric():
    gas, shape = built(bag=TWO_CHAMBERS, gas={"heat_transfer": 50.0})
    fabric = shape.surface.triangles_of_kind("fabric")
    assert gas.supply.heat_conductance.sum() == pytest.approx(
        50.0 * flat_area(shape.reference)[fabric].sum(), rel=1e-12
    )
    assert (gas.supply.heat_conductance > 0.0).all()


REFUSED = [
    ({"inflator": TWO_INFLATORS[:1] * 2}, "inflator", "two inflators are called main"),
    ({"inflator": []}, "inflator", "the list is empty"),
    ({"inflator": [{"name": "a", "temprature": 600.0}]}, "inflator.0.temprature", "did you mean 'temperature'"),
    ({"inflator": {"fractions": "mass", "gas": {"N2": 0.9}}}, "inflator.gas", "sum to 0.9"),
    ({"bag": {"vents": {"discharge": 2.0}}}, "bag.vents.discharge", "range 0 to 1"),
    (
        {"bag": {"vents": {"discharge": {"time": [0, 0], "value": [0, 1]}}}},
        "bag.vents.discharge",
        "times must increase",
    ),
    (
        {"bag": {"vents": {"area_factor": {"gauge_pressure": [0, 1], "value": [1]}}}},
        "bag.vents.area_factor",
        "pressure has 2 points",
    ),
    ({"leakage": {"law": "porous-medium"}}, "leakage", "needs a pressure_factor"),
    ({"leakage": {"law": "velocity-curve", "pressure_factor": 200.0}}, "leakage", "at most 50"),
    ({"leakage": {"area": [1.0, 0.0]}}, "leakage.area.2", "at least 3 entries"),
    ({"gas": {"species": {"smoke": {"molar_mass": 30, "a": 30}}}}, "gas.species.smoke.molar_mass", '"30 g/mol"'),
    ({"gas": {"species": {"smoke": {"molar_mass": 0.03, "a": 40, "b": -0.05}}}}, "gas.species.smoke", "cp falls"),
    (
        {"gas": {"species": {"smoke": {"molar_mass": 0.03, "a": 40, "b": -0.06, "c": 2e-5}}}},
        "gas.species.smoke",
        "at 1500 K",
    ),
    ({"gas": {"orifices": [{"name": "o", "between": ["bag", "bag"], "area": 1e-3}]}}, "gas.orifices.0", "with itself"),
    ({"gas": {"initial": {"temperature": 20.0}}}, "gas.initial.temperature", "293.15"),
]


@pytest.mark.parametrize(("tables", "key", "words"), REFUSED, ids=[key for _, key, _ in REFUSED])
def test_what_cannot_be_used_is_refused_with_its_key(tables, key, words):
    with pytest.raises(InputError) as caught:
        Case.from_dict(tables)
    assert caught.value.where.endswith(f"key {key}")
    assert words in caught.value.why + caught.value.remedy


def test_scales_of_an_inflator_multiply_mass_flow_and_times():
    flow = {"time": [0.0, 0.01, 0.05], "value": [0.0, 2.0, 0.0]}
    table = {"mass_flow": flow, "delay": 0.003, "scale": 1.5, "time_scale": 2.0}
    case = Case.from_dict({"bag": SMALL, "inflator": table})
    inflator = build_gas(case, build_shape(case.bag)).supply.inflators[0]
    assert inflator.delivered(1.0) == pytest.approx(1.5 * 2.0 * 0.05)
    assert inflator.flow_time.tolist() == pytest.approx([0.003, 0.023, 0.103])


def test_curves_of_an_inflator_come_from_files(tmp_path):
    (tmp_path / "flow.csv").write_text("time [ms], mass_flow [g/ms]\n0, 0\n8, 2\n50, 0\n")
    (tmp_path / "hot.csv").write_text("time, temperature\n0, 700\n0.05, 600\n")
    (tmp_path / "case.toml").write_text('[inflator]\nmass_flow = "flow.csv"\ntemperature = "hot.csv"\n')
    inflator = Case.load(tmp_path / "case.toml").inflator
    assert inflator.mass_flow.time == pytest.approx((0.0, 0.008, 0.05))
    assert inflator.mass_flow.value == pytest.approx((0.0, 2.0, 0.0))
    assert inflator.temperature.value == (700.0, 600.0)
