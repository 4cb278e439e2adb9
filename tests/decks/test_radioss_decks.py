"""Starter decks of Radioss: a bag of ours comes back bit by bit, forms of the format, and what is refused by place."""

from __future__ import annotations

import json

import numpy as np
import pytest
from radioss_text import DIGITS, ENGINE, MORE, SMALL, of_two_fabrics, starter_of
from test_decks_out_and_in import CASE, same

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.schema import Case
from billow.decks.import_deck import Options, import_deck
from billow.geometry.mesh_file import read_mesh
from billow.run.simulate import simulate


def of_ours() -> Case:
    """The bag of the other decks, as far as a starter deck can say it."""
    inflators = [
        {**table, "name": f"gas_1{k}", "gas": {f"gas_1{k}": 1.0}} for k, table in enumerate(CASE["inflator"], 1)
    ]
    species = {f"gas_1{k}": CASE["gas"]["species"][f"gas_{k}"] for k in (1, 2)}
    gas = {
        **CASE["gas"], "species": species, "initial": {"gas": {"gas_11": 1.0}, "temperature": 291.0},
        "orifices": [{"name": "hole_1", "between": ["bag", "ambient"], "area": 1.2e-4, "discharge": 1.0}],
    }  # fmt: skip
    fabric = {key: value for key, value in CASE["fabric"].items() if key not in ("liner", "damping")}
    bag = {**CASE["bag"], "vents": {"count": 1, "discharge": 0.65, "opening_pressure": 2000.0, "burst_time": 0.03}}
    return Case.from_dict({
        **CASE, "bag": bag, "fabric": fabric, "gas": gas, "inflator": inflators, "leakage": {},
        "obstacles": CASE["obstacles"][:1],
    })  # fmt: skip


@pytest.fixture(scope="module")
def brought(tmp_path_factory):
    place = tmp_path_factory.mktemp("radioss")
    (place / "bag_0000.rad").write_text(starter_of(of_ours()))
    (place / "bag_0001.rad").write_text(ENGINE)
    report = import_deck(place / "bag_0000.rad", place / "case")
    return Case.load(place / "case" / "case.toml"), report, place


def test_mesh_and_flat_cut_keep_their_bits(brought):
    case, report, _ = brought
    before, after = build_shape(of_ours().bag), build_shape(case.bag)
    assert not report.of("refused")
    assert np.array_equal(before.surface.triangles, after.surface.triangles)
    assert before.surface.part_names == after.surface.part_names
    assert before.surface.part_kinds == after.surface.part_kinds
    assert np.array_equal(np.round(before.positions, DIGITS) + 0.0, after.positions + 0.0)
    cloth = before.surface.triangles_of_kind("fabric")
    assert np.array_equal(np.round(before.reference, DIGITS)[cloth] + 0.0, after.reference[cloth] + 0.0)
    assert np.array_equal(before.fixed, after.fixed)


def test_it_is_the_case_that_was_written_and_runs_to_the_same_bits(brought, tmp_path):
    case, _, _ = brought
    native = Case.from_dict({**of_ours().to_dict(), "bag": case.to_dict()["bag"], "title": "bag"})
    assert case.bag.vents.model_dump() == native.bag.vents.model_dump()
    tables = native.to_dict() | {"obstacles": case.to_dict()["obstacles"]}
    same(case, Case.from_dict(tables), 1e-12)
    rows = []
    for number, one in enumerate((case, native)):
        short = Case.from_dict(
            {**one.to_dict(), "obstacles": case.to_dict()["obstacles"], "run": {"end_time": 1e-3, "frames": 2}}
        )
        rows.append((simulate(short, tmp_path / str(number)).folder / "histories.csv").read_bytes())
    assert rows[0] == rows[1]
    assert len(rows[0].splitlines()) == 22


def test_every_line_of_volume_material_and_interface_has_rows(brought):
    _, report, place = brought
    rows = json.loads((place / "case" / "import.json").read_text())["fields"]
    named = {row["place"] for row in rows}
    inside, count = False, 0
    for number, text in enumerate((place / "bag_0000.rad").read_text().splitlines(), 1):
        if text.startswith("/"):
            inside, titled = text.startswith(("/MONVOL", "/MAT", "/INTER/TYPE")), True
        elif text.startswith("#") or not text.strip():
            continue
        elif titled:
            titled = False
        elif inside and not text.startswith("         0         0"):
            assert f"bag_0000.rad:{number}" in named, text
            count += 1
    assert count >= 24
    assert all(row["note"] for row in rows if row["status"] != "mapped")
    assert report.keywords == {}


