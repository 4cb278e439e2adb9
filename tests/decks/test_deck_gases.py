"""Airbags of kinds beside HYBRID and PARTICLE, and the options of exits and jets."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from test_decks_of_others import CLOTH, GAS, ROWS, Pillow

from billow.base.errors import InputError
from billow.case.schema import Case
from billow.decks.import_deck import Options, import_deck
from billow.run.simulate import simulate

BEGIN, END = GAS.index("*AIRBAG_HYBRID"), GAS.index("*CONTROL")
VOLUME, PRESSURE = "volume [m^3]", "pressure [Pa]"
MOUTH = {j * ROWS + i for j in (2, 3) for i in (2, 3)}


def with_mouth() -> Pillow:
    """A pillow whose four middle quads below are part 3."""
    pillow = Pillow()
    pillow.parts = [3 if k in MOUTH else part for k, part in enumerate(pillow.parts)]
    return pillow


@pytest.fixture
def use(tmp_path):
    """Import a deck with other cards of the airbag: its case and report."""

    def make(airbag: str, pillow: Pillow | None = None, more: str = "", **options):
        text = (pillow or Pillow()).deck(gas=GAS[:BEGIN] + airbag + GAS[END:], cloth=CLOTH, more=more)
        (tmp_path / "bag.k").write_text(text)
        report = import_deck(tmp_path / "bag.k", tmp_path / "case", Options(**options))
        case = Case.load(tmp_path / "case" / "case.toml")
        return case, report

    return make


def status(report, name: str) -> str:
    (found,) = {row.status for row in report.rows.values() if row.field.split(".")[1].split("[")[0] == name}
    return found


def ring(z: float) -> str:
    """Nodes and vectors of six orifices, 60 deg from the z axis."""
    nodes, vectors = "", ""
    for k in range(6):
        x, y = math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)
        nodes += f"{9001 + k},{300 + 30 * x!r},{300 + 30 * y!r},{z}\n"
        vectors += f"{9001 + k},0,0,0,{math.sin(math.pi / 3) * x!r},{math.sin(math.pi / 3) * y!r},0.5\n"
    return f"*NODE\n{nodes}*DEFINE_VECTOR\n{vectors}"


ALE = (
    "*AIRBAG_ALE\n1,1,,,,,0,0\n293,1.01e-4,,8.314,1,0,0\n4,4,0.1,0.1,0.3,0,2,0.1\n0,0,0,0\n40,40,10,0,1\n"
    "-100,-100,-150,700,-100,-150\n-100,700,-150,-100,-100,50\n{},,0.1,2,1,6,0,2\n,,,0.028,0.8,29,0,0\n,,,0.032,0.2,30,0,0\n"
    "1,,,0.03,,31,1e-3,0\n" + "".join(f"{9001 + k},{9001 + k},12.5\n" for k in range(6))
)


def test_a_fluid_mesh_becomes_the_mesh_gas(use, tmp_path):
    case, report = use(ALE.format("15"), with_mouth(), ring(-90.0), parts={3: "mouth"})
    assert (case.gas.model, case.gas.switch_time) == ("mesh", pytest.approx(0.015))
    assert case.gas.cell == pytest.approx(0.02)  # 800 x 800 x 200 mm in 16,000 cells
    (inflator,) = case.inflators
    assert (inflator.jets.count, inflator.jets.cone) == (6, 0.0)
    assert inflator.jets.angle == pytest.approx(60.0)
    assert 0.25 * np.pi * inflator.jets.hole_diameter**2 == pytest.approx(12.5e-6)
    assert case.gas.initial.fractions == "mass"
    assert case.gas.initial.gas == pytest.approx({"air_1": 0.8, "air_2": 0.2})
    assert not report.of("refused")
    assert {status(report, n) for n in ("NX/IDA", "FRIC")} == {"approximated"}
    assert {status(report, n) for n in ("NQUAD", "PFAC", "HG", "X3", "ZOOM")} == {"ignored"}
    rows = json.loads((tmp_path / "case" / "import.json").read_text())["fields"]
    assert sum(row["field"].startswith("AIRBAG_ALE.") for row in rows) >= 60


@pytest.mark.parametrize(("time", "model", "switch"), [("", "mesh", 0.0), ("0", "uniform-pressure", 0.0)])
def test_the_time_of_the_switch_to_a_control_volume(use, time, model, switch):
    case, _ = use(ALE.format(time), with_mouth(), ring(-90.0), parts={3: "mouth"})
    assert (case.gas.model, case.gas.switch_time) == (model, switch)


def test_vents_of_a_fluid_mesh_are_parts_with_one_coefficient(use):
    for coefficient, refused in (("0.6", []), ("0", ["AIRBAG_ALE.VNTCOF"])):
        cards = ALE.format("15").replace("\n0,0,0,0\n", f"\n3,1,1,{coefficient}\n")
        case, report = use(cards, with_mouth(), ring(-90.0))
        assert [row.field for row in report.of("refused")] == refused
        assert case.bag.vents.discharge == float(coefficient)
        assert case.bag.vents.blockage
        assert [part.kind for part in case.bag.parts] == ["fabric", "fabric", "vent"]
        shutil.rmtree(Path(case.bag.start).parent)


def histories(case: Case, folder: Path) -> dict[str, np.ndarray]:
    result = simulate(case, folder)
    return {name: np.asarray(result.histories[name]) for name in (VOLUME, PRESSURE)}


def test_an_adiabatic_gas_keeps_p_v_to_the_gamma(use, tmp_path):
    case, report = use("*AIRBAG_ADIABATIC_GAS_MODEL\n1,1\n1,0,1.4,2e-5,1.01e-4,1.2e-9\n")
    assert case.gas.initial.pressure == pytest.approx(121e3)
    assert not report.of("refused")
    short = Case.from_dict({**case.to_dict(), "run": {"end_time": 4e-3, "frames": 4}})
    found = histories(short, tmp_path / "run")
    kept = found[PRESSURE] * found[VOLUME] ** 1.4
    assert np.ptp(found[VOLUME]) > 0.02 * found[VOLUME][0]
    assert kept == pytest.approx(kept[0], rel=1e-5)


def test_a_pressure_of_relative_volume_is_within_what_the_report_says(use, tmp_path):
    case, report = use("*AIRBAG_SIMPLE_PRESSURE_VOLUME\n1,1\n1e-5,2,0,0\n", units="kg-mm-ms")
    assert status(report, "CN") == "approximated"
    short = Case.from_dict({**case.to_dict(), "run": {"end_time": 4e-3, "frames": 4}})
    found = histories(short, tmp_path / "run")
    relative = found[VOLUME] / found[VOLUME][0]
    gauge = found[PRESSURE] - 1000.0
    allowed = 1000.0 * np.abs(1.0 / relative - 1.0) + 0.0084 * np.abs(np.log(relative)) * 21e3 / relative + 1.0
    assert relative.max() > 1.02
    assert (np.abs(gauge - 20e3 / relative) <= allowed).all()


JET = "*AIRBAG_HYBRID_JETTING\n1,1\n293,1.01e-4,,8.314,1\n0,,0\n0,,1\n1,2,,0.028,1,29\n\n{}\n"


def test_a_jet_along_the_axis_of_the_mouth(use):
    case, report = use(JET.format("300,300,-90,300,300,10,0.3,1\n0,0,0,0,0"), with_mouth(), parts={3: "mouth"})
    (inflator,) = case.inflators
    assert (inflator.jets.count, inflator.jets.angle) == (1, 0.0)
    assert not report.of("refused")
    assert status(report, "XJFP") == status(report, "CA") == "approximated"


@pytest.mark.parametrize(
    ("card", "why"),
    [("300,300,-90,400,300,10,0.3,1", "leans by 45 deg"), ("500,300,-90,500,300,10,0.3,1", "lies 200 mm beside it")],
)
def test_other_jets_are_refused_with_what_they_are(use, card, why):
    case, report = use(JET.format(card), with_mouth(), parts={3: "mouth"})
    assert case.inflators[0].jets.count == 0
    assert all(why in row.note for row in report.of("refused"))
    assert len(report.of("refused")) == 6


def test_exits_that_an_acceleration_opens_are_refused_and_an_overpressure_is_the_state_at_the_start(use):
    cards = "*AIRBAG_WANG_NEFSKE_POP\n1,1\n718,1005,600,0,1\n0.7,,-3\n1.01e-4,1.2e-9,1,0,2e-6,5e-5\n3,0,0,9,9,1,0,7\n"
    case, report = use(cards, with_mouth(), units="kg-mm-ms")
    assert case.gas.initial.pressure == pytest.approx(103e3)
    assert case.bag.vents.opening_pressure == pytest.approx(50e3)
    names = {row.field.split(".")[1] for row in report.of("refused")}
    assert names == {"TDP", "AZP", "AMAGP", "TDURP", "RBIDP"}


def test_an_airbag_without_a_mass_flow_does_not_get_the_inflator_of_a_case_by_default(use):
    cards = "*AIRBAG_HYBRID\n1,1\n293,1.01e-4,,8.314,1\n0,,0\n0,,1\n0,0,,0.028,1,29\n\n"
    case, report = use(cards)
    (inflator,) = case.inflators
    assert inflator.delay == 10.0
    assert any("nothing flows in" in remark for remark in report.remarks)


ADVANCED = (
    "*AIRBAG_ADVANCED_ALE_ID\n1,a bag in modules\n1,1,1\n293,1.01e-4\n"
    "*DEFINE_ALEBAG_BAG_TITLE\nthe bag\n1,1,PSET,YES,1,0.6,3,1\n4,4,0.1,0.1,0.3,0,2,0.1\n0,0,1e10\n"
    "*DEFINE_ALEBAG_INFLATOR\n1,,,,2,0,0,2\n1,,,0.028,,29,1e-3,0\n1,,,0.044,,37,0,0\n"
    "*DEFINE_ALEBAG_INFLATOR\n2,,,,1,6,0,2\n1,,,0.03,,31,1e-3,0\n"
    + "".join(f"{9001 + k},{9001 + k},12.5\n" for k in range(6))
)


def test_a_bag_in_modules_is_read_by_what_it_names_and_its_own_columns_are_refused(use, tmp_path):
    """Nobody outside says what the columns of *AIRBAG_ADVANCED_ALE are; *DEFINE_ALEBAG_... are known."""
    case, report = use(ADVANCED, with_mouth(), ring(-90.0))
    assert case.gas.model == "mesh"
    assert [part.kind for part in case.bag.parts] == ["fabric", "fabric", "vent"]
    assert (case.bag.vents.discharge, case.bag.vents.blockage) == (0.6, True)
    assert [one.jets.count for one in case.inflators] == [0, 0, 0]  # a bag with a vent and no mouth
    masses = {name: gas.molar_mass for name, gas in case.gas.species.items()}
    assert masses == pytest.approx({"gas_1": 0.028, "gas_2": 0.044, "gas_3": 0.03})
    refused = report.of("refused")
    assert {row.field.split(".")[0] for row in refused} == {"AIRBAG_ADVANCED_ALE_ID"}
    assert [row.deck for row in refused] == ["1", "1", "1", "293", "1.01e-4"]
    rows = json.loads((tmp_path / "case" / "import.json").read_text())["fields"]
    assert sum(row["field"].startswith("DEFINE_ALEBAG") for row in rows) >= 50


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("PSET,YES", "PSET,NO", None),
        ("*DEFINE_ALEBAG_INFLATOR\n2", "*DEFINE_ALEBAG_HOLE\n5,3,1,1,0,0,0,1\n*DEFINE_ALEBAG_INFLATOR\n2", "SID"),
        ("0,0,1e10", "0,5,1e10", "START"),
        ("\n0,0,1e10", "\n0,0,15", "END"),
        (",0.6,3,1\n", ",0.6,3,SEGSET\n", "VSET"),
    ],
)
def test_modules_that_a_case_does_not_have_are_refused(use, old, new, field):
    assert old in ADVANCED
    if field is None:
        with pytest.raises(InputError) as error:
            use(ADVANCED.replace(old, new), with_mouth(), ring(-90.0))
        assert (error.value.code, "bag.k" in error.value.where) == ("E-DCK-006", True)
        return
    _, report = use(ADVANCED.replace(old, new), with_mouth(), ring(-90.0), parts={3: "mouth"})
    names = {row.field.split(".")[1] for row in report.of("refused") if row.field.startswith("DEFINE")}
    assert names == {field}


def test_the_unit_of_particles_counts_and_contradictions_are_asked_about(use):
    cards = "*AIRBAG_PARTICLE\n1,1\n5000,{},1,293,1.01e-4\n1,1,0\n1.01e-4,293,0.029,29\n1,2,0.028,29\n"
    with pytest.raises(InputError) as error:
        use(cards.format(1))
    assert error.value.code == "E-DCK-009"
    assert "says kg-m-s, which does not fit" in error.value.why
    _, report = use(cards.format(0))
    assert any("as UNIT at bag.k:" in remark for remark in report.remarks)


ODD = {
    "unevenly": (lambda k: k - k % 2 / 3, "not spaced evenly"),
    "inwards": (lambda k: k, "do not blow away from the axis"),
}


@pytest.mark.parametrize("kind", list(ODD))
def test_holes_that_are_no_ring_of_jets_are_a_diffuse_source(use, kind):
    place, why = ODD[kind]
    sign = -1.0 if kind == "inwards" else 1.0
    more = "*NODE\n"
    for k in range(6):
        x, y = math.cos(place(k) * math.pi / 3), math.sin(place(k) * math.pi / 3)
        more += f"{9001 + k},{300 + 30 * x!r},{300 + 30 * y!r},-90\n"
        more += f"*DEFINE_VECTOR\n{9001 + k},0,0,0,{sign * x!r},{sign * y!r},1\n*NODE\n"
    case, report = use(ALE.format("15"), with_mouth(), more, parts={3: "mouth"})
    assert case.inflators[0].jets.count == 0
    assert all(why in row.note for row in report.rows.values() if row.field.startswith("AIRBAG_ALE.NODEID"))


def test_a_ring_beside_the_middle_of_the_mouth_is_said_to_be_moved(use):
    aside = ring(-90.0)
    rows = [line.split(",") for line in aside.split("*DEFINE")[0].splitlines()[1:]]
    nodes = "".join(f"{n},{float(x) + 20},{y},{z}\n" for n, x, y, z in rows)
    case, report = use(ALE.format("15"), with_mouth(), "*NODE\n" + nodes + "*DEFINE" + aside.split("*DEFINE")[1],
                       parts={3: "mouth"})  # fmt: skip
    assert case.inflators[0].jets.count == 6
    assert {row.note for row in report.of("approximated") if "NODEID" in row.field} == {
        "moved by 20 mm to the middle of the mouth"
    }
