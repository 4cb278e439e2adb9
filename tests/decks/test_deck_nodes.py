"""Nodes of the bag that decks throw, hold and move, in and out; and bodies that spin about an axis."""

from __future__ import annotations

import numpy as np
import pytest
from test_deck_motions import CURVES, SIDES, moved
from test_decks_of_others import Pillow

from billow.case.build import build_model
from billow.case.obstacles.obstacles import build_body
from billow.case.schema import Case
from billow.decks.export_deck import export_deck
from billow.decks.import_deck import Options, import_deck
from billow.geometry.bag_shapes import square_bag
from billow.geometry.mesh_file import CellMesh
from billow.geometry.mesh_writing import write_mesh
from billow.parts.bodies.rigid_body import spin as spin_of

SET = "*SET_NODE_LIST\n78\n1,2,3\n"


@pytest.fixture
def use(tmp_path):
    """Import a pillow with a rigid box of 100 mm, part 9, above it: the case and the report."""

    def make(more: str, free: bool = True, nodes=lambda deck: deck):
        pillow = Pillow()
        first = len(pillow.points)
        cube = np.array([[x, y, z] for z in (200, 300) for y in (250, 350) for x in (250, 350)], float)
        pillow.points = np.concatenate([pillow.points, cube])
        shells = "".join(f"{900 + k},9,{','.join(str(first + n + 1) for n in c)}\n" for k, c in enumerate(SIDES))
        constraint = "0" if free else "1,7,7"
        box = (
            f"*ELEMENT_SHELL\n{shells}*PART\nbox\n9,9,9\n*SECTION_SHELL\n9,2\n1,1,1,1\n"
            f"*MAT_RIGID\n9,7.8e-6,210\n{constraint}\n0\n"
        )
        (tmp_path / "bag.k").write_text(nodes(pillow.deck(more=box + CURVES + more)))
        case = tmp_path / f"case_{len(list(tmp_path.iterdir()))}"
        report = import_deck(tmp_path / "bag.k", case, Options())
        return Case.load(case / "case.toml"), report

    return make


def rows(report, keyword: str) -> dict[str, str]:
    """Status of each field of a keyword."""
    return {
        row.field.split(".")[1]: row.status
        for row in report.rows.values()
        if row.field.split(".")[0] == keyword and row.deck
    }


def test_a_spin_about_an_axis_throws_nodes_and_bodies(use):
    """rad/ms about z through (300, 300, 0) mm, and 2 m/s along y: of everything."""
    case, report = use("*INITIAL_VELOCITY_GENERATION\n0,0,0.05,0,2,0\n300,300,0,0,0,-2,0,0\n")
    (group,) = case.nodes
    assert (group.velocity, group.spin) == ((0.0, 2.0, 0.0), (0.0, 0.0, -50.0))
    assert group.about == pytest.approx((0.3, 0.3, 0.0))
    model = build_model(case)
    x, y = model.start[:, 0] - 0.3, model.start[:, 1] - 0.3
    np.testing.assert_allclose(model.start_velocity[:, 0], 50.0 * y, atol=1e-12)
    np.testing.assert_allclose(model.start_velocity[:, 1], 2.0 - 50.0 * x, atol=1e-12)
    body = build_body(case.obstacles[0])
    assert body.start.velocity == pytest.approx([0.0, 2.0, 0.0])  # its centre lies on the axis
    assert spin_of(body.rigid, body.start) == pytest.approx([0.0, 0.0, -50.0])
    assert not report.of("refused")
    assert set(rows(report, "INITIAL_VELOCITY_GENERATION").values()) == {"mapped", "ignored"}
    assert rows(report, "INITIAL_VELOCITY_GENERATION")["OMEGA"] == "mapped"


def test_a_spin_moves_the_centre_of_a_body_that_lies_beside_the_axis(use):
    case, _ = use("*INITIAL_VELOCITY_GENERATION\n9,2,0.05,0,0,0\n0,300,0,0,0,1,0,0\n")
    assert not case.nodes
    assert case.obstacles[0].velocity == pytest.approx((0.0, 15.0, 0.0))
    assert case.obstacles[0].spin == pytest.approx((0.0, 0.0, 50.0))


def test_a_body_by_its_own_card_counts_before_others(use):
    case, report = use("*INITIAL_VELOCITY\n0\n1,2,3\n*INITIAL_VELOCITY_RIGID_BODY\n9,0,0,-5\n")
    assert case.obstacles[0].velocity == (0.0, 0.0, -5.0)
    assert [group.velocity for group in case.nodes] == [(1.0, 2.0, 3.0)]
    assert not report.of("refused")


