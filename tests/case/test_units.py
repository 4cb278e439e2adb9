"""Numbers in another unit are asked about before anything else, and the likely unit is named."""

from __future__ import annotations

import numpy as np
import pytest

from billow.apps.tank.trace import load_trace
from billow.base.errors import InputError
from billow.base.plausible import TABLE, is_usual, require_possible, unusual
from billow.base.units import CONVERSIONS
from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model
from billow.case.concerns import concerns_of
from billow.case.schema import Case
from billow.parts.fabric.membrane import Membrane

START = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.3, 0], [0.1, 0.1, 0.1]])
CELLS = "CELLS 4 16\n3 0 2 1  3 0 1 3  3 0 3 2  3 1 2 3\nCELL_TYPES 4\n5 5 5 5\n"


def written(path, points):
    numbers = " ".join(map(repr, points.ravel().tolist()))
    path.write_text(
        "# vtk DataFile Version 3.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        f"POINTS {len(points)} double\n{numbers}\n{CELLS}CELL_DATA 4\nSCALARS part int\nLOOKUP_TABLE default\n1 1 1 1\n"
    )
    return str(path)


def case(tmp_path, start, reference=None, **bag):
    table = {"shape": "mesh", "start": written(tmp_path / "start.vtk", start), "parts": [{"name": "a", "number": 1}]}
    if reference is not None:
        table["reference"] = written(tmp_path / "flat.vtk", reference)
    return Case.from_dict({"bag": table | bag, "gas": {"model": "none"}, "obstacles": []})


def refusal(case):
    with pytest.raises(InputError) as caught:
        build_model(case)
    return caught.value


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1e-3), ("m", 1.0)])
def test_a_mesh_in_another_unit_is_refused_with_the_unit_it_looks_like(tmp_path, unit, factor):
    other = {"mm": "m", "m": "mm"}[unit]
    error = refusal(case(tmp_path, START / factor, unit=other))
    assert error.code == "E-UNIT-001"
    assert error.what.startswith("the width of the mesh in bag.start is")
    assert f'write bag.unit = "{unit}"' in error.remedy
    build_shape(case(tmp_path, START / factor, unit=unit).bag)


def test_unused_points_do_not_make_a_mesh_large(tmp_path):
    build_shape(case(tmp_path, np.vstack([START, [[900.0, 0.0, 0.0]]])).bag)


@pytest.mark.parametrize(("start", "flat", "larger"), [(1.0, 1e3, "reference"), (1e3, 1.0, "start")])
def test_start_and_reference_in_two_units_are_refused_before_anything_else(tmp_path, start, flat, larger):
    error = refusal(case(tmp_path, START * start, START * flat))
    assert error.code == "E-GEO-038"
    assert error.what.startswith(f"the {larger} is 1000 times as large")


@pytest.mark.parametrize("flat", [START * [1.0, 1e-12, 0.0], START * 0.0])
def test_a_reference_without_area_is_refused(tmp_path, flat):
    assert refusal(case(tmp_path, START, flat)).code in ("E-GEO-038", "E-UNIT-001")
    with pytest.raises(InputError, match="E-GEO-004"):
        Membrane.build(None, np.arange(1), np.zeros((1, 3, 2)))


@pytest.mark.parametrize(
    ("changes", "what", "remedy"),
    [
        ({"ambient.pressure": 1013.0}, "the ambient pressure is 1013 Pa", "it looks like 1013 mbar"),
        ({"obstacles.ball.velocity": [0.0, 0.0, -50.0]}, "the speed of ball is 50 m/s", "it looks like 50 km/h"),
    ],
)
def test_an_unusual_number_is_asked_about_first(changes, what, remedy):
    ball = {"shape": "super-ellipsoid", "name": "ball", "locked": False}
    sound = Case.from_dict({"bag": {"element_size": 0.06}, "obstacles": [ball]})
    assert "W-UNIT-001" not in [concern.code for concern in concerns_of(sound, build_model(sound))]
    odd = sound.vary(changes)
    found = next(concern for concern in concerns_of(odd, build_model(odd)) if concern.code == "W-UNIT-001")
    assert found.what == what
    assert remedy in found.remedy


@pytest.mark.parametrize("law", ["linear", "curves", "curves-shear"])
@pytest.mark.parametrize("yarns", ["warp", "weft"])
def test_stress_in_another_unit_is_asked_about_with_every_law_and_in_both_directions(law, yarns):
    """A curve in GPa for MPa, or a modulus."""
    curve = {"strain": [0.0, 0.02, 0.06], "stress": [0.0, 4e9, 15e9]}
    fabric = {"law": law, "library": "nylon66-470dtex", "curves": {yarns: {"loading": curve}}}
    fabric = {f"young_{yarns}": 300e9, "poisson": 0.0} if law == "linear" else fabric
    odd = Case.from_dict({"bag": {"element_size": 0.06}, "fabric": fabric, "obstacles": []})
    told = [concern.what for concern in concerns_of(odd, build_model(odd)) if concern.code == "W-FAB-001"]
    assert len(told) == 1
    assert f"along the {yarns}" in told[0]


def test_a_trace_whose_header_names_another_unit_is_refused(tmp_path):
    path = tmp_path / "trace.csv"
    rows = [(float(k), 101.3 + 3.0 * k) for k in range(101)]
    path.write_text("time [s],pressure [kPa]\n" + "".join(f"{t},{p}\n" for t, p in rows))
    with pytest.raises(InputError, match="E-UNIT-001") as caught:
        load_trace(path)
    assert "it looks like 100 ms" in caught.value.remedy
    path.write_text("time [ms],pressure [GPa]\n" + "".join(f"{t},{p}\n" for t, p in rows))
    with pytest.raises(InputError, match="E-UNIT-001") as caught:
        load_trace(path)
    assert "it looks like 401.3 kPa" in caught.value.remedy


def test_every_row_of_the_table_has_a_known_unit_and_usual_lies_within_possible():
    for kind, (unit, possible, usual) in TABLE.items():
        assert unit in CONVERSIONS or unit == "kg/m^2", kind
        assert possible[0] <= usual[0] < usual[1] <= possible[1], kind
        middle = 0.5 * sum(usual)
        assert is_usual(kind, middle)
        require_possible(kind, middle, "it", "here", "")
        assert list(unusual(kind, middle, "it", "here", "")) == []
    for value in (np.nan, np.inf, -1.0, 0.0):
        with pytest.raises(InputError, match="E-UNIT-001"):
            require_possible("bag size", value, "it", "here", "")
