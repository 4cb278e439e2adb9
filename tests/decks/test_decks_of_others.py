"""Decks as they come: normals at random, seams of duplicate nodes, open bags, triangles as quads, units that contradict
each other, gases that are none."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model
from billow.case.obstacles.obstacles import build_body
from billow.case.schema import Case
from billow.decks.import_deck import Options, import_deck
from billow.geometry.surface import check_closed

SIDE, ROWS = 600.0, 6
GAS = """*DEFINE_CURVE
1
0,0
10,1e-3
40,0
*DEFINE_CURVE
2
0,600
100,600
*AIRBAG_HYBRID
1,1
293,1.01e-4,,8.314,1
0,,0
0,,1
1,2,,0.028,1,29

*CONTROL_TERMINATION
20
"""
CLOTH = """*SECTION_SHELL
1,9
0.3,0.3,0.3,0.3
*MAT_FABRIC
1,8e-7,0.4,0.35,,0.2
0.01,,,1
2
,,,1

"""


class Pillow:
    """Two square panels of quads sewn at their edges, in mm; part 1 below, part 2 above. What a test changes are its
    points, cells and parts."""

    def __init__(self, rows: int = ROWS):
        s = np.linspace(0.0, SIDE, rows + 1)
        x, y = (a.ravel() for a in np.meshgrid(s, s))
        bump = 100.0 * np.sin(np.pi * x / SIDE) * np.sin(np.pi * y / SIDE)
        rim = (x == 0) | (y == 0) | (x == SIDE) | (y == SIDE)
        n = rows + 1
        low = np.array([[j * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i] for j in range(rows)
                        for i in range(rows)])  # fmt: skip
        upper = np.arange(n * n)
        upper[~rim] = n * n + np.arange((~rim).sum())
        self.points = np.concatenate([np.column_stack([x, y, -bump]), np.column_stack([x, y, bump])[~rim]])
        self.cells = [[a, d, c, b] for a, b, c, d in low.tolist()] + upper[low].tolist()
        self.parts = [1] * len(low) + [2] * len(low)

    def deck(self, more: str = "", cloth: str = CLOTH, gas: str = GAS) -> str:
        nodes = "".join(f"{k},{x!r},{y!r},{z!r}\n" for k, (x, y, z) in enumerate(self.points.tolist(), 1))
        shells = "".join(
            f"{k},{part},{','.join(str(node + 1) for node in cell)}\n"
            for k, (part, cell) in enumerate(zip(self.parts, self.cells, strict=True), 1)
        )
        numbers = sorted(set(self.parts))
        parts = "".join(f"panel {n}\n{n},1,1\n" for n in numbers)
        sets = "*SET_PART_LIST\n1\n" + ",".join(map(str, numbers)) + "\n"
        return f"*KEYWORD\n*NODE\n{nodes}*ELEMENT_SHELL\n{shells}*PART\n{parts}{sets}{cloth}{gas}{more}*END\n"


@pytest.fixture
def use(tmp_path):
    """Import a deck: its case and report."""

    def make(text: str, **options):
        (tmp_path / "bag.k").write_text(text)
        report = import_deck(tmp_path / "bag.k", tmp_path / "case", Options(**options))
        return Case.load(tmp_path / "case" / "case.toml"), report

    return make


def volume(case: Case) -> float:
    shape = build_shape(case.bag)
    check_closed(shape.surface, shape.positions, "bag")
    return shape.surface.volume(shape.positions)


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    place = tmp_path_factory.mktemp("pillow")
    (place / "bag.k").write_text(Pillow().deck())
    import_deck(place / "bag.k", place / "case")
    found = volume(Case.load(place / "case" / "case.toml"))
    assert 0.02 < found < 0.04
    return found


def test_normals_that_point_inwards_or_at_random_are_turned(use, expected):
    pillow = Pillow()
    rng = np.random.default_rng(3)
    pillow.cells = [cell[::-1] if rng.random() < 0.5 else cell for cell in pillow.cells]
    case, report = use(pillow.deck())
    assert volume(case) == pytest.approx(expected, rel=1e-12)
    assert any("turned so that" in remark for remark in report.remarks)


def test_all_normals_inwards(use, expected):
    pillow = Pillow()
    pillow.cells = [cell[::-1] for cell in pillow.cells]
    case, report = use(pillow.deck())
    assert volume(case) == pytest.approx(expected, rel=1e-12)
    assert any("72 of 72 cells turned" in remark for remark in report.remarks)


def test_nodes_along_a_seam_that_are_there_twice_are_merged_by_a_tolerance_that_is_said(use, expected):
    pillow = Pillow()
    offset = len(pillow.points)
    rng = np.random.default_rng(4)
    pillow.points = np.concatenate([pillow.points, pillow.points + rng.uniform(-0.01, 0.01, pillow.points.shape)])
    pillow.cells = [
        [n + offset for n in cell] if part == 2 else cell for cell, part in zip(pillow.cells, pillow.parts, strict=True)
    ]
    case, report = use(pillow.deck())
    assert volume(case) == pytest.approx(expected, rel=1e-3)
    assert any("24 nodes on open edges merged with others within 0.1 mm" in r for r in report.remarks), report.remarks


def test_without_merging_the_seam_is_open_and_its_edges_are_named(use):
    pillow = Pillow()
    offset = len(pillow.points)
    pillow.points = np.concatenate([pillow.points, pillow.points + np.array([0.0, 0.0, 0.01])])
    pillow.cells = [
        [n + offset for n in cell] if part == 2 else cell for cell, part in zip(pillow.cells, pillow.parts, strict=True)
    ]
    with pytest.raises(InputError, match=r"E-DCK-011.*\n.*\n.*1: 24 nodes.*2: 24 nodes"):
        use(pillow.deck(), merge=0.0)


def opened() -> Pillow:
    """A pillow with a hole of four quads in its lower panel."""
    pillow = Pillow()
    middle = {j * ROWS + i for j in (2, 3) for i in (2, 3)}
    keep = [k for k in range(len(pillow.cells)) if k not in middle]
    pillow.cells, pillow.parts = [pillow.cells[k] for k in keep], [pillow.parts[k] for k in keep]
    return pillow


def test_an_open_bag_names_its_edges_and_is_closed_as_said(use, expected):
    with pytest.raises(InputError) as error:
        use(opened().deck())
    assert error.value.code == "E-DCK-011"
    assert "1: 8 nodes" in error.value.why
    assert "(0.3, 0.3," in error.value.why
    assert "bag.k:" in error.value.where


def lid(material: str, rim: slice = slice(None)) -> str:
    """A part 9 of triangles in the hole of `opened`, whose nodes are those of its edge, or some of them."""
    pillow = opened()
    edges = {}
    for cell in pillow.cells:
        for a, b in zip(cell, cell[1:] + cell[:1], strict=True):
            edges[a, b] = edges.get((a, b), 0) + 1
    free = dict(edge for edge in edges if edge[::-1] not in edges)
    loop = [min(free)]
    while free[loop[-1]] != loop[0]:
        loop.append(free[loop[-1]])
    pairs = zip(loop, loop[1:] + loop[:1], strict=True)
    fans = [f"{900 + k},9,{a + 1},{b + 1},9001,9001\n" for k, (a, b) in enumerate(pairs)]
    centre = pillow.points[loop].mean(axis=0)
    return (
        f"*NODE\n9001,{','.join(map(str, centre))}\n*ELEMENT_SHELL\n{''.join(fans[rim])}*PART\nlid\n9,9,9\n"
        f"*SECTION_SHELL\n9,2\n1,1,1,1\n{material}"
    )


RIGID = "*MAT_RIGID\n9,7.8e-6,210,0.3\n1,7,7\n0\n"


def test_an_edge_on_a_rigid_part_is_the_mouth(use, expected):
    case, report = use(opened().deck(more=lid(RIGID)))
    assert [part.kind for part in case.bag.parts] == ["mouth", "fabric", "fabric"]
    assert any("closed as mouth: all its nodes belong to the rigid part 9" in remark for remark in report.remarks)
    assert not case.obstacles  # its nodes hold the bag


def test_an_edge_on_the_part_that_a_vent_names_is_that_vent(use, expected):
    gas = GAS.replace("\n0,,0\n", "\n0.7,,-9\n")
    assert gas != GAS
    case, report = use(opened().deck(more=lid("*MAT_NULL\n9,1e-6\n"), gas=gas))
    assert [part.kind for part in case.bag.parts] == ["vent", "fabric", "fabric"]
    assert any("closed as vent: all its nodes belong to the vent, part 9" in remark for remark in report.remarks)
    assert case.bag.vents.discharge == pytest.approx(0.7)


def test_a_rigid_part_at_some_nodes_of_an_edge_decides_nothing_and_the_command_decides_all(use):
    with pytest.raises(InputError, match="E-DCK-011"):
        use(opened().deck(more=lid(RIGID, slice(0, 4))))
    case, _ = use(opened().deck(more=lid(RIGID)), close={0: "vent"})
    assert [part.kind for part in case.bag.parts] == ["vent", "fabric", "fabric"]


@pytest.mark.parametrize("kind", ["mouth", "vent"])
def test_what_closes_the_bag_is_mouth_or_vent(use, expected, kind):
    case, report = use(opened().deck(), close={0: kind})
    shape = build_shape(case.bag)
    check_closed(shape.surface, shape.positions, "bag")
    assert [p.kind for p in case.bag.parts].count(kind) == 1
    assert 0.9 * expected < shape.surface.volume(shape.positions) < expected
    if kind == "mouth":
        assert shape.fixed.sum() == 8
        assert abs(shape.mouth_axis[2]) == pytest.approx(1.0)
        assert shape.mouth_axis[2] > 0.0
    assert any("open edge 1" in remark for remark in report.remarks)


def test_quads_with_two_equal_nodes_are_triangles_and_warped_quads_stay(use, expected):
    pillow = Pillow()
    a, b, c, d = pillow.cells[0]
    pillow.cells[0:1] = [[a, b, c, c], [a, c, d, d]]
    pillow.parts.insert(0, 1)
    case, _ = use(pillow.deck())
    assert volume(case) == pytest.approx(expected, rel=2e-3)
    assert build_shape(case.bag).surface.triangle_count == 144


def test_an_edge_of_three_shells_is_refused_with_the_shells(use):
    pillow = Pillow()
    a, b, *_ = pillow.cells[40]
    pillow.cells.append([a, b, b + 30, a + 30])
    pillow.parts.append(2)
    with pytest.raises(InputError) as error:
        use(pillow.deck())
    assert error.value.code == "E-DCK-012"
    assert "3 shells share one edge" in error.value.why
    assert "41" in error.value.why
    assert error.value.where.startswith("bag.k:")


def test_segments_name_the_bag_too(use, expected):
    pillow = Pillow()
    rows = "".join(",".join(str(n + 1) for n in cell) + "\n" for cell in pillow.cells)
    gas = GAS.replace("*AIRBAG_HYBRID\n1,1", "*AIRBAG_HYBRID\n7,0")
    case, _ = use(pillow.deck(more=f"*SET_SEGMENT\n7\n{rows}", gas=gas))
    assert volume(case) == pytest.approx(expected, rel=1e-12)


def test_units_that_contradict_each_other_are_asked_for(use):
    with pytest.raises(InputError) as error:
        use(Pillow().deck(gas=GAS.replace("1.01e-4", "0.101")))
    assert error.value.code == "E-DCK-009"
    assert "kg-mm-ms: ambient pressure 1.01e+08 Pa" in error.value.why
    assert "--units" in error.value.remedy
    for other in ("t-mm-s", "kg-m-s", "g-mm-ms", "lbf-in-s"):
        assert other in error.value.why


def test_a_gas_constant_that_is_none_keeps_flow_of_enthalpy_and_gamma(use):
    """Seen in public decks: cp - cv = 694 in inches and pounds; only mdot cp T and gamma mean anything."""
    begin, end = GAS.index("*AIRBAG_HYBRID"), GAS.index("*CONTROL")
    model = "*AIRBAG_SIMPLE_AIRBAG_MODEL\n1,1\n17.36,24.30,600,1,0.7,100,1.01e-4,1.2e-9\n"
    case, report = use(Pillow().deck(gas=GAS[:begin] + model + GAS[end:]), units="kg-mm-ms")
    (inflator,) = case.inflators
    species = case.gas.species["gas_1"]
    cp = species.a / species.molar_mass
    flow = inflator.mass_flow.value[1] * cp * inflator.temperature
    assert flow == pytest.approx(1.0 * 24.30 * 600.0, rel=1e-9)
    assert species.a / (species.a - 8.31446261815324) == pytest.approx(2430 / 1736)
    assert [row.field.split(".")[1] for row in report.of("approximated")].count("CP") == 1


def test_contacts_walls_and_motion_become_what_a_case_has(use):
    more = (
        "*RIGIDWALL_PLANAR\n0\n0,0,-150,0,0,-149,0.3\n*RIGIDWALL_GEOMETRIC_SPHERE_ID\n1,head\n0\n"
        "300,300,400,300,300,401,0.1\n82.5\n*CONTACT_AIRBAG_SINGLE_SURFACE\n1\n0.25\n\n*LOAD_BODY_Z\n9,1\n"
        "*DEFINE_CURVE\n9\n0,9.81e-3\n100,9.81e-3\n*UNHEARD_OF\n1,2\n"
    )
    case, report = use(Pillow().deck(more=more))
    wall, head = case.obstacles
    assert (wall.friction, wall.normal, head.name) == (0.3, (0.0, 0.0, 1.0), "head")
    assert wall.height == pytest.approx(-0.15)
    assert head.radii == pytest.approx((0.0825,) * 3)
    assert head.clearance == pytest.approx(0.4 - 0.0825)
    assert case.run.gravity == pytest.approx((0.0, 0.0, -9.81))
    assert case.fabric.self_contact is True
    assert case.fabric.friction == 0.25
    assert report.keywords == {"UNHEARD_OF": 1}


def test_walls_stand_at_any_angle(use):
    case, report = use(Pillow().deck(more="*RIGIDWALL_PLANAR\n0\n0,-50,0,0,-49,0,0.3\n"))
    (wall,) = case.obstacles
    assert (wall.normal, wall.height) == ((0.0, 1.0, 0.0), 0.0)
    assert wall.offset == pytest.approx((0.0, -0.05))
    model = build_model(case)
    assert model.bodies.bodies[0].distance(np.array([[0.3, 0.25, 7.0]])) == pytest.approx(0.3)
    assert not report.of("refused")


def test_a_rigid_part_becomes_a_body_with_its_mass_and_speed(use):
    pillow = Pillow()
    cube = np.array([[x, y, z] for z in (200, 300) for y in (250, 350) for x in (250, 350)], float)
    first = len(pillow.points)
    pillow.points = np.concatenate([pillow.points, cube])
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
    shells = "".join(f"{900 + k},9,{','.join(str(first + n + 1) for n in c)}\n" for k, c in enumerate(sides))
    more = (
        f"*ELEMENT_SHELL\n{shells}*PART\nbox\n9,9,9\n*SECTION_SHELL\n9,2\n1,1,1,1\n*MAT_RIGID\n9,7.8e-6,210\n"
        "*INITIAL_VELOCITY_RIGID_BODY\n9,0,0,-5\n"
    )
    case, report = use(pillow.deck(more=more))
    (box,) = case.obstacles
    assert box.mass == pytest.approx(6 * 0.01 * 1e-3 * 7800.0)
    assert (box.locked, box.velocity) == (False, pytest.approx((0.0, 0.0, -5.0)))
    assert box.shape == "mesh"
    body = build_body(box)
    np.testing.assert_allclose(body.start.centre, [0.3, 0.3, 0.25], atol=1e-12)
    # Hollow, as a rigid part of shells is: m s^2 5/18 about any axis; a full cube has 1/6.
    np.testing.assert_allclose(body.rigid.inertia, box.mass * 0.1**2 * 5.0 / 18.0, rtol=1e-9)
    np.testing.assert_allclose(body.distance(np.array([[0.3, 0.3, 0.4], [0.3, 0.3, 0.29]])), [[0.1, -0.01]], atol=1e-9)
    assert not report.of("refused")


def test_inertia_of_a_part_counts_where_it_is_said(use):
    pillow, first = Pillow(), len(Pillow().points)
    pillow.points = np.concatenate([pillow.points, [[0, 0, 300], [600, 0, 300], [600, 600, 300], [0, 600, 300]]])
    inertia = "300,300,310,4.5,0,0\n40000,0,0,50000,-2000,60000\n0,0,-3,0,0,0.01\n"
    more = (
        f"*ELEMENT_SHELL\n900,9,{first + 1},{first + 2},{first + 3},{first + 4}\n*PART_INERTIA\ntable\n9,9,9\n{inertia}"
        "*SECTION_SHELL\n9,2\n4,4,4,4\n*MAT_RIGID\n9,7.8e-6,210\n"
    )
    case, report = use(pillow.deck(more=more))
    (table,) = case.obstacles
    assert (table.mass, table.thickness, *table.centre) == pytest.approx((4.5, 0.004, 0.3, 0.3, 0.31))
    assert table.inertia == pytest.approx((0.04, 0.05, 0.06, 0.0, -0.002, 0.0))
    assert (table.velocity[2], table.spin[2]) == pytest.approx((-3.0, 10.0))
    rows = [row for row in report.rows.values() if row.field.startswith("PART_INERTIA")]
    assert len(rows) == 18  # a row for every field
    assert {row.status for row in rows if row.deck not in ("", "0")} == {"mapped"}


def test_a_node_based_reference_is_the_flat_cut(use):
    pillow = Pillow()
    rows = "".join(f"{k},{x!r},{y!r},0.0\n" for k, (x, y, _) in enumerate(pillow.points.tolist(), 1))
    case, _ = use(pillow.deck(more=f"*AIRBAG_REFERENCE_GEOMETRY_BIRTH\n2\n{rows}"))
    shape = build_shape(case.bag)
    assert np.abs(0.5 * np.linalg.det(np.diff(shape.reference, axis=1))).sum() == pytest.approx(2 * 0.36)
    assert case.bag.birth_time == pytest.approx(2e-3)


def test_the_warp_runs_as_vectors_and_angles_say(use):
    flat = "".join(f"{k},{x!r},{y!r},0.0\n" for k, (x, y, _) in enumerate(Pillow().points.tolist(), 1))
    for card, angle in (("2\n,,,1,1,0", 45.0), ("3\n,,,,,,\n0,1,0,,,,30", -30.0), ("3\n\n0,1,0,,,,30", -30.0)):
        cloth = CLOTH.replace("2\n,,,1\n\n", card + "\n\n" if card.count("\n") == 1 else card + "\n")
        case, _ = use(Pillow().deck(cloth=cloth, more=f"*AIRBAG_REFERENCE_GEOMETRY\n{flat}"))
        low, up = case.bag.parts
        assert abs(up.warp_angle) == pytest.approx(abs(angle)), card
        assert abs(low.warp_angle) == pytest.approx(abs(angle)), card
        if "30" in card:  # BETA counts about each normal, so the panels differ in the drawing
            assert low.warp_angle == pytest.approx(-up.warp_angle)
            assert up.warp_angle == pytest.approx(30.0)
        shutil.rmtree(Path(case.bag.start).parent)


def test_every_field_of_other_airbags_materials_and_contacts_is_named_too(use, tmp_path):
    more = (
        "*MAT_ELASTIC_TITLE\nsteel\n8,7.8e-6,210,0.3\n*MAT_ADD_AIRBAG_POROSITY_LEAKAGE\n1,0.02,1.5e-3,0.1,8\n"
        "*MAT_ADD_AIRBAG_POROSITY_LEAKAGE\n9,0.5,1\n*AIRBAG_INTERACTION\n1,2,100,0.7\n"
        "*CONTACT_NODES_TO_SURFACE\n1,2,3,4\n0.2,0.1\n1,1\n*AIRBAG_HYBRID\n2,1\n293,1.01e-4,,8.314,1\n0,,0\n0,,1\n"
        "1,2,,0.028,1,29\n"
    )
    case, report = use(Pillow().deck(more=more), airbag=1)
    rows = {(row.place, row.deck): row.status for row in report.rows.values()}
    lines = (tmp_path / "bag.k").read_text().splitlines()
    checked, inside = 0, False
    for number, line in enumerate(lines, 1):
        if line.startswith("*"):
            inside, title = line.startswith(("*AIRBAG", "*MAT", "*CONTACT")), "_TITLE" in line
            continue
        if inside and not title:
            for text in filter(None, line.split(",")):
                assert (f"bag.k:{number}", text) in rows, (number, text)
                checked += 1
        title = False
    assert checked > 60
    assert (case.leakage.law, case.leakage.blockage) == ("velocity-curve", True)
    assert case.leakage.time_factor == 0.02
    assert case.leakage.pressure_factor == pytest.approx(1.5e-3)
    assert case.leakage.through_blocked == pytest.approx(0.1)
    assert "AIRBAG_INTERACTION" in report.keywords
    assert all(row.field.startswith("AIRBAG_INTERACTION") for row in report.of("refused"))


def test_a_coefficient_that_is_not_zero_counts_before_its_curve(use):
    """Of C23 and LCC23 the first counts unless it is zero (manual, *AIRBAG_WANG_NEFSKE)."""
    for card, expected in (("0.6,2,100", 0.6), ("0,3,100", (1.0, 0.5))):
        gas = GAS.replace("0,,0\n0,,1", f"{card}\n0,,1") + "*DEFINE_CURVE\n3\n0,1\n100,0.5\n"
        case, _ = use(Pillow().deck(gas=gas))
        (exit_,) = case.gas.orifices
        assert exit_.area == pytest.approx(1e-4)
        found = exit_.discharge if isinstance(expected, float) else exit_.discharge.value
        assert found == expected
        shutil.rmtree(Path(case.bag.start).parent)


def test_a_gas_that_is_not_in_the_units_of_the_model_is_said(use):
    begin, end = GAS.index("*AIRBAG_HYBRID"), GAS.index("*CONTROL")
    model = "*AIRBAG_WANG_NEFSKE\n1,1\n718,1005,600,0,1\n0.7,,100\n1.01e-4,1.2e-9,{}\n"
    for constant, refused in (("1.0", []), ("386.4", ["AIRBAG_WANG_NEFSKE.GC"])):
        case, report = use(Pillow().deck(gas=GAS[:begin] + model.format(constant) + GAS[end:]), units="kg-mm-ms")
        assert [row.field for row in report.of("refused")] == refused
        assert case.gas.species["gas_1"].molar_mass == pytest.approx(8.31446261815324 / 287.0)
        shutil.rmtree(Path(case.bag.start).parent)


def test_forms_of_fabric_without_curves_take_their_moduli(use):
    cloth = CLOTH.replace("2\n,,,1\n\n", "2,,,,,14\n,,,1\n\n0,0,0\n")
    case, report = use(Pillow().deck(cloth=cloth))
    assert case.fabric.law == "curves-shear"
    warp, shear = case.fabric.curves.warp.loading, case.fabric.curves.shear.loading
    assert warp.stress[-1] / warp.strain[-1] == pytest.approx(0.4e9)
    assert shear.stress[-1] / np.radians(shear.angle[-1]) == pytest.approx(0.01e9)
    assert not report.of("refused")


@pytest.mark.parametrize(
    ("measure", "strain", "stress"),
    [("true", 0.2, 20e6), ("engineering", np.log(1.2), 20e6), ("green", 0.5 * np.log(1.4), 20e6 * np.sqrt(1.4))],
)
def test_curves_of_fabric_are_of_the_measure_that_is_said(use, measure, strain, stress):
    """At constant width a nominal stress is the true stress, and S of Green strain E is S times the stretch."""
    cloth = CLOTH.replace("2\n,,,1\n\n", "2,,,,,14\n,,,1\n\n5,5,6\n")
    curves = "*DEFINE_CURVE\n5\n-0.1,-1\n0,0\n0.2,0.02\n*DEFINE_CURVE\n6\n0,0\n0.5,1e-3\n"
    case, _ = use(Pillow().deck(cloth=cloth, more=curves), measure=measure)
    for yarn in (case.fabric.curves.warp, case.fabric.curves.weft):
        assert yarn.loading.strain == pytest.approx((0.0, strain))
        assert yarn.loading.stress == pytest.approx((0.0, stress))
    assert case.fabric.curves.transverse == 0.0
    assert case.fabric.curves.shear.loading.angle[-1] == pytest.approx(np.degrees(0.5))


def test_nodes_that_are_constrained_or_belong_to_a_locked_part_are_fixed(use):
    pillow = Pillow()
    more = (
        "*BOUNDARY_SPC_NODE\n25,0,1,1,1\n1,0,1,1,0\n9999,0,1,1,1\n*SET_NODE_LIST\n5\n18,19\n"
        "*BOUNDARY_SPC_SET\n5,0,1,1,1,1,1,1\n*ELEMENT_SHELL\n900,9,26,27,9001,9001\n*NODE\n9001,350,250,-300\n"
        "*PART\ninflator\n9,9,9\n*MAT_RIGID\n9,7.8e-6,210,0.3\n1,7,7\n*CONSTRAINED_EXTRA_NODES_NODE\n9,33\n"
    )
    case, report = use(pillow.deck(more=more))
    assert [n + 1 for n in case.bag.fixed_nodes] == [18, 19, 25, 26, 27, 33]
    assert case.obstacles == ()
    assert [(group.numbers, group.motion.directions) for group in case.nodes] == [((0,), ("x", "y"))]
    assert not report.of("refused")


@pytest.mark.parametrize("moduli", ["0,0.35", "-0.4,0.35", "0.4,-1", "nan,0.35"])
def test_moduli_that_cannot_be_are_refused_with_their_line(use, moduli):
    with pytest.raises(InputError, match=r"E-DCK-004(.|\n)*bag\.k:\d+"):
        use(Pillow().deck(cloth=CLOTH.replace("0.4,0.35", moduli)))


def test_columns_of_a_reference_are_those_whose_ids_are_nodes(use):
    points = Pillow().points.tolist()
    narrow = "".join(f"{k:8d}{x:16.6f}{y:16.6f}{0.0:16.6f}\n" for k, (x, y, _) in enumerate(points, 1))
    wide = "".join(f"{k:10d}{x:20.6f}{y:20.6f}{0.0:20.6f}\n" for k, (x, y, _) in enumerate(points, 1))
    cut = []
    for rows in (narrow, wide):
        case, _ = use(Pillow().deck(more=f"*AIRBAG_REFERENCE_GEOMETRY\n{rows}"))
        cut.append(build_shape(case.bag).reference)
        shutil.rmtree(Path(case.bag.start).parent)
    assert np.array_equal(*cut)
    with pytest.raises(InputError, match=r"E-DCK-006(.|\n)*node 999"):
        use(Pillow().deck(more=f"*AIRBAG_REFERENCE_GEOMETRY\n{narrow}{999:8d}\n"))


SPRING = "\n*PART\nspring\n8,8,8\n*MAT_SPRING_ELASTIC\n8,0.01\n"
STRAPS = {
    f"*ELEMENT_DISCRETE\n901,8,25,74,0,2.0,0,-5.0{SPRING}": (2 * 1e4 * 0.205, 5e-3, True),
    f"*ELEMENT_DISCRETE\n901,8,25,74,0,,0,5.0{SPRING}": (1e4 * 0.195, -5e-3, True),
    "*ELEMENT_BEAM\n901,8,25,74,0\n902,8,24,73,0\n*PART\ncable\n8,8,8\n*SECTION_BEAM\n8,6\n0,0,0,30\n"
    "*MAT_CABLE_DISCRETE_BEAM\n8,1.1e-6,2.0\n": (2 * 2e9 * 30e-6, 0.0, False),
    "*ELEMENT_SEATBELT\n901,8,25,74,0,7.0\n*PART\nbelt\n8,8,8\n*MAT_SEATBELT\n8,6e-5,77\n"
    "*DEFINE_CURVE\n77\n0,0\n0.1,6\n": (60e3, 7e-3, False),
    "*ELEMENT_BEAM\n901,8,25,74,0\n*PART\ntruss\n8,8,8\n*SECTION_BEAM\n8,3\n20,0,0\n*MAT_ELASTIC\n8,1e-6,3.0,0.3\n":
    (3e9 * 20e-6, 0.0, True),
}  # fmt: skip


@pytest.mark.parametrize("more", list(STRAPS), ids=["loose spring", "tense spring", "cable", "belt", "truss"])
def test_beams_springs_and_belts_between_nodes_of_the_bag_are_straps(use, more):
    stiffness, slack, pushes = STRAPS[more]
    pillow = Pillow()
    middle = [int(np.argmin(np.linalg.norm(pillow.points - [300, 300, z], axis=1))) + 1 for z in (-100, 100)]
    aside = [int(np.argmin(np.linalg.norm(pillow.points - [200, 300, z], axis=1))) + 1 for z in (-87, 87)]
    for old, new in zip(("25,74", "24,73"), (middle, aside), strict=True):
        more = more.replace(old, ",".join(map(str, new)))
    case, report = use(pillow.deck(more=more))
    (strap,) = case.bag.straps
    assert strap.stiffness == pytest.approx(stiffness)
    assert strap.slack == pytest.approx(max(slack, 0.0))
    assert any("only pulls" in remark for remark in report.remarks) == pushes
    assert not report.of("refused")
    model = build_model(case)
    assert model.straps.length[0] == pytest.approx(0.2 + slack)
    assert model.straps.stiffness.sum() == pytest.approx(stiffness)  # of a spring: K times the length without tension


def test_what_is_no_strap_is_left_out_with_a_word(use):
    more = "*ELEMENT_BEAM\n901,8,25,9999,0\n*NODE\n9999,0,0,900\n*PART\nx\n8,8,8\n*MAT_ELASTIC\n8,1e-6,3.0,0.3\n"
    case, report = use(Pillow().deck(more=more))
    assert not case.bag.straps
    assert any("1 beams, springs or seat belts left out" in remark for remark in report.remarks)
