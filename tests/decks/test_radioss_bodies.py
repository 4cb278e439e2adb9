"""Bodies and motions of starter decks: /RBODY, /IMPDISP, /IMPVEL, /INIVEL, and nodes held in single directions."""

from __future__ import annotations

import numpy as np
import pytest
from radioss_text import MORE, SMALL, line, reals, whole
from test_deck_motions import SIDES

from billow.base.errors import InputError
from billow.case.build import build_model
from billow.case.obstacles.obstacles import build_body
from billow.case.schema import Case
from billow.decks.import_deck import Options, import_deck
from billow.parts.bodies.rigid_body import spin as spin_of

CORNERS = [(x, y, z) for z in (400.0, 500.0) for y in (100.0, 200.0) for x in (100.0, 200.0)]
"""Of a cube of 100 mm, nodes 101 to 108; the main node 109 in its middle."""
CUBE = (
    "/NODE\n"
    + "".join(line((101 + k, 10), *((v, 20) for v in p)) for k, p in enumerate([*CORNERS, (150.0, 150.0, 450.0)]))
    + "/SHELL/9\n" + "".join(whole(901 + k, *(101 + n for n in c)) for k, c in enumerate(SIDES))
    + "/PART/9\nskull\n" + whole(9, 9, 0)
    + "/PROP/TYPE1/9\nsheet\n" + whole(0, 0) + reals(0, 0, 0, 0, 0) + line((1, 10), (0, 10), (1.0, 20))
    + "/MAT/ELAST/9\nsteel\n" + reals(7.8e-6) + reals(210.0, 0.3)
    + "/GRNOD/NODE/90\ncorners\n" + whole(*range(101, 109)) + "/GRNOD/NODE/91\nall\n" + whole(*range(101, 110))
    + "/GRNOD/NODE/92\nmain\n" + whole(109) + "/GRNOD/NODE/93\nof the bag\n" + whole(2, 3)
    + "/FUNCT/61\npush\n" + reals(0.0, 0.0) + reals(10.0, 20.0)
)  # fmt: skip
SHELLS = 6 * 0.1**2 * 1e-3 * 7800.0
"""Mass of the cube's shells [kg]."""


def body(mass: float = 0.0, centre: int = 2, moments=(0.0, 0.0, 0.0), sensor: int = 0) -> str:
    row = line((109, 10), (sensor, 10), (0, 10), (0, 10), (mass, 20), (90, 10), (0, 10), (centre, 10), (0, 10))
    return "/RBODY/5\nskull\n" + row + reals(*moments) + reals(0.0, 0.0, 0.0) + whole(0, 0, 0)


def moved(keyword: str, way: str, group: int, **other) -> str:
    head = line((61, 10), (way, 10), (other.get("skew", 0), 10), (0, 10), (group, 10), (0, 10))
    return (
        f"/{keyword}/7\nmotion\n"
        + head
        + reals(other.get("time", 1.0), other.get("scale", 1.0), 0.0, other.get("stop", 1e30))
    )


@pytest.fixture
def use(tmp_path):
    """Import the small deck, to 30 ms, with more in it: its case and report."""

    def make(more: str):
        text = SMALL.replace("/RBODY/1\na body\n", CUBE + more)
        (tmp_path / "small_0000.rad").write_text(text)
        (tmp_path / "small_0001.rad").write_text("/RUN/small/1\n30.\n")
        (tmp_path / "more.inc").write_text(MORE)
        case = tmp_path / f"case_{len(list(tmp_path.iterdir()))}"
        report = import_deck(tmp_path / "small_0000.rad", case, Options())
        return Case.load(case / "case.toml"), report

    return make


def head(case: Case):
    return next(one for one in case.obstacles if one.name == "skull")


def test_a_body_has_the_mass_of_its_shells_and_of_its_main_node(use):
    case, report = use(body(mass=2.0, centre=3, moments=(4.0, 5.0, 6.0)))  # kg mm^2
    built = build_body(head(case))
    assert not built.rigid.locked
    assert built.rigid.mass == pytest.approx(2.0 + SHELLS)
    # Six sheets of side a and mass m/6 about the middle: 5/18 m a^2 about each axis.
    sheets = 5.0 / 18.0 * SHELLS * 0.1**2
    assert sorted(built.rigid.inertia) == pytest.approx(sorted(sheets + np.array([4e-6, 5e-6, 6e-6])))
    assert built.start.centre == pytest.approx([0.15, 0.15, 0.45])
    assert not report.of("refused")
    assert not report.keywords


def test_a_main_node_beside_the_shells_shifts_centre_and_inertia(use):
    more = body(mass=1.0, centre=3).replace(f"{109:>10}", f"{101:>10}", 1)
    case, _ = use(more)
    built = build_body(head(case))
    assert built.start.centre == pytest.approx([0.1, 0.1, 0.4])
    arm = 0.05**2 * 2.0  # squared distance of the middle from each axis through the corner
    tensor = built.start.rotation @ np.diag(built.rigid.inertia) @ built.start.rotation.T
    assert np.diag(tensor) == pytest.approx(np.full(3, 5.0 / 18.0 * SHELLS * 0.01 + SHELLS * arm))
    assert tensor[0, 1] == pytest.approx(-SHELLS * 0.05**2)


def test_the_mass_of_a_main_node_alone(use):
    case, _ = use(body(mass=3.0, centre=4, moments=(1e4, 1e4, 1e4)))
    built = build_body(head(case))
    assert built.rigid.mass == pytest.approx(3.0)
    assert built.rigid.inertia == pytest.approx(np.full(3, 0.01))


