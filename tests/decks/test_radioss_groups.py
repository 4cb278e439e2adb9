"""Surfaces and groups as public starter decks have them: by elements, ranges and subsets; and
smooth functions."""

from __future__ import annotations

import numpy as np
import pytest
from radioss_text import MORE, SMALL

from billow.base.errors import InputError
from billow.case.schema import Case
from billow.decks.cards import Field
from billow.decks.import_deck import Options, import_deck
from billow.decks.radioss.starter_file import StarterDeck
from billow.decks.radioss.starter_model import StarterModel, smoothed

SURFACE = "/SURF/PART/1\nbag\n         3\n"
GROUPS = (
    "/GRSHEL/SHEL/1\nquads\n         3\n/GRSHEL/GENE/2\nmore\n         4         9\n/GRSHEL/GRSHEL/3\nboth\n"
    "         1         2\n/GRSH3N/PART/1\ntriangles\n         3\n/SUBSET/7\nball\n         8\n/SUBSET/8\nskin\n"
)

OTHER = "/PART/5\nother\n         7         3         0\n/SH3N/5\n        20         1         2         3\n"


@pytest.fixture
def use(tmp_path):
    """Import the small deck with other surfaces: the case."""

    def make(surface: str, old: str = "", new: str = "") -> Case:
        assert old in SMALL
        text = SMALL.replace(SURFACE, surface).replace(old, new) if old else SMALL.replace(SURFACE, surface)
        folder = tmp_path / f"deck_{len(list(tmp_path.iterdir()))}"
        folder.mkdir()
        (folder / "small_0000.rad").write_text(text)
        (folder / "more.inc").write_text(MORE)
        import_deck(folder / "small_0000.rad", folder / "case", Options())
        return Case.load(folder / "case" / "case.toml")

    return make


@pytest.mark.parametrize(
    "surface",
    [
        "/SURF/GRSHEL/2\nquads\n         3\n/SURF/GRSH3N/3\ntriangles\n         1\n"
        "/SURF/SURF/1\nbag\n         2         3\n",
        "/SURF/SUBSET/1\nbag\n         7\n",
        "/SURF/MAT/1\nbag\n         3\n",
        "/SURF/SEG/1\nbag\n" + "".join(f"{k:10d}" + "".join(f"{n:10d}" for n in c) + "\n" for k, c in enumerate(
            ((1, 3, 2, 0), (1, 2, 4, 0), (1, 4, 3, 3), (2, 3, 4, 4)), 1)),
    ],
    ids=["groups", "subset", "material", "segments"],
)  # fmt: skip
def test_a_bag_by_elements_or_subsets_is_the_bag_by_its_part(use, surface):
    expected = use(SURFACE)
    case = use(surface + GROUPS, "         3         3         0", "         3         3         8")
    assert [part.name for part in case.bag.parts] == [part.name for part in expected.bag.parts] == ["bag"]
    named = {"bag": {**case.to_dict()["bag"], "start": "", "reference": ""}}
    assert {**case.to_dict(), **named} == {
        **expected.to_dict(), "bag": {**expected.to_dict()["bag"], "start": "", "reference": ""}
    }  # fmt: skip


def test_elements_that_are_only_half_of_a_part_stay_segments(use):
    with pytest.raises(InputError) as error:
        use("/SURF/GRSHEL/1\nhalf\n         3\n" + GROUPS)
    assert error.value.code == "E-DCK-011"  # open: two of its four triangles


@pytest.fixture
def model(tmp_path):
    def make(more: str) -> StarterModel:
        (tmp_path / "small_0000.rad").write_text(SMALL.replace("/END\n", GROUPS + more + "/END\n", 1))
        (tmp_path / "more.inc").write_text(MORE)
        return StarterModel(StarterDeck(tmp_path / "small_0000.rad"))

    return make


@pytest.mark.parametrize(
    ("kind", "ids", "nodes"),
    [
        ("GENE", "         2         3", [2, 3]),
        ("GEN_INCR", "         1         4         2", [1, 3]),
        ("GRSHEL", "         1", [1, 3, 4]),
        ("GRSHEL", "         3", [1, 2, 3, 4]),
        ("GRSH3N", "         1", [1, 2, 3, 4]),
        ("PART", "         3", [1, 2, 3, 4]),
        ("PROP", "         3", [1, 2, 3, 4]),
        ("PROP", "         7", [1, 2, 3]),
        ("MAT", "         7", []),
        ("SURF", "         1", [1, 2, 3, 4]),
        ("NODE", "         4         1", [4, 1]),
    ],
)
def test_groups_of_nodes_of_all_kinds(model, kind, ids, nodes):
    who = Field("RBODY", "grnd_ID", "9", "small_0000.rad:1")
    assert model(f"{OTHER}/GRNOD/{kind}/9\nnodes\n{ids}\n").group(9, who).tolist() == nodes


@pytest.mark.parametrize("kind", ["/GRNOD/BOX", "/SURF/BOX", "/GRSHEL/BOX"])
def test_what_no_list_says_is_refused_by_number(model, kind):
    found = model(f"{kind}/9\nin a box\n         1\n/GRNOD/GRSHEL/10\nnodes\n         9\n")
    who = Field("RBODY", "grnd_ID", "9", "small_0000.rad:1")
    with pytest.raises(InputError) as error:
        found.surface(9, who) if "SURF" in kind else found.group(10 if "SHEL" in kind else 9, who)
    assert (error.value.code, error.value.where) == ("E-DCK-006", "small_0000.rad:1")


def test_a_smooth_function_has_no_slope_at_its_points():
    """y = h(x), h = x^3 (10 - 15 x + 6 x^2): h(1/4) = 0.103515625; straight lines between 16 points are 0.3 % off."""
    points = smoothed(np.array([[0.0, 0.0], [1.0, 2.0], [3.0, 2.0]]))
    x = np.linspace(0.0, 1.0, 1001)
    exact = 2.0 * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    assert np.interp(0.25, *points.T) == pytest.approx(2.0 * 0.103515625, rel=1e-12)
    assert np.abs(np.interp(x, *points.T) - exact).max() == pytest.approx(2.0 * 5.7735 / 8.0 / 256.0, rel=0.05)
    assert np.interp(2.5, *points.T) == 2.0