def test_a_later_card_counts_and_that_of_a_node_before_those_of_sets(use):
    more = (
        "*INITIAL_VELOCITY_NODE\n2,0,0,9\n*INITIAL_VELOCITY_SET\n78\n0,0,4\n*INITIAL_VELOCITY_GENERATION\n1,2,0,0,0,3\n"
    )
    case, report = use(SET + more)
    by_velocity = {group.velocity[2]: group.numbers for group in case.nodes}
    assert by_velocity[9.0] == (1,)
    assert set(by_velocity[3.0]) == set(range(49)) - {1}
    assert 4.0 not in by_velocity  # the three nodes belong to part 1 as well
    assert rows(report, "INITIAL_VELOCITY_SET")["NSID"] == "approximated"


def test_cards_of_single_nodes_that_say_the_same_are_one_group(use):
    case, report = use(
        "*INITIAL_VELOCITY_NODE\n" + "".join(f"{n},0,0,{8 if n == 7 else 5}\n" for n in range(1, 50)) + "7,0,0,5\n"
    )
    (group,) = case.nodes
    assert group.velocity == (0.0, 0.0, 5.0)
    assert group.numbers == tuple(range(49))
    assert [row.field for row in report.of("ignored") if "a later card" in row.note] == ["INITIAL_VELOCITY_NODE.NID"]
    assert not report.of("refused")


def test_inertia_keeps_its_velocity_unless_a_card_resets_it(use, tmp_path):
    from_deck = lambda deck: deck.replace("*PART\nbox\n9,9,9\n", "*PART_INERTIA\nbox\n9,9,9\n300,300,250,2.0\n"  # noqa: E731
                                          "1e3,0,0,1e3,0,1e3\n0,0,-7\n")  # fmt: skip
    card = "*INITIAL_VELOCITY_GENERATION\n9,2,0,0,0,-4\n0,0,0,0,0,0,0,{}\n"
    case, report = use(card.format(0), nodes=from_deck)
    assert case.obstacles[0].velocity == (0.0, 0.0, -7.0)
    assert [row.field for row in report.of("refused")] == ["INITIAL_VELOCITY_GENERATION.ID"]
    case, report = use(card.format(1), nodes=from_deck)
    assert case.obstacles[0].velocity == (0.0, 0.0, -4.0)
    assert not report.of("refused")


@pytest.mark.parametrize(
    ("more", "field"),
    [
        ("*INITIAL_VELOCITY\n78,,3\n1,0,0\n", "INITIAL_VELOCITY.BOXID"),
        ("*INITIAL_VELOCITY\n78,79\n1,0,0\n0,0,0\n", "INITIAL_VELOCITY.NSIDEX"),
        ("*INITIAL_VELOCITY\n78,,,,4\n1,0,0\n", "INITIAL_VELOCITY.ICID"),
        ("*INITIAL_VELOCITY\n78\n1,0,0,5,0,0\n", "INITIAL_VELOCITY.VXR"),
        ("*INITIAL_VELOCITY_GENERATION\n78,3,1.0\n0,0,0,-999,1,2\n", "INITIAL_VELOCITY_GENERATION.NX"),
        ("*INITIAL_VELOCITY_GENERATION\n78,7\n\n", "INITIAL_VELOCITY_GENERATION.STYP"),
        ("*BOUNDARY_SPC_SET\n78,4,1\n", "BOUNDARY_SPC_SET.CID"),
        ("*BOUNDARY_SPC_SET_BIRTH_DEATH\n78,0,1\n0,5\n", "BOUNDARY_SPC_SET_BIRTH_DEATH.NID"),
        (moved("78,1,2,31\n78,1,2,33", "SET") + "*DEFINE_CURVE\n33\n0,0\n9,9\n",
         "BOUNDARY_PRESCRIBED_MOTION_SET.TYPEID"),
        ("*BOUNDARY_SPC_SET\n78,0,1\n" + moved("78,1,2,31", "SET"), "BOUNDARY_PRESCRIBED_MOTION_SET.TYPEID"),
    ],
)  # fmt: skip
def test_what_a_case_cannot_say_is_refused_by_name(use, more, field):
    _, report = use(SET + more)
    assert [row.field for row in report.of("refused")] == [field]


def test_single_directions_are_held_by_node_cards_and_constraints(use):
    def held(deck: str) -> str:
        at = deck.index("*NODE\n4," if "*NODE\n4," in deck else "\n4,") + 1
        end = deck.index("\n", at)
        return deck[:end] + ",3" + deck[end:]

    case, report = use(SET + "*BOUNDARY_SPC_SET\n78,0,1,0,1\n*BOUNDARY_SPC_NODE\n3,0,0,1\n", nodes=held)
    assert case.bag.fixed_nodes == (2,)
    found = {group.motion.directions: group.numbers for group in case.nodes}
    assert found == {("x", "z"): (0, 1), ("z",): (3,)}
    driven = build_model(case).driven
    assert driven.nodes.tolist() == [0, 1, 3]
    assert np.trace(driven.held, axis1=1, axis2=2).tolist() == [2.0, 2.0, 1.0]
    assert not report.of("refused")


