"""Prescribed motion in decks: what moves rigid parts and walls, in and out."""

from __future__ import annotations

import numpy as np
import pytest
from test_decks_of_others import Pillow

from billow.case.obstacles.obstacles import build_body
from billow.case.schema import Case
from billow.decks.export_deck import deck_of, export_deck
from billow.decks.import_deck import Options, import_deck
from billow.decks.keyword_file import Deck
from billow.decks.motions import integrated
from billow.parts.bodies.drive import Guided

SIDES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
CURVES = "*DEFINE_CURVE\n31\n0,0\n5,10\n10,15\n100,15\n*DEFINE_CURVE\n32\n0,0\n100,0\n"


@pytest.fixture
def use(tmp_path):
    """Import a pillow with a rigid box, part 9, above it: the box of the case, and the report."""

    def make(more: str, constraint: str = "1,7,7"):
        pillow = Pillow()
        cube = np.array([[x, y, z] for z in (200, 300) for y in (250, 350) for x in (250, 350)], float)
        first = len(pillow.points)
        pillow.points = np.concatenate([pillow.points, cube])
        shells = "".join(f"{900 + k},9,{','.join(str(first + n + 1) for n in c)}\n" for k, c in enumerate(SIDES))
        box = f"*ELEMENT_SHELL\n{shells}*PART\nbox\n9,9,9\n*SECTION_SHELL\n9,2\n1,1,1,1\n*MAT_RIGID\n9,7.8e-6,210\n"
        nodes = "*SET_NODE_LIST\n77\n" + ",".join(str(first + k) for k in range(1, 9)) + "\n"
        (tmp_path / "bag.k").write_text(pillow.deck(more=box + constraint + "\n0\n" + CURVES + nodes + more))
        case = tmp_path / f"case_{len(list(tmp_path.iterdir()))}"
        report = import_deck(tmp_path / "bag.k", case, Options())
        return Case.load(case / "case.toml"), report

    return make


def moved(tail: str, option: str = "RIGID") -> str:
    return f"*BOUNDARY_PRESCRIBED_MOTION_{option}\n{tail}\n"


def test_displacement_is_travel_and_velocity_is_speed(use):
    case, report = use(moved("9,3,2,31,-1.0"))
    motion = case.obstacles[0].motion
    assert (motion.kind, motion.direction) == ("travel", (0.0, 0.0, 1.0))
    assert motion.travel.time == pytest.approx((0.0, 5e-3, 10e-3, 0.1))
    assert motion.travel.value == pytest.approx((0.0, -0.010, -0.015, -0.015))
    assert not report.of("refused")
    rows = {row.field.split(".")[1]: row.status for row in report.rows.values() if "PRESCRIBED" in row.field}
    assert set(rows) == {"TYPEID", "DOF", "VAD", "LCID", "SF", "VID", "DEATH", "BIRTH"}  # every field has a row
    assert [name for name, status in rows.items() if status == "mapped"] == ["TYPEID", "DOF", "VAD", "LCID", "SF"]


def test_velocity_keeps_its_last_value_and_says_so(use):
    case, report = use(moved("9,1,0,33") + "*DEFINE_CURVE\n33\n0,0\n5,2\n")
    motion = case.obstacles[0].motion
    assert (motion.kind, motion.speed.value[-1]) == ("speed", 2.0)
    assert [row.field.split(".")[1] for row in report.of("approximated") if "PRESC" in row.field] == ["LCID"]


def test_several_axes_with_one_curve_are_one_line(use):
    tails = "9,1,2,31,3.0\n9,2,2,32\n9,3,2,31,4.0"
    case, report = use(moved(tails), constraint="1,0,7")
    motion = case.obstacles[0].motion
    assert motion.direction == pytest.approx((0.6, 0.0, 0.8))
    assert motion.travel.value[1] == pytest.approx(0.050)
    assert not report.of("refused")
    assert not [row for row in report.of("approximated") if "PRESC" in row.field]  # held along y, moved along x and z


def test_two_curves_are_refused_and_one_is_taken(use):
    case, report = use(moved("9,1,2,31\n9,3,0,33") + "*DEFINE_CURVE\n33\n0,1\n100,1\n")
    assert case.obstacles[0].motion.direction == (1.0, 0.0, 0.0)
    assert [row.field for row in report.of("refused")] == ["BOUNDARY_PRESCRIBED_MOTION_RIGID.LCID"]


def test_a_vector_a_birth_and_freedom_that_a_case_lacks_are_said(use):
    more = moved("9,4,2,31,1.0,5,,2.0") + "*DEFINE_VECTOR\n5,0,0,0,0,0,-2\n"
    case, report = use(more, constraint="0")
    motion = case.obstacles[0].motion
    assert motion.direction == (0.0, 0.0, -1.0)
    assert motion.travel.time[0] == pytest.approx(2e-3)
    assert motion.travel.value[0] == 0.0
    said = {row.field.split(".")[1]: row.note for row in report.of("approximated") if "PRESC" in row.field}
    assert set(said) == {"BIRTH", "DOF"}
    assert "free along xy, and turns" in said["DOF"]


