"""A case that is accepted: units, defaults, the way to a file and back, identity, variations."""

from __future__ import annotations

import contextlib
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.base.units import CONVERSIONS, in_unit
from billow.case.schema import Case

FULL = {
    "title": 'With "quotes", \\ and ü',
    "bag": {"diameter": "60 cm", "element_size": "1 in", "vents": {"count": 3, "diameter": "3.5cm"}},
    "fabric": {"thickness": "0.3 mm", "young_warp": "0.4 GPa", "permeability": "2.75 %", "density": "0.8 g/cm^3"},
    "inflator": {
        "gas": {"Ar": 0.95, "O2": 0.05},
        "temperature": {"time": ["0 ms", "50 ms"], "value": [700.0, "600 K"]},
        "mass_flow": {"time": [0.0, "8 ms", 0.05], "value": [0.0, "2 g/ms", 0.0]},
        "jets": {"count": 0},
    },
    "ambient": {"pressure": "1013.25 mbar"},
    "obstacles": [
        {"shape": "plate", "height": "-5 mm"},
        {
            "shape": "super-ellipsoid",
            "radii": ["10 cm", 0.2, "300 mm"],
            "slope": "500 N/mm",
            "angle_about_x": "0.5 rad",
            "velocity": [0, 0, "-18 km/h"],
        },
    ],
    "run": {"end_time": "50 ms", "gravity": [0, 0, "-1 g"]},
}  # fmt: skip


def test_units_are_converted_where_they_enter():
    case = Case.from_dict(FULL)
    assert case.bag.diameter == pytest.approx(0.6, rel=1e-15)
    assert case.bag.element_size == 0.0254
    assert case.bag.vents.diameter == pytest.approx(0.035, rel=1e-15)
    assert case.fabric.thickness == pytest.approx(3e-4, rel=1e-15)
    assert case.fabric.young_warp == pytest.approx(4e8, rel=1e-15)
    assert case.fabric.permeability == pytest.approx(0.0275, rel=1e-15)
    assert case.fabric.density == 800.0
    assert case.inflator.mass_flow.time[1] == pytest.approx(0.008, rel=1e-15)
    assert case.inflator.mass_flow.value[1] == 2.0
    assert case.ambient.pressure == 101325.0
    plate, impactor = case.obstacles
    assert plate.height == -0.005
    assert impactor.radii == pytest.approx((0.1, 0.2, 0.3), rel=1e-15)
    assert impactor.slope == 5e5
    assert impactor.angle_about_x == pytest.approx(28.6478897565, rel=1e-10)
    assert impactor.velocity[2] == pytest.approx(-5.0, rel=1e-15)
    assert case.run.gravity[2] == -9.80665


@given(
    unit=st.sampled_from(sorted(CONVERSIONS)),
    number=st.floats(-1e6, 1e6, allow_subnormal=False),
    space=st.sampled_from(["", " ", "  "]),
    data=st.data(),
)
def test_a_text_with_any_accepted_unit_is_the_number_times_its_factor(unit, number, space, data):
    text = data.draw(st.sampled_from(sorted(CONVERSIONS[unit])))
    assert in_unit(f" {number!r}{space}{text} ", unit) == number * CONVERSIONS[unit][text]
    assert in_unit(number, unit) == in_unit(repr(number), unit) == number
    for other in {"kg", "s", "m", "Pa"} - set(CONVERSIONS[unit]):
        with pytest.raises(ValueError, match="does not fit"):
            in_unit(f"1 {other}", unit)


@given(text=st.text(max_size=12))
def test_any_text_is_a_number_or_a_value_error(text):
    with contextlib.suppress(ValueError):
        assert isinstance(in_unit(text, "m"), float)


@pytest.mark.parametrize("data", [{}, FULL])
def test_the_way_to_a_file_and_back(tmp_path, data):
    case = Case.from_dict(data)
    path = tmp_path / "case.toml"
    path.write_text(case.to_toml(), encoding="utf-8")
    again = Case.load(path)
    assert again == case
    assert again.digest() == case.digest()
    assert again.to_toml() == case.to_toml()
    assert Case.from_dict(tomllib.loads(case.to_toml())) == case