def test_a_body_that_is_held_is_locked_and_one_on_a_rail_guided(use):
    hold = "/BCS/7\nhold\n" + line(("   111 111", 10), (0, 10), (92, 10))
    case, _ = use(body() + hold)
    assert head(case).locked
    assert head(case).motion.kind == "none"
    case, _ = use(body(mass=1.0) + hold.replace("111 111", "110 111"))
    assert head(case).motion.kind == "guided"
    assert head(case).motion.direction == (0.0, 0.0, 1.0)
    assert head(case).motion.mass == pytest.approx(1.0 + SHELLS)


def test_a_motion_of_the_main_node_moves_its_body(use):
    case, report = use(body() + moved("IMPDISP", "Z", 92, scale=-1.0))
    motion = head(case).motion
    assert (motion.kind, motion.direction) == ("travel", (0.0, 0.0, 1.0))
    assert motion.travel.value == pytest.approx((0.0, -0.020))
    case, _ = use(body() + moved("IMPVEL", "x", 91))
    assert (head(case).motion.kind, head(case).motion.speed.value[-1]) == ("speed", 20.0)
    case, _ = use(body() + moved("IMPACC", "Y", 92))
    assert head(case).motion.speed.value[-1] == pytest.approx(100.0)  # 20 mm/ms^2 at 10 ms, from 0
    assert not report.of("refused")


def test_scales_of_time_and_smooth_functions_count(use):
    """Public decks scale a function of 1 to the end of the run; f(t / Ascale_x)."""
    case, report = use(body() + moved("IMPDISP", "Z", 92, time=2.5))
    travel = head(case).motion.travel
    assert (travel.time[-1], travel.value[-1]) == (pytest.approx(0.025), pytest.approx(0.02))
    smooth = "/FUNCT_SMOOTH/62\npush\n" + reals(0.5, 2.0, 0.0, 0.0) + reals(0.0, 0.0) + reals(20.0, 10.0)
    case, report = use(smooth + body() + moved("IMPDISP", "Z", 92).replace("61", "62"))
    travel = head(case).motion.travel
    assert np.interp([0.0025, 0.01], travel.time, travel.value) == pytest.approx([0.02 * 0.103515625, 0.02])
    assert not report.of("refused")


def test_velocities_at_the_start_of_bodies_and_nodes(use):
    turn = "/INIVEL/AXIS/3\nturn\n" + line(("Z", 10), (0, 10), (91, 10)) + reals(0.0, 1.0, 0.0, 0.02)
    throw = "/INIVEL/TRA/4\nthrow\n" + reals(0.0, 0.0, 4.0).rstrip().ljust(60) + whole(93, 0)
    case, report = use(body(mass=1.0) + turn + throw)
    built = build_body(head(case))
    assert built.start.velocity == pytest.approx([-20.0 * 0.15, 1.0 + 20.0 * 0.15, 0.0])
    assert spin_of(built.rigid, built.start) == pytest.approx([0.0, 0.0, 20.0])
    (group,) = case.nodes
    assert (group.velocity, len(group.numbers)) == ((0.0, 0.0, 4.0), 2)
    assert not report.of("refused")


def test_nodes_of_the_bag_are_held_and_moved(use):
    rail = "/BCS/7\nrail\n" + line(("   101 000", 10), (0, 10), (93, 10))
    case, report = use(rail + moved("IMPVEL", "Y", 93))
    held, pushed = case.nodes
    assert held.motion.directions == ("x", "z")
    assert (pushed.motion.kind, pushed.motion.direction, pushed.motion.across) == ("speed", (0.0, 1.0, 0.0), "free")
    driven = build_model(case).driven
    np.testing.assert_allclose(driven.path(10e-3) - driven.path(0.0), [[0.0, 0.1, 0.0]] * 2, atol=1e-12)
    assert not report.of("refused")


def test_a_part_that_stands_still_is_an_obstacle_and_another_is_left_out(use):
    case, report = use("")
    assert [one.shape for one in case.obstacles] == ["super-ellipsoid"]
    assert any("part 9 is left out" in remark for remark in report.remarks)
    case, _ = use("/BCS/7\nhold\n" + line(("   111 000", 10), (0, 10), (90, 10)))
    assert head(case).locked


@pytest.mark.parametrize(
    ("more", "field"),
    [
        (body(sensor=5), "/RBODY/5.sens_ID"),
        (body() + moved("IMPVEL", "ZZ", 92), "/IMPVEL/7.Dir"),
        (body() + moved("IMPVEL", "Z", 92, skew=3), "/IMPVEL/7.skew_ID"),
        (body() + moved("IMPVEL", "Z", 92, stop=5.0), "/IMPVEL/7.Tstop"),
        (body(1.0) + "/INIVEL/TRA/4\nmain\n" + reals(0.0, 0.0, 4.0).rstrip().ljust(60) + whole(92, 0),
         "/INIVEL/TRA/4.grnd_ID"),
        ("/BCS/7\nskew\n" + line(("   100 000", 10), (4, 10), (93, 10)), "/BCS/7.skew_ID"),
    ],
)  # fmt: skip
def test_what_a_case_cannot_say_is_refused_by_name(use, more, field):
    _, report = use(more)
    assert [row.field for row in report.of("refused")] == [field]


def test_an_inertia_that_no_body_has_is_refused_where_it_stands(use):
    with pytest.raises(InputError) as refused:
        use(body(mass=1.0, centre=4, moments=(1e12, 1e12, 1e12)))
    assert refused.value.code == "E-DCK-018"
    assert "small_0000.rad:" in refused.value.where