def test_motions_of_nodes_move_them(use):
    more = moved("78,3,2,31\n78,1,0,33", "SET") + "*DEFINE_CURVE\n33\n0,0\n5,2\n"
    case, report = use(SET + more)
    along_z, along_x = (group.motion for group in case.nodes)
    assert (along_z.kind, along_z.direction, along_z.across) == ("travel", (0.0, 0.0, 1.0), "free")
    assert along_z.travel.value == pytest.approx((0.0, 0.010, 0.015, 0.015))
    assert (along_x.kind, along_x.direction) == ("speed", (1.0, 0.0, 0.0))
    assert along_x.speed.value == (0.0, 2.0)
    model = build_model(case)
    np.testing.assert_allclose(model.driven.path(5e-3)[0] - model.start[0], [5e-3, 0.0, 0.010], atol=1e-12)
    assert not report.of("refused")
    assert rows(report, "BOUNDARY_PRESCRIBED_MOTION_SET")["TYPEID"] == "mapped"


def test_a_line_that_is_no_axis_with_and_without_freedom_across(use):
    vector = "*DEFINE_VECTOR\n5,0,0,0,0,3,4\n"
    for way, across in ((4, "free"), (-4, "held")):
        case, report = use(SET + vector + moved(f"78,{way},2,31,1.0,5", "SET"))
        assert case.nodes[0].motion.direction == pytest.approx((0.0, 0.6, 0.8))
        assert case.nodes[0].motion.across == across
        assert not report.of("refused")


def test_nodes_of_a_rigid_part_that_moves_go_with_it(use):
    case, report = use("*CONSTRAINED_EXTRA_NODES_SET\n9,78\n" + SET + moved("9,3,2,31"), free=False)
    (group,) = case.nodes
    assert (group.name, group.numbers, group.motion.kind, group.motion.across) == ("box", (0, 1, 2), "travel", "held")
    assert not case.bag.fixed_nodes
    assert not report.of("refused")


def test_groups_of_nodes_come_back_from_a_deck(tmp_path):
    shape = square_bag(0.2, 4, 0.02)
    cells = np.column_stack([shape.surface.triangles.astype(np.int64), np.full(shape.surface.triangle_count, -1)])
    write_mesh(tmp_path / "bag.vtkhdf", CellMesh(shape.positions, cells, shape.surface.part + 1, {}))
    curve = {"time": [0.0, 1e-3, 4e-3], "value": [0.0, 3e-3, 5e-3]}
    case = Case.from_dict({
        "bag": {"shape": "mesh", "start": str(tmp_path / "bag.vtkhdf"),
                "parts": [{"name": "front", "number": 1}, {"name": "rear", "number": 2}]},
        "inflator": {"jets": {"count": 0}}, "obstacles": [],
        "nodes": [
            {"name": "thrown", "velocity": [1, 2, 3], "spin": [10, -20, 5], "about": [0.1, 0, 0.3]},
            {"name": "plane", "high": [-0.09, 1, 1], "motion": {"kind": "fixed", "directions": ["y", "z"]}},
            {"name": "pull", "low": [0.09, -1, -1],
             "motion": {"kind": "travel", "travel": curve, "direction": [1, 0, 2], "across": "free"}},
            {"name": "push", "numbers": [12],
             "motion": {"kind": "speed", "speed": curve, "direction": [0, -1, 0]}},
        ],
    })  # fmt: skip
    notes = export_deck(case, tmp_path / "bag.k", "t-mm-s")
    assert not [note for note in notes if "nodes" in note]
    report = import_deck(tmp_path / "bag.k", tmp_path / "case", Options(units="t-mm-s"))
    assert not [row for row in report.of("refused") if "INITIAL" in row.field or "BOUNDARY" in row.field]
    one, other = build_model(case), build_model(Case.load(tmp_path / "case" / "case.toml"))
    np.testing.assert_allclose(other.start_velocity, one.start_velocity, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(other.inverse_mass > 0.0, one.inverse_mass > 0.0)
    np.testing.assert_array_equal(other.driven.nodes, one.driven.nodes)
    np.testing.assert_allclose(other.driven.held, one.driven.held, atol=1e-12)
    for time in (0.5e-3, 3e-3):
        np.testing.assert_allclose(other.driven.path(time), one.driven.path(time), atol=1e-12)