@pytest.mark.parametrize(
    ("tail", "field"),
    [("9,5,2,31", "DOF"), ("9,3,3,31", "VAD"), ("9,3,2,31,1.0,0,4.0", "DEATH"), ("8,3,2,31", "TYPEID")],
)
def test_what_a_case_cannot_say_is_refused(use, tail, field):
    _, report = use(moved(tail))
    assert [row.field for row in report.of("refused")] == [f"BOUNDARY_PRESCRIBED_MOTION_RIGID.{field}"]


def test_nodes_of_a_rigid_part_move_it_and_curves_of_zeros_hold_nodes_of_the_bag(use):
    case, report = use(moved("77,3,2,31", "SET"))
    assert case.obstacles[0].motion.kind == "travel"
    still = "*SET_NODE_LIST\n78\n1,2,3\n" + moved("78,1,2,32\n78,2,2,32\n78,3,2,32", "SET")
    case, report = use(still)
    assert case.bag.fixed_nodes == (0, 1, 2)
    assert not report.of("refused")


def test_a_part_that_is_held_but_along_one_axis_is_guided(use):
    more = "*INITIAL_VELOCITY_RIGID_BODY\n9,0,0,-5\n*LOAD_RIGID_BODY\n9,3,33,2.0\n*DEFINE_CURVE\n33\n0,0\n100,1\n"
    case, report = use(more, constraint="1,4,7")
    motion = case.obstacles[0].motion
    assert (motion.kind, motion.speed, motion.direction) == ("guided", -5.0, (0.0, 0.0, 1.0))
    assert motion.mass == pytest.approx(6 * 0.01 * 1e-3 * 7800.0)
    assert motion.force.value[1] == pytest.approx(2000.0)  # kN
    assert not report.of("refused")
    (body,) = (build_body(o) for o in case.obstacles)
    assert body.start.velocity.tolist() == [0.0, 0.0, -5.0]


@pytest.mark.parametrize("ends", [(3.0, 3.0), (0.0, 4.0), (2.0, -1.0)])
def test_the_integral_of_an_acceleration_is_its_closed_form(ends):
    """v = a t + (b - a) t^2 / (2 T), and its way but for two thirds of what chords cut off parabolas."""
    a, b = ends
    span = 0.02
    points, off = integrated(np.array([[0.0, a], [span, b]]))
    time, speed = points.T
    assert speed == pytest.approx(a * time + 0.5 * (b - a) * time**2 / span, rel=1e-12, abs=1e-15)
    assert (off == 0.0) == (a == b)
    assert len(points) == 2 if a == b else off <= 1e-4 * np.abs(speed).max()
    way = float(0.5 * (speed[1:] + speed[:-1]) @ np.diff(time))
    assert way == pytest.approx(a * span**2 / 2 + (b - a) * span**2 / 6, rel=1e-12, abs=(1 + 1e-9) * off * span * 2 / 3)


def test_an_acceleration_moves_a_part(use):
    case, report = use(moved("9,3,1,33,-1.0") + "*DEFINE_CURVE\n33\n0,1e-3\n10,1e-3\n100,1e-3\n")
    motion = case.obstacles[0].motion
    assert motion.speed.value == pytest.approx((0.0, -0.01, -0.1))  # 1e-3 mm/ms^2 is 1 m/s^2
    row = next(row for row in report.rows.values() if row.field.endswith("MOTION_RIGID.VAD"))
    assert (row.status, row.si) == ("mapped", "its integral, exact")


def test_walls_move_too(use):
    more = (
        "*RIGIDWALL_PLANAR_MOVING_ID\n1,sled\n0\n0,0,500,0,0,499,0.3\n15.0,4.0\n"
        "*RIGIDWALL_GEOMETRIC_FLAT_MOTION_ID\n2,press\n0\n0,-50,0,0,-49,0,0.3\n0,-50,1,0,0\n31,1,0,2,0\n"
        "*RIGIDWALL_GEOMETRIC_SPHERE_MOTION_ID\n3,head\n0\n900,900,100,900,900,101,0.1\n82.5\n31,0,0,0,-1\n"
        "*RIGIDWALL_GEOMETRIC_CYLINDER_ID\n4,roller\n0\n-500,900,600,-499,900,600,0.1\n40,500\n"
    )
    case, report = use(more)
    sled, press, head, roller, _ = case.obstacles
    assert (roller.shape, roller.radius, roller.length, roller.normal) == ("cylinder", 0.04, 0.5, (1.0, 0.0, 0.0))
    assert roller.place == pytest.approx((-0.25, 0.9, 0.6))
    assert (sled.motion.kind, sled.motion.mass, sled.motion.speed) == ("guided", 15.0, 4.0)
    assert sled.motion.direction == (0.0, 0.0, -1.0)
    assert (press.normal, press.height, press.offset) == ((0.0, 1.0, 0.0), 0.0, (0.0, -0.05))
    assert (press.motion.kind, press.motion.direction) == ("travel", (0.0, 1.0, 0.0))
    assert (head.motion.kind, head.motion.speed.value[1]) == ("speed", 10.0)
    assert not report.of("refused")
    assert not [row for row in report.of("approximated") if "RIGIDWALL" in row.field]