@pytest.fixture
def use(tmp_path):
    """Import a small deck with changes: its case and report."""

    def make(*changes: tuple[str, str], **options):
        text = SMALL
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        (tmp_path / "small_0000.rad").write_text(text)
        (tmp_path / "more.inc").write_text(MORE)
        report = import_deck(tmp_path / "small_0000.rad", tmp_path / "case", Options(**options))
        return Case.load(tmp_path / "case" / "case.toml"), report

    return make


def test_parameters_includes_comments_and_local_units(use):
    case, report = use()
    shape = build_shape(case.bag)
    assert shape.surface.volume(shape.positions) == pytest.approx(0.3**3 / 6.0)
    assert (case.fabric.density, case.fabric.young_warp) == (800.0, 4e8)  # in the units of /UNIT/7
    assert (case.fabric.poisson, case.fabric.compression) == (0.2, False)
    assert case.fabric.thickness == pytest.approx(0.3e-3)
    assert case.run.gravity == pytest.approx((0.0, 0.0, -9.8))
    assert report.keywords == {"/RBODY": 1}
    assert not report.of("refused")


def test_gases_flows_and_holes(use):
    """A mass of 10 g in 10 ms and 10 g in 30 ms is 1 kg/s, then 1/3 kg/s; the sensor fires at 2 ms."""
    case, report = use()
    (inflator,) = case.inflators
    flow = inflator.mass_flow
    assert np.interp([0.005, 0.02], flow.time, flow.value) == pytest.approx([1.0, 1.0 / 3.0])
    assert np.trapezoid(flow.value, flow.time) == pytest.approx(0.02, rel=1e-3)
    assert (inflator.delay, inflator.temperature) == (pytest.approx(2e-3), 600.0)
    hot, air = case.gas.species["gas_11"], case.gas.species["gas_12"]
    assert (hot.a, hot.b) == (pytest.approx(0.028 * 1000.0), pytest.approx(0.028 * 0.1))
    assert air.molar_mass == pytest.approx(8.31446261815324 / 287.0)
    assert [(o.area, o.discharge) for o in case.gas.orifices] == [
        (pytest.approx(20e-6), 1.0),
        (pytest.approx(10e-6), 0.5),
    ]
    assert "/PROP/INJECT1/31.fun_ID_M[1]" in {row.field for row in report.of("approximated")}


def test_walls(use):
    case, _ = use()
    (head,) = case.obstacles
    assert (head.name, head.friction) == ("head", 0.0)  # Slide 0
    assert head.radii == pytest.approx((0.0825,) * 3)
    assert head.clearance == pytest.approx(0.5 - 0.0825)


PLANE = "/RWALL/PLANE/1\nfloor\n         0         2\n                 0.0                 0.3\n" + (
    " " * 19 + "0" + " " * 19 + "0" + "-100.0".rjust(20) + "\n" + " " * 19 + "0" + " " * 19 + "0" + "0".rjust(20) + "\n"
)


def test_a_plane_is_a_plate_with_friction(use):
    begin, end = SMALL.index("/RWALL"), SMALL.index("/GRAV")
    case, _ = use((SMALL[begin:end], PLANE))
    (floor,) = case.obstacles
    assert (floor.shape, floor.friction, floor.normal) == ("plate", 0.3, (0.0, 0.0, 1.0))
    assert floor.height == pytest.approx(-0.1)


def wall(kind: str, *rows: tuple[float, ...]) -> str:
    """A wall that holds by friction, with its points [mm] and, of a cylinder, the diameter."""
    head = f"/RWALL/{kind}/1\nwall\n         0         2\n"
    size = rows[1][0] if kind == "CYL" else 0.0
    points = [rows[0], rows[-1]]
    lines = "".join("".join(f"{float(v)!r:>20}" for v in point) + "\n" for point in points)
    return head + f"{0.0!r:>20}{0.3!r:>20}{size!r:>20}\n" + lines


def test_planes_and_cylinders_at_any_angle(use):
    begin, end = SMALL.index("/RWALL"), SMALL.index("/GRAV")
    case, report = use((SMALL[begin:end], wall("PLANE", (200.0, 30.0, 50.0), (201.0, 30.0, 50.0))))
    (upright,) = case.obstacles
    assert upright.normal == pytest.approx((1.0, 0.0, 0.0))
    assert (*upright.offset, upright.height) == pytest.approx((0.2, 0.03, 0.05))
    assert not report.of("refused")