def test_every_default_is_written(tmp_path):
    written = tomllib.loads(Case().to_toml())
    assert written["fabric"]["thickness"] == 3e-4
    assert written["bag"]["vents"]["count"] == 2
    assert written["inflator"]["mass_flow"]["value"] == [0.0, 2.0, 0.0]
    assert written["obstacles"][0]["name"] == "plate"


def test_the_digest_is_stable_and_sees_every_setting():
    # A change of this text means that older results no longer count as results of the same case: mind the changelog.
    assert Case.from_dict(FULL).digest() == Case.from_dict(FULL).digest()
    assert Case().digest() == Case.from_dict({"fabric": {"thickness": "0.3 mm"}}).digest()
    assert Case().digest() == Case.from_dict({"bag": {"vents": {"count": 2}}}).digest()
    changes = {
        "title": "x",
        "bag.element_size": 0.011,
        "bag.vents.discharge": 0.71,
        "fabric.compression": True,
        "fabric.poisson": 0.2000000001,
        "inflator.gas": {"N2": 1.0},
        "inflator.jets.count": 0,
        "inflator.temperature": 651.0,
        "obstacles": [],
        "run.gravity": [0.0, 0.0, -9.81],
    }
    digests = {Case().vary({key: value}).digest() for key, value in changes.items()}
    assert len(digests | {Case().digest()}) == len(changes) + 1


def test_varying_changes_what_is_named_and_nothing_else():
    case = Case.from_dict(FULL)
    varied = case.vary(
        {
            "fabric.permeability": 0.03,
            "obstacles.impactor.degree": 3.0,
            "obstacles.plate.height": "-1 mm",
            "inflator.temperature": 800.0,
            "bag.vents.count": 1,
        }
    )
    assert (varied.fabric.permeability, varied.obstacles[1].degree, varied.obstacles[0].height) == (0.03, 3.0, -0.001)
    assert varied.inflator.temperature == 800.0
    assert varied.inflator.jets.count == 0
    back = {
        "fabric.permeability": case.fabric.permeability,
        "obstacles.impactor.degree": 2.0,
        "obstacles.plate.height": -0.005,
        "inflator.temperature": case.inflator.temperature.model_dump(),
        "bag.vents.count": 3,
    }
    assert varied.vary(back) == case
    assert case == Case.from_dict(FULL)  # the original is untouched
    assert case.vary({}) == case


@pytest.mark.parametrize(
    ("changes", "code", "words"),
    [
        ({"fabric.permeabilty": 0.03}, "E-CASE-003", "permeabilty"),
        ({"fabrik.permeability": 0.03}, "E-CASE-006", "fabric"),
        ({"obstacles.sphere.degree": 3.0}, "E-CASE-006", "impactor, plate"),
        ({"obstacles.impactor": 3.0}, "E-CASE-006", "impactor"),
        ({"fabric.thickness.mm": 3.0}, "E-CASE-006", "mm"),
        ({"fabric.thickness": -1.0}, "E-CASE-005", "fabric.thickness"),
        ({"": 1.0}, "E-CASE-003", ""),
    ],
)
def test_bad_variations_are_refused(changes, code, words):
    with pytest.raises(InputError) as caught:
        Case.from_dict(FULL).vary(changes)
    assert caught.value.code == code
    assert words in str(caught.value)


def test_a_case_cannot_be_changed_in_place():
    case = Case()
    with pytest.raises(Exception, match="frozen"):
        case.bag.diameter = 0.5


@pytest.mark.parametrize("length", [5e-324, 1e-250, 1.0, 1e3])
def test_the_normal_of_a_plate_may_have_any_length(length):
    case = Case.from_dict({"obstacles": [{"shape": "plate", "normal": [length, 0.0, length]}]})
    facing = case.obstacles[0].build()[2].rotation[:, 2]
    assert facing == pytest.approx([0.5**0.5, 0.0, 0.5**0.5], abs=1e-15)
