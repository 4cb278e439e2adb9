"""Bags that *AIRBAG_INTERACTION joins become chambers of one case."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from test_decks_of_others import CLOTH, GAS

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.gas.build_gas import build_supply
from billow.case.nodes.build_nodes import members_of
from billow.case.schema import Case
from billow.decks.export_deck import export_deck
from billow.decks.import_deck import Options, import_deck
from billow.run.simulate import simulate

BEGIN, END = GAS.index("*AIRBAG_HYBRID"), GAS.index("*CONTROL")
X, Y, Z = (a.ravel() for a in np.meshgrid([0.0, 300.0, 600.0], [0.0, 300.0], [0.0, 300.0], indexing="ij"))
NODE = {(x, y, z): k for k, (x, y, z) in enumerate(zip(X.tolist(), Y.tolist(), Z.tolist(), strict=True), 1)}


def face(axis: int, at: float, begin: float) -> list[int]:
    """Ids of a square face of a cube from `begin` to `begin` + 300 along x."""
    ends = [[0.0, 300.0] if k else [begin, begin + 300.0] for k in range(3)]
    u, v = (k for k in range(3) if k != axis)
    corners = [(ends[u][a], ends[v][b]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return [NODE[tuple(np.insert([p, q], axis, at).tolist())] for p, q in corners]


BOX = {  # two cubes, 1 and 2, and the wall 3 between them
    1: [face(0, 0.0, 0.0), *(face(axis, at, 0.0) for axis in (1, 2) for at in (0.0, 300.0))],
    2: [face(0, 600.0, 300.0), *(face(axis, at, 300.0) for axis in (1, 2) for at in (0.0, 300.0))],
    3: [face(0, 300.0, 0.0)],
}
HYBRID = "*AIRBAG_HYBRID_ID\n{0},bag\n{0},1\n293,1.01e-4,,8.314,1\n0,,0\n0,,2\n{1},2,,0.028,0,29\n\n0,0,,0.029,1,29\n\n"


def deck(interaction: str, second: str = HYBRID) -> str:
    nodes = "".join(f"{k},{x!r},{y!r},{z!r}\n" for (x, y, z), k in NODE.items())
    cells = [(part, cell) for part, faces in BOX.items() for cell in faces]
    shells = "".join(f"{k},{part},{','.join(map(str, cell))}\n" for k, (part, cell) in enumerate(cells, 1))
    parts = "".join(f"wall {n}\n{n},1,1\n" for n in BOX)
    sets = "*SET_PART_LIST\n1\n1,3\n*SET_PART_LIST\n2\n2,3\n"
    bags = HYBRID.format(1, 1) + second.format(2, 0)
    gas = GAS[:BEGIN] + bags + f"*AIRBAG_INTERACTION\n{interaction}\n" + GAS[END:]
    return f"*KEYWORD\n*NODE\n{nodes}*ELEMENT_SHELL\n{shells}*PART\n{parts}{sets}{CLOTH}{gas}*END\n"


@pytest.fixture
def use(tmp_path):
    def make(text: str, **options):
        (tmp_path / "bag.k").write_text(text)
        report = import_deck(tmp_path / "bag.k", tmp_path / "case", Options(**options))
        return Case.load(tmp_path / "case" / "case.toml"), report

    return make


def test_two_bags_with_a_wall_between_them_are_two_chambers(use):
    case, report = use(deck("1,2,2000,0.7"))
    assert not report.of("refused")
    shape = build_shape(case.bag)
    chambers = shape.surface.chambers
    assert chambers.names == ("bag_1", "bag_2")
    assert chambers.volumes(shape.surface.triangles, shape.positions) == pytest.approx([0.027, 0.027])
    wall = next(part for part in case.bag.parts if part.number == 3)
    assert (wall.behind, wall.ahead) == ("bag_1", "bag_2")
    (inflator,) = case.inflators
    assert inflator.chamber == "bag_1"
    assert set(case.gas.species) >= {"bag_1_gas_1", "bag_1_gas_2"}
    assert not any(name.startswith("bag_2") for name in case.gas.species)
    (hole,) = case.gas.orifices
    assert (set(hole.between), hole.discharge) == ({"bag_1", "bag_2"}, 0.7)
    assert hole.area == pytest.approx(2000e-6)


def test_gas_flows_from_bag_to_bag(use, tmp_path):
    case, _ = use(deck("1,2,2000,0.7"))
    short = Case.from_dict({**case.to_dict(), "run": {"end_time": 5e-3, "frames": 2}})
    found = simulate(short, tmp_path / "run").histories
    mass = [np.asarray(found[f"bag_{k}_mass [kg]"]) for k in (1, 2)]
    assert mass[1][-1] > 1.01 * mass[1][0]
    assert sum(mass)[-1] == pytest.approx(sum(mass)[0] + found["injected [kg]"][-1], rel=1e-9)


def test_a_part_gives_the_area_and_one_bag_can_still_be_chosen(use, tmp_path):
    case, report = use(deck("1,2,0,0.5,3"))
    assert case.gas.orifices[0].area == pytest.approx(0.09)
    assert {row.field for row in report.of("approximated")} >= {"AIRBAG_INTERACTION.AREA", "AIRBAG_INTERACTION.PID"}
    import_deck(tmp_path / "bag.k", tmp_path / "one", Options(airbag=2))
    assert len(Case.load(tmp_path / "one" / "case.toml").bag.parts) == 2


CURVE = "*DEFINE_CURVE\n3\n0,1\n9,1\n"


def with_opening(interaction: str, **changes) -> str:
    """The wall between the cubes is no fabric: shells that close both bags."""
    text = (
        deck(interaction).replace("wall 3\n3,1,1\n", "opening\n3,1,9\n").replace(CLOTH, CLOTH + "*MAT_NULL\n9,1e-9\n")
    )
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    return text


def test_a_part_without_fabric_is_an_opening_of_its_present_area(use, tmp_path):
    case, report = use(with_opening("1,2,0,0.7,3"))
    assert not report.of("refused")
    assert not [one for one in report.of("approximated") if one.field.startswith("AIRBAG_INTERACTION")]
    (part,) = [part for part in case.bag.parts if part.kind == "opening"]
    assert (part.name, part.behind, part.ahead) == ("opening", "bag_1", "bag_2")
    assert case.gas.opening_discharge == 0.7
    assert not case.gas.orifices
    short = case.vary({"run.end_time": 4e-3, "run.frames": 2})
    result = simulate(short, tmp_path / "run")
    moved = [name for name in result.histories if "bag_2" in name and "mass" in name]
    assert moved
    assert any(np.ptp(result.histories[name]) > 1e-6 for name in moved)


@pytest.mark.parametrize(
    ("interaction", "changes", "code"),
    [("1,2,0,0.7,3", {"set": ("*SET_PART_LIST\n2\n2,3\n", "*SET_PART_LIST\n2\n2\n")}, "E-DCK-011"),
     ("1,2,0,-3,3", {"curve": ("*SET_PART_LIST\n1\n", f"{CURVE}*SET_PART_LIST\n1\n")}, "E-DCK-010")],
)  # fmt: skip
def test_an_opening_belongs_to_both_bags_and_has_a_number(use, interaction, changes, code):
    with pytest.raises(InputError) as error:
        use(with_opening(interaction, **changes))
    assert error.value.code == code


def test_what_two_bags_cannot_share_is_refused(use):
    second = HYBRID.replace("293,", "320,").replace("0.029,1,29", "0.029,1,31")
    _, report = use(deck("1,2,2000,0.7,0,0,1", second))
    assert {row.field.split(".", 1)[1] for row in report.of("refused")} == {"IFLOW", "gas at the start", "ambient"}


def test_an_interaction_with_a_bag_that_is_not_there_is_named_by_line(use):
    with pytest.raises(InputError, match=r"E-DCK-004(.|\n)*bag\.k:\d+"):
        use(deck("1,5,2000,0.7"))


VOLUME = """/MONVOL/COMMU1/{0}
cube
{0:10d}

        12                           0.0            101000.0               293.0
{1}         0         0
         1
{2:10d}         9                 0.0                 0.5
         0         0
