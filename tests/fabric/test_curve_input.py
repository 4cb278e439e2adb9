"""Curves on their way into a case: files, the library, refusals, and a case that is complete in itself."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.fabric.build_fabric import BUILDERS, build_fabric
from billow.case.fabric.schema_fabric import LAWS
from billow.case.schema import Case
from billow.parts.fabric.curve_fabric import CurveFabric
from billow.parts.fabric.curve_file import LIBRARY, library_curves, read_curve_file

YARN = {"loading": {"strain": [0.0, 0.1], "stress": [0.0, "20 MPa"]}}
SHEAR = {"loading": {"angle": [0.0, 40.0], "stress": [0.0, "5 MPa"]}}


def fabric(**keys):
    return Case.from_dict({"fabric": keys}).fabric


def built(warp=YARN, shear=SHEAR, **keys):
    return build_fabric(fabric(curves={"warp": warp, "weft": YARN, "shear": shear}, **keys))


@pytest.mark.parametrize(
    "text",
    [
        "strain [%], stress [MPa]\n0, 0\n2, 2.2\n10,28\n",
        "# a comment\nSTRESS [MPa];strain\n0;0\n2.2;0.02\n\n28;0.1\n",
        "strain\tstress (Pa)\n0\t0\n0.02\t2.2e6\n0.1\t28e6\n",
        "\ufeffstrain,stress\r\n0,0\r\n0.02,2.2e6\r\n0.1,2.8e7\r\n",
    ],
)
def test_files_with_units_separators_and_comments(tmp_path, text):
    path = tmp_path / "warp.csv"
    path.write_bytes(text.encode())
    curve = read_curve_file(path, "strain")
    assert curve["strain"] == pytest.approx([0.0, 0.02, 0.1], rel=1e-14)
    assert curve["stress"] == pytest.approx([0.0, 2.2e6, 28e6], rel=1e-14)


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"", "empty"),
        (b"0, 0\n1, 2\n", "line 1 names two columns"),
        (b"strain, strain\n0, 0\n", "line 1 names two columns"),
        (b"0, 1\n1, 2\n", "line 1 should name the columns strain and stress"),
        (b"strain [%]\n0\n", "line 1 should name the columns strain and stress"),
        (b"strain, stress\n0, 0\n1, 2, 3\n", "line 3"),
        (b"strain, stress\n0, 0\n0.1, much\n", "line 3: the value of 'stress' is 'much', not a number"),
        (b"strain [s], stress\n0, 0\n", "unit"),
        (b"\xff\xfe\x00", "UTF-16"),
    ],
)
def test_a_file_without_a_curve_is_refused(tmp_path, content, word):
    path = tmp_path / "warp.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match="E-FAB-002") as caught:
        read_curve_file(path, "strain")
    assert word in caught.value.why


def test_an_effective_case_holds_the_curves_of_its_files(tmp_path):
    (tmp_path / "warp.csv").write_text("strain [%], stress [MPa]\n0, 0\n10, 28\n")
    (tmp_path / "shear.csv").write_text("angle [rad], stress [MPa]\n0, 0\n0.5, 4\n")
    (tmp_path / "case.toml").write_text(
        '[fabric]\nlaw = "curves"\nlibrary = "nylon66-470dtex"\n'
        'curves.warp.loading = "warp.csv"\ncurves.shear.loading = "shear.csv"\n'
    )
    case = Case.load(tmp_path / "case.toml")
    for name in ("warp.csv", "shear.csv"):
        (tmp_path / name).unlink()
    again = Case.from_dict(tomllib.loads(case.to_toml()))
    assert again == case
    assert again.digest() == case.digest()
    assert again.fabric.library == "nylon66-470dtex"
    assert again.fabric.from_library == ["weft"]
    law = build_fabric(again.fabric)
    assert isinstance(law, CurveFabric)
    assert law.switches_shear
    assert law.warp.loading.stress == (0.0, 28e6)
    assert law.shear.loading.strain == pytest.approx((0.0, 0.5), rel=1e-14)
    assert law.weft.loading.stress[-1] == library_curves("nylon66-470dtex")["weft"]["loading"]["stress"][-1]


@pytest.mark.parametrize("name", LIBRARY)
@pytest.mark.parametrize("law", ["curves", "curves-shear"])
def test_a_fabric_of_the_library_is_sound(name, law):
    fabric_law = build_fabric(fabric(library=name, law=law))
    assert 400.0 < fabric_law.wave_speed < 1500.0
    for spring in fabric_law.springs:
        assert (np.diff(spring.heat) >= -1e-12 * spring.heat[-1]).all()


def test_every_law_that_a_case_may_name_has_a_builder():
    assert set(BUILDERS) == set(LAWS)
    for law in LAWS:
        assert build_fabric(fabric(law=law)).density == 800.0


def test_a_law_of_curves_needs_one_line():
    assert build_fabric(fabric(law="curves-shear")).switches_shear is False
    assert build_fabric(fabric(library="nylon66-470dtex")).switches_shear is False
    assert build_fabric(Case().vary({"fabric.law": "curves-shear"}).fabric).switches_shear is False
    back = Case.from_dict({"fabric": {"law": "curves-shear"}}).vary({"fabric.law": "linear"})
    assert build_fabric(back.fabric).young_warp == 0.4e9


@pytest.mark.parametrize(
    ("keys", "word"),
    [
        ({"law": "linear", "library": "nylon66-470dtex"}, "no effect"),
        ({"library": "nylon66-470dtex", "curves": {"warp": YARN, "weft": YARN, "shear": SHEAR}}, "no effect"),
        ({"law": "curves", "curves": {"warp": YARN}}, "weft.loading"),
        ({"law": "curves", "curves": {"warp": {"loading": {"strain": [0.0, 0.1]}}}}, "warp.loading"),
        ({"library": "nylon66-470dtex", "curves": {"shear": {"loading": {"angle": [0.0, 30.0]}}}}, "shear.loading"),
        ({"coating": {"thickness": "0.05 mm"}, "permeability": 0.02}, "leak"),
        ({"law": "curves-shear", "liner": {"ratio": 0.03}}, "liner"),
        ({"library": "wool"}, "library"),
        ({"curves": {"warp": {"loading": "warp.csv"}}}, "a table is expected"),
    ],
)
def test_contradictions_are_refused(keys, word):
    with pytest.raises(InputError, match="E-CASE-005") as caught:
        fabric(**keys)
    assert word in str(caught.value)


def yarn(strain, stress, back=None):
    table = {"loading": {"strain": strain, "stress": stress}}
    return table | ({"unloading": dict(zip(("strain", "stress"), back, strict=True))} if back else {})


@pytest.mark.parametrize(
    ("code", "warp", "word"),
    [
        ("E-FAB-003", yarn([0.0], [0.0]), "1 points"),
        ("E-FAB-003", yarn([0.0, 0.1], [0.0]), "1 stresses"),
        ("E-FAB-003", yarn([0.0, 0.1, 0.1], [0.0, 1e6, 2e6]), "0.1"),
        ("E-FAB-003", yarn([0.0, 0.2, 0.1], [0.0, 1e6, 2e6]), "0.1"),
        ("E-FAB-003", yarn([0.01, 0.1], [0.0, 1e6]), "0.01"),
        ("E-FAB-003", yarn([0.0, 0.1], [1e5, 1e6]), "begins"),
        ("E-FAB-004", yarn([0.0, 0.1, 0.2], [0.0, 2e6, 1e6]), "falls"),
        ("E-FAB-004", yarn([0.0, 0.1], [0.0, -1e6]), "falls"),
        ("E-FAB-004", yarn([0.0, 0.1, 0.2], [0.0, 0.0, 1e6]), "no stress"),
        ("E-FAB-005", yarn([0.0, 0.1], [0.0, 2e7], ([0.0, 0.05, 0.1], [0.0, 1.5e7, 2e7])), "above"),
        ("E-FAB-005", yarn([0.0, 0.1], [0.0, 2e7], ([0.0, 0.1], [0.0, 1e7])), "begin on"),
        ("E-FAB-005", yarn([0.0, 0.1], [0.0, 2e7], ([0.0, 0.1, 0.2], [0.0, 1e7, 4e7])), "begin on"),
        ("E-FAB-003", yarn([0.0, 0.1], [0.0, 2e7], ([0.01, 0.1], [0.0, 2e7])), "warp.unloading"),
        ("E-FAB-006", yarn([0.0, 0.02, 0.1], [0.0, 2e6, 3e7], ([0.0, 0.05, 0.1], [0.0, 1e7, 3e7])), "%"),
    ],
)
def test_curves_that_describe_no_fabric_are_refused(code, warp, word):
    with pytest.raises(InputError, match=code) as caught:
        built(warp)
    assert word in str(caught.value)
    assert "fabric.curves.warp" in caught.value.where


def test_a_shear_curve_ends_before_the_yarns_lie_on_each_other():
    with pytest.raises(InputError, match="E-FAB-003") as caught:
        built(shear={"loading": {"angle": [0.0, 85.0], "stress": [0.0, 5e6]}})
    assert "85" in caught.value.why
    built(shear={"loading": {"angle": [0.0, 60.0], "stress": [0.0, 5e6]}})


def test_hollow_enough_unloading_is_accepted_where_loading_stiffens():
    """Loading from 0.1 to 0.35 GPa at 2 %: there x f'/f = 3.5 (a twentieth more in Green strain). Unloading with power
    q gives back U(1) = 1/(q + 1) of f x, and heat grows while x f'/f <= 1/U(1) - 1 = q."""
    y = np.linspace(0.0, 1.0, 81)

    def attempt(q):
        back = ((0.1 * y).tolist(), (30e6 * y**q).tolist())
        return built(yarn([0.0, 0.02, 0.1], [0.0, 2e6, 30e6], back))

    attempt(4.0)
    for q in (2.0, 3.0):
        with pytest.raises(InputError, match="E-FAB-006"):
            attempt(q)


