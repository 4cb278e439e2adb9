"""Bags that *AIRBAG_INTERACTION joins become chambers of one case."""

from __future__ import annotations

import numpy as np
import pytest
from test_decks_of_others import CLOTH, GAS

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.schema import Case
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


def test_what_two_bags_cannot_share_is_refused(use):
    second = HYBRID.replace("293,", "320,").replace("0.029,1,29", "0.029,1,31")
    _, report = use(deck("1,2,2000,0.7,0,0,1", second))
    assert {row.field.split(".", 1)[1] for row in report.of("refused")} == {"IFLOW", "gas at the start", "ambient"}


def test_an_interaction_with_a_bag_that_is_not_there_is_named_by_line(use):
    with pytest.raises(InputError, match=r"E-DCK-004(.|\n)*bag\.k:\d+"):
        use(deck("1,5,2000,0.7"))