COURSE = {"time": [0.0, 0.005, 0.01], "value": [0.0, 0.01, 0.012]}
SHARED = {"friction": 0.2}
MOVED = [
    {"shape": "plate", "name": "press", "height": -0.3, "normal": [0.6, 0.0, 0.8], "offset": [0.1, 0.2],
     "motion": {"kind": "travel", "direction": [0.0, 3.0, 4.0], "travel": COURSE}},
    {"shape": "plate", "name": "sled", "height": -0.2, "motion":
     {"kind": "guided", "direction": [0, 0, 1], "mass": 15.0, "speed": 3.0}},
    {"shape": "super-ellipsoid", "name": "ball", "radii": 0.08, "clearance": 0.2,
     "motion": {"kind": "speed", "direction": [0, 0, -1], "speed": 2.0}},
    {"shape": "super-ellipsoid", "name": "egg", "radii": [0.08, 0.09, 0.07], "clearance": 0.5,
     "motion": {"kind": "travel", "direction": [0.0, 0.6, -0.8], "travel": COURSE}},
    {"shape": "super-ellipsoid", "name": "drop", "radii": [0.08, 0.09, 0.07], "clearance": 0.8, "motion":
     {"kind": "guided", "direction": [0, 0, -1], "mass": 9.0, "speed": 4.0,
      "force": {"time": [0, 0.01], "value": [0, 5]}}},
]  # fmt: skip


@pytest.mark.parametrize("units", ["kg-mm-ms", "lbf-in-s"])
def test_motions_come_back_from_a_deck(tmp_path, units):
    bag = {"element_size": 0.08, "straps": {"count": 0}, "seam": {"layers": 1.0}}
    case = Case.from_dict({"bag": bag, "obstacles": MOVED, "run": {"end_time": 0.01}})
    notes = export_deck(case, tmp_path / "bag.k", units)
    assert not [note for note in notes if "motion" in note]
    report = import_deck(tmp_path / "bag.k", tmp_path / "case", Options(units=units))
    assert not report.of("refused")
    again = {o.name: o for o in Case.load(tmp_path / "case" / "case.toml").obstacles}
    for before in case.obstacles:
        one, two = (build_body(o) for o in (before, again[before.name]))
        for time in (0.0, 0.003, 0.01):
            a, b = (
                (d.force.at(time) if isinstance(d, Guided) else d.way(time)) * d.direction
                for d in (one.drive, two.drive)
            )
            assert a == pytest.approx(b, rel=1e-6, abs=1e-12), before.name
        assert np.abs(one.drive.direction @ two.drive.direction) == pytest.approx(1.0)
        assert one.start.velocity == pytest.approx(two.start.velocity, rel=1e-6)
        if before.motion.kind == "guided":
            assert two.drive.mass == pytest.approx(one.drive.mass, rel=1e-6)
    (tmp_path / "again.k").write_text(deck_of(case, units)[0])
    assert sum(b.name.startswith("BOUNDARY_PRESCRIBED") for b in Deck(tmp_path / "again.k").blocks) == 1


def test_a_free_body_comes_back_with_its_mesh_mass_and_inertia(tmp_path):
    bag = {"element_size": 0.08, "straps": {"count": 0}, "seam": {"layers": 1.0}}
    head = {"shape": "super-ellipsoid", "name": "head", "radii": [0.08, 0.09, 0.07], "clearance": 0.2, "locked": False,
            "angle_about_x": 30.0, "mass": 4.5, "velocity": [1.0, 0.0, -5.0], "spin": [0.0, 3.0, 0.0]}  # fmt: skip
    case = Case.from_dict({"bag": bag, "obstacles": [head]})
    export_deck(case, tmp_path / "a.k", "t-mm-s")
    import_deck(tmp_path / "a.k", tmp_path / "a", Options(units="t-mm-s"))
    once = Case.load(tmp_path / "a" / "case.toml")
    export_deck(once, tmp_path / "b.k", "kg-mm-ms")
    import_deck(tmp_path / "b.k", tmp_path / "b", Options(units="kg-mm-ms"))
    again = Case.load(tmp_path / "b" / "case.toml")
    first, *others = (build_body(c.obstacles[0]) for c in (case, once, again))
    for other in others:
        assert other.rigid.mass == pytest.approx(4.5)
        np.testing.assert_allclose(np.sort(other.rigid.inertia), np.sort(first.rigid.inertia), rtol=1e-9)
        np.testing.assert_allclose(other.start.centre, first.start.centre, atol=1e-9)
        np.testing.assert_allclose(other.start.velocity, first.start.velocity, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(other.start.angular_momentum, first.start.angular_momentum, rtol=1e-9, atol=1e-12)
    one, two = (body.shapes[0].shape for body in others)
    assert np.array_equal(one.triangles, two.triangles)
    assert np.abs(np.linalg.norm(one.points, axis=1) - np.linalg.norm(two.points, axis=1)).max() < 1e-12