def test_a_coating_adds_its_mass_and_no_stiffness():
    plain, coated = build_fabric(fabric()), build_fabric(fabric(coating={"thickness": "0.03 mm", "density": 1200.0}))
    assert coated.density * coated.thickness == pytest.approx(0.24 + 0.036, rel=1e-12)
    assert coated.young_warp == plain.young_warp
    assert coated.thickness == plain.thickness


def test_what_a_steep_curve_costs_and_how_far_curves_reach():
    mild, steep = built(), built(yarn([0.0, 0.09, 0.1], [0.0, 18e6, 118e6]))
    name, now, without = steep.cost_of_steepness(0.008)
    assert name == "warp"
    assert now < 0.6 * without
    # dt = 0.75 h / c (sqrt(1 + xi^2) - xi), and c^2 grows with the slope, 200 MPa to 10 GPa in true strain.
    assert now == pytest.approx(0.75 * 0.008 / steep.wave_speed * (np.sqrt(1.0025) - 0.05), rel=1e-12)
    _, now, without = mild.cost_of_steepness(0.008)
    assert now > 0.9 * without
    assert mild.reach()["warp"] == pytest.approx((0.1, 20e6 * np.exp(0.1) * 3e-4), rel=1e-12)


def test_a_value_that_is_refused_names_the_file_of_its_curve(tmp_path):
    (tmp_path / "pull.csv").write_text("strain,stress [Pa]\n0,0\n0.1,-1e306\n")
    (tmp_path / "case.toml").write_text('[fabric]\nlaw = "curves"\n[fabric.curves.warp]\nloading = "pull.csv"\n')
    with pytest.raises(InputError) as caught:
        Case.load(tmp_path / "case.toml")
    assert caught.value.where.endswith("key fabric.curves.warp.loading.stress.1, from pull.csv")