def test_a_cylinder_lies_along_its_axis(use, tmp_path):
    begin, end = SMALL.index("/RWALL"), SMALL.index("/GRAV")
    case, _ = use((SMALL[begin:end], wall("CYL", (0.0, 0.0, 900.0), (80.0,), (1.0, 1.0, 900.0))))
    (skew,) = case.obstacles
    assert (skew.shape, skew.radius) == ("cylinder", pytest.approx(0.04))
    assert skew.place == pytest.approx((0.0, 0.0, 0.9))
    assert skew.normal == pytest.approx((0.5**0.5, 0.5**0.5, 0.0))


LAW58 = (
    "/MAT/LAW58/3\nnylon\n              8.0E-7\n"
    + "0.4".rjust(20) + "0.0".rjust(20) + "0.35".rjust(20) + "0.0".rjust(20) + "0.01".rjust(20) + "\n"
    + "0.01".rjust(20) + "\n\n\n" + "51".rjust(10) + " " * 10 + "1.E-3".rjust(20) + "\n"
    + "/FUNCT/51\nwarp\n" + "0".rjust(20) + "0".rjust(20) + "\n" + "0.2".rjust(20) + "20.".rjust(20) + "\n"
)  # fmt: skip


def test_law58_takes_functions_and_moduli(use):
    begin, end = SMALL.index("/MAT/FABRI"), SMALL.index("/SURF/PART")
    case, report = use((SMALL[begin:end], LAW58), measure="engineering")
    curves = case.fabric.curves
    assert case.fabric.law == "curves-shear"
    assert curves.warp.loading.strain == pytest.approx((0.0, np.log(1.2)))
    assert curves.warp.loading.stress == pytest.approx((0.0, 20e6))
    assert curves.weft.loading.stress[-1] / curves.weft.loading.strain[-1] == pytest.approx(0.35e9)
    assert curves.shear.loading.stress[-1] / np.radians(curves.shear.loading.angle[-1]) == pytest.approx(0.01e9)
    assert not report.of("refused")


def test_parts_of_other_fabric_have_tables_of_their_own(tmp_path):
    (tmp_path / "more.inc").write_text(MORE)
    (tmp_path / "two_0000.rad").write_text(of_two_fabrics())
    report = import_deck(tmp_path / "two_0000.rad", tmp_path / "case")
    case = Case.load(tmp_path / "case" / "case.toml")
    front, rear = case.fabric.of("bag"), case.fabric.of("rear")
    assert (front.young_warp, rear.young_warp) == (4.0e8, 9.0e8)  # two triangles each: the first part is general
    assert list(case.fabric.parts) == ["rear"]
    assert front.thickness == rear.thickness == pytest.approx(3e-4)
    assert not report.of("refused")
    row = next(row for row in report.rows.values() if row.field.endswith("E11") and row.deck == "9.0E8")
    assert row.key == "fabric.parts.rear.young_warp"


XREF = "/XREF/3\nflat\n         0\n" + "".join(
    f"{n:10d}{x:20.3f}{y:20.3f}{0.0:20.3f}\n" for n, x, y in ((1, 0, 0), (2, 310, 0), (3, 0, 310), (4, 310, 310))
)


def test_a_reference_by_the_nodes_of_a_part(use):
    case, _ = use(("/RBODY/1", XREF + "/RBODY/1"))
    cut = read_mesh(case.bag.reference)
    assert cut.points[np.unique(cut.cells[cut.cells >= 0])] == pytest.approx(
        np.array([[0, 0, 0], [0.31, 0, 0], [0, 0.31, 0], [0.31, 0.31, 0]])
    )


UNITS = "                  kg                  mm                  ms\n/PARAMETER/GLOBAL/REAL/1"
POROUS = SMALL[SMALL.index("         3         0         0\n                 0.0") : SMALL.index("/RWALL")]


@pytest.mark.parametrize(
    ("old", "new", "code", "line"),
    [
        (UNITS, UNITS.replace("kg", "lb"), "E-DCK-161", "6"),
        ("      2022         0", "        44         0", "E-DCK-160", "4"),
        ("#include more.inc", "#include /etc/passwd", "E-DCK-002", "22"),
        ("               &size       ", "               &sise       ", "E-DCK-003", "18"),
        ("        31         5\n", "        32         5\n", "E-DCK-006", ""),
        ("               4.0E8", "               4.oE8", "E-DCK-004", ""),
        (POROUS, "", "E-DCK-005", ""),
    ],
)
def test_what_is_wrong_is_named_with_its_line(use, old, new, code, line):
    with pytest.raises(InputError) as error:
        use((old, new))
    assert error.value.code == code
    assert f"small_0000.rad:{line}" in error.value.where