"""


def starter() -> str:
    text = (
        "#RADIOSS STARTER\n/BEGIN\ntwo cubes\n      2022\n"
        + "".join(f"{u:>20}" for u in ("kg", "m", "s"))
        + "\n/NODE\n"
    )
    for (x, y, z), k in NODE.items():
        text += f"{k:10d}" + "".join(f"{1e-3 * v:20.1f}" for v in (x, y, z)) + "\n"
    number = 0
    for part, faces in BOX.items():
        text += f"/SHELL/{part}\n"
        for cell in faces:
            number += 1
            text += "".join(f"{n:10d}" for n in (number, *cell)) + "\n"
        text += f"/PART/{part}\nwall {part}\n         1         1\n"
    text += "/PROP/TYPE9/1\nfabric\n\n\n" + " " * 20 + "3.E-4".rjust(20) + "\n" + "1.".rjust(20) + "\n"
    text += (
        "/MAT/LAW19/1\nnylon\n"
        + "800.".rjust(20)
        + "\n"
        + "4.E8".rjust(20)
        + "3.5E8".rjust(20)
        + "0.2".rjust(20)
        + "\n"
    )
    text += "".join("1.E7".rjust(20) for _ in range(3)) + "\n"
    text += "/MAT/GAS/CSTA/12\nair\n" + "1005.".rjust(20) + "718.".rjust(20) + "\n"
    text += (
        "/SURF/PART/1\na\n         1         3\n/SURF/PART/2\nb\n         2         3\n/SURF/PART/9\nc\n         3\n"
    )
    text += "/FUNCT/21\nflow\n" + "".join(a.rjust(20) + b.rjust(20) + "\n" for a, b in (("0.", "1."), ("0.02", "1.")))
    text += "/FUNCT/22\nheat\n" + "".join(a.rjust(20) + "600.".rjust(20) + "\n" for a in ("0.", "1."))
    text += "/PROP/INJECT1/31\ninflator\n         1         1\n        12        21        22\n"
    first = VOLUME.format(1, "         1\n        31\n", 2)
    return text + first + VOLUME.format(2, "         0\n", 1) + "/END\n"


def test_volumes_of_radioss_that_communicate(tmp_path):
    (tmp_path / "bag_0000.rad").write_text(starter())
    report = import_deck(tmp_path / "bag_0000.rad", tmp_path / "case")
    case = Case.load(tmp_path / "case" / "case.toml")
    assert not report.of("refused")
    shape = build_shape(case.bag)
    volumes = shape.surface.chambers.volumes(shape.surface.triangles, shape.positions)
    assert shape.surface.chambers.names == ("bag_1", "bag_2")
    assert volumes == pytest.approx([0.027, 0.027])
    assert [(one.chamber, one.gas) for one in case.inflators] == [("bag_1", {"bag_1_gas_12": 1.0})]
    (hole,) = case.gas.orifices  # both say it, but it is one
    assert (hole.area, set(hole.between)) == (pytest.approx(0.5 * 0.09), {"bag_1", "bag_2"})


TWO = {"shape": "rectangular", "chambers": 2, "element_size": 0.05, "seam": {"layers": 1.0}}
HOLE = {"name": "hole", "between": ["chamber_1", "chamber_2"], "area": 2e-4, "discharge": 0.8}


@pytest.mark.parametrize("model", ["uniform-pressure", "corpuscular"])
def test_chambers_go_out_and_come_back_with_the_same_bits(model, tmp_path):
    """As airbags that *AIRBAG_INTERACTION joins, or as an *AIRBAG_PARTICLE with *DEFINE_CPM_CHAMBER."""
    particles = model == "corpuscular"
    smoke = {"species": {"smoke": {"molar_mass": 0.028, "a": 29.0}}, "initial": {"gas": {"smoke": 1.0}}}
    gas = {**smoke, "model": model, "opening_discharge": 0.6, "orifices": [] if particles else [HOLE]}
    inflator = {"gas": {"smoke": 1.0}, "jets": {"count": 4 if particles else 0}}
    thrown = {"name": "thrown", "parts": ["front"], "velocity": [0.0, 0.0, 1.0]}
    made = Case.from_dict({
        "bag": TWO, "gas": gas, "inflator": inflator, "fabric": {"self_contact": True}, "nodes": [thrown]
    })  # fmt: skip
    export_deck(made, tmp_path / "bag.k")
    report = import_deck(tmp_path / "bag.k", tmp_path / "case")
    assert not report.of("refused")
    back = Case.load(tmp_path / "case" / "case.toml")
    before, after = (build_shape(case.bag) for case in (made, back))
    same_mesh(before, after)
    assert [len(group.numbers) for group in back.nodes] == [len(members_of(made.nodes[0], before))]
    assert back.gas.opening_discharge == 0.6
    holes = [] if particles else [(("bag_1", "bag_2"), 0.8, pytest.approx(2e-4))]
    assert [(o.between, o.discharge, o.area) for o in back.gas.orifices] == holes
    if particles:
        assert back.inflators[0].chamber == "chamber_1"
        return
    short = {"run.end_time": 1e-3, "run.frames": 2, "run.histories_per_frame": 5}
    runs = [simulate(case.vary(short), tmp_path / str(k)).histories for k, case in enumerate((made, back))]
    for name in ("volume [m^3]", "pressure [Pa]", "gas_mass [kg]"):
        assert np.array_equal(runs[1][name], runs[0][name])


def same_mesh(before, after) -> None:
    """Triangles, points, cut and chambers have the same bits."""
    assert np.array_equal(before.surface.triangles, after.surface.triangles)
    assert np.array_equal(before.positions + 0.0, after.positions + 0.0)
    cloth = before.surface.triangles_of_kind("fabric")
    assert np.array_equal(before.reference[cloth], after.reference[cloth])
    for side in ("behind", "ahead"):
        assert np.array_equal(getattr(before.surface.chambers, side), getattr(after.surface.chambers, side))
    kinds = [[shape.surface.part_kinds[k] for k in shape.surface.part] for shape in (before, after)]
    assert kinds[0] == kinds[1]


def named(report, status: str) -> set[str]:
    """Fields of a status, without keyword and number."""
    return {re.split(r"[.\[]", row.field)[1] for row in report.of(status)}


PAPER = Path(__file__).parents[2] / "examples" / "paper"


def test_the_window_bag_of_the_paper_comes_back_with_particles(tmp_path):
    """Section 5.3: eight tubes along a gallery, gas in the fourth. What lies inside the bag is SID2."""
    tables = tomllib.loads((PAPER / "window_tubes_particles.toml").read_text())
    made = Case.from_dict({**tables, "bag": {**tables["bag"], "element_size": 0.018, "seam": {"layers": 1.0}}})
    export_deck(made, tmp_path / "bag.k")
    report = import_deck(tmp_path / "bag.k", tmp_path / "case")
    back = Case.load(tmp_path / "case" / "case.toml")
    assert not report.of("refused")
    before, after = build_shape(made.bag), build_shape(back.bag)
    same_mesh(before, after)
    assert after.surface.chambers.names == before.surface.chambers.names
    assert (back.gas.model, back.gas.particles) == ("corpuscular", 50_000)
    assert back.gas.opening_discharge == made.gas.opening_discharge
    assert back.inflators[0].chamber == "chamber_4"
    ring, again = (build_supply(case, shape).sources[0].jets for case, shape in ((made, before), (back, after)))
    for mine, other in zip(ring.nozzles(before.positions), again.nozzles(after.positions), strict=True):
        assert mine == pytest.approx(other, abs=1e-9)
    assert {"SID2", "CHM", "CHM_ID", "SID3", "TOCHM", "ENH_V"} <= named(report, "mapped")


PARTICLE = """*AIRBAG_PARTICLE
3,1,3,0,0,0,0,0
2000,0,1,293,1.01e-4,{vents}
1,1,{orifices},0,0,0,{chm}
{vent}1.01e-4,293,0.029,29.1,0,0
1,2,0.028,29,0,0
{orifice}"""
CHAMBERS = "*DEFINE_CPM_CHAMBER\n7,2\n1,0,{0},1\n{1}2,0,0,2\n"


def cubes_of_particles(chambers: str, chm: int = 7, vent: str = "", orifice: str = "", opening: bool = False) -> str:
    """The two cubes as one airbag, its outer walls set 3 and the wall between them part 3."""
    text = with_opening("1,2,0,0.7,3") if opening else deck("1,2,0,0.7,3")
    begin, end = text.index("*AIRBAG_HYBRID"), text.index("*CONTROL")
    bag = PARTICLE.format(vents=bool(vent) * 1, orifices=bool(orifice) * 1, chm=chm, vent=vent, orifice=orifice)
    return text[:begin] + bag + "*SET_PART_LIST\n3\n1,2\n" + chambers + text[end:]


@pytest.mark.parametrize("turned", [False, True])
def test_particles_with_a_wall_between_two_chambers(turned, use):
    """The wall is fabric of both, and its normal counts as it is written."""
    text = cubes_of_particles(CHAMBERS.format(0, ""))
    if turned:
        a, b, c, d = BOX[3][0]
        assert f",3,{a},{b},{c},{d}\n" in text
        text = text.replace(f",3,{a},{b},{c},{d}\n", f",3,{a},{d},{c},{b}\n")
    case, report = use(text)
    assert not report.of("refused")
    shape = build_shape(case.bag)
    chambers = shape.surface.chambers
    assert chambers.names == ("chamber_1", "chamber_2")
    assert chambers.volumes(shape.surface.triangles, shape.positions) == pytest.approx([0.027, 0.027])
    (wall,) = (part for part in case.bag.parts if part.ahead != "ambient")
    assert (wall.number, wall.kind, wall.behind, wall.ahead) == (
        3, "fabric", *(("chamber_2", "chamber_1") if turned else ("chamber_1", "chamber_2"))
    )  # fmt: skip


@pytest.mark.parametrize(
    ("vent", "ninter", "interaction", "refused"),
    [("3,0,0.8,0,0,2\n", 0, "", set()), ("", 1, "3,0,2\n", set()), ("3,0,0.8,0,0,1\n", 0, "", {"ENH_V"}),
     ("", 1, "1,0,2\n", {"SID3"}), ("", 1, "3,0,1\n", {"SID3"})],
)  # fmt: skip
def test_an_inner_vent_is_an_opening(use, vent, ninter, interaction, refused):
    """Named by a vent card or by the chamber; a part of one chamber is none."""
    text = cubes_of_particles(CHAMBERS.format(ninter, interaction), vent=vent, opening=not refused or bool(vent))
    case, report = use(text)
    assert named(report, "refused") == refused
    kinds = [part.kind for part in case.bag.parts]
    assert kinds.count("opening") == ("SID3" not in refused)
    if vent:
        assert case.gas.opening_discharge == 0.8


def test_walls_inside_a_bag_need_chambers(use):
    with pytest.raises(InputError, match=r"E-DCK-006(.|\n)*bag\.k:\d+"):
        use(cubes_of_particles("", 4))
    _, report = use(cubes_of_particles("", 0))
    assert named(report, "refused") == {"SID2"}


def test_orifices_of_an_inflator_blow_into_one_chamber(use):
    with pytest.raises(InputError, match=r"E-DCK-004(.|\n)*CHM_ID"):
        use(cubes_of_particles(CHAMBERS.format(0, ""), orifice="1,10,0,30,1,0,0,5\n"))
    case, _ = use(cubes_of_particles(CHAMBERS.format(0, ""), orifice="1,10,0,30,1,0,0,2\n"))
    assert case.inflators[0].chamber == "chamber_2"
