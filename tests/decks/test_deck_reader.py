"""The reader of decks: 47 small decks of our own, each read to its known truth, and what it refuses, with file and
line."""

from __future__ import annotations

import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from small_decks import DECKS

from billow.base.errors import InputError
from billow.decks.cards import Cards
from billow.decks.context import Context
from billow.decks.fabric import fabric_cards
from billow.decks.fields import CARDS, known
from billow.decks.keyword_file import Deck
from billow.decks.report import Report
from billow.decks.tables import REFERENCE, SHELL, Model, table
from billow.decks.units import SYSTEMS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("decks")
    for name, text in DECKS.items():
        (place / f"{name}.k").write_bytes(text.encode())
    return place


def model(folder, name: str) -> Model:
    return Model(Deck(folder / f"{name}.k"))


def cards_of(found: Model, name: str) -> Cards:
    (block,) = [b for b in found.deck.blocks if b.name == name]
    return Context(found, SYSTEMS["kg-mm-ms"], Report()).cards(block)


def read(cards: Cards, *names: str) -> dict[str, float]:
    """Numbers of cards that follow each other."""
    found = {}
    for name in names:
        plain, _, part = name.partition("#")
        card = cards.optional(plain, CARDS[known(cards.block.name)][plain], part)
        found |= {f.name + f.part: f.number for f in card.values()}
    return found


def test_there_are_47():
    assert len(DECKS) == 47


@pytest.mark.parametrize(
    ("name", "count"),
    [("node8_16", 6), ("node_comment", 6), ("node_lower", 6), ("node_crlf", 6), ("include_main", 6)]
    + [(f"node_{form}", 3) for form in ("comma", "long", "plus", "i10", "pct")],
)
def test_nodes_in_all_forms(folder, name, count):
    found = model(folder, name).nodes
    ids = np.arange(1, count + 1)
    assert found.number.tolist() == ids.tolist()
    assert np.array_equal(found.points, ids[:, None] * [0.5, 0.25, -1.0])
    assert found.held.shape == (count, 3)
    assert not found.held.any()


def test_nodes_that_are_short_glued_or_fortran(folder):
    assert np.array_equal(model(folder, "node_short").nodes.points, [[0.5 * i, 0, 0] for i in (1, 2, 3)])
    glued = model(folder, "node_glued").nodes
    assert glued.number.tolist() == [12345671, 12345672, 12345673]
    assert np.array_equal(glued.points, [[-0.5 * i, -1.123456789e-05, -1.0 * i] for i in (1, 2, 3)])
    assert np.array_equal(model(folder, "node_fortran").nodes.points, [[1.5e3, 1.234e-5, -2.0]] * 3)


def test_shells_with_and_without_second_lines(folder):
    for name in ("shell", "include_main"):
        found = model(folder, name).shells
        assert found.corners.tolist() == [[i, i + 1, i + 2, -1 if i % 2 else i + 3] for i in range(1, 6)]
        assert found.part.tolist() == [3] * 5
    for name in ("shell_thick", "shell_beta"):
        found = model(folder, name).shells
        assert found.number.tolist() == [1, 2, 3]
        assert found.corners.tolist() == [[i, i + 1, i + 2, i + 3] for i in range(1, 4)]
        assert found.thickness.tolist() == [0.3] * 3
        assert found.beta.tolist() == [30.0, 60.0, 90.0]
    assert model(folder, "shell_two").shells.part.tolist() == [3] * 5 + [4] * 5


def test_sets(folder):
    assert model(folder, "setpart").set_of("PART", 1, "", "").tolist() == list(range(1, 11))
    assert model(folder, "setnode").set_of("NODE", 4, "", "").tolist() == list(range(1, 12))
    assert model(folder, "setgen").set_of("NODE", 4, "", "").tolist() == [*range(1, 11), *range(21, 26)]
    assert model(folder, "setseg").segments(2, "", "")[0].tolist() == [[i, i + 1, i + 2, i + 3] for i in (1, 2, 3)]


def test_parts_sections_and_parameters(folder):
    parts = model(folder, "part2").parts
    assert {n: (p.title, p.section, p.material) for n, p in parts.items()} == {
        1: ("plate", 11, 21),
        3: ("bag", 13, 23),
    }
    assert model(folder, "section").thicknesses[13][:2] == (0.3, 9)
    with_parameters = model(folder, "param")
    assert with_parameters.thicknesses[13][0] == 0.25
    assert with_parameters.deck.parameters.values == {"thick": 0.25, "nid": 12, "dbl": 0.5}


def test_ids_of_included_files_are_shifted(folder):
    assert model(folder, "include_tr").nodes.number.tolist() == list(range(1001, 1007))


@pytest.mark.parametrize(
    ("name", "points"),
    [
        ("curve", [[0, 0], [2, 6], [6, 12]]),
        ("curve_sf0", [[0, 0], [1, 2], [3, 4]]),
        ("curve_sfblank", [[0, 0], [1, 2], [3, 4]]),
    ],
)
def test_curves_and_their_scales(folder, name, points):
    assert model(folder, name).curves[9].points.tolist() == points


@pytest.mark.parametrize("name", ["hybrid", "hybrid_id"])
def test_hybrid_has_all_its_gases(folder, name):
    keyword = "AIRBAG_HYBRID" + ("_ID" if name == "hybrid_id" else "")
    gases = [card + f"#{k}" for k in (1, 2, 3) for card in ("gas", "aspirated")]
    found = read(cards_of(model(folder, name), keyword), "core", "ambient", "exits", "options", *gases)
    assert (found["SID"], found["ATMOST"], found["ATMOSP"], found["GC"]) == (1, 293.0, 1e-4, 8.314)
    assert (found["C23"], found["A23"], found["NGAS"]) == (0.7, 1e-3, 3)
    assert [found[f"LCIDM{k}"] for k in (1, 2, 3)] == [101, 103, 104]
    assert [found[f"MW{k}"] for k in (1, 2, 3)] == [0.028, 0.018, 0.044]
    assert [found[f"INITM{k}"] for k in (1, 2, 3)] == [0.45, 0.30, 0.25]
    assert [(found[f"A{k}"], found[f"B{k}"], found[f"C{k}"]) for k in (1, 2, 3)] == [
        (29.0, 1e-3, 0.0),
        (30.0, 1e-2, 0.0),
        (24.0, 4e-2, -2e-5),
    ]


def test_wang_nefske(folder):
    found = read(cards_of(model(folder, "wang"), "AIRBAG_WANG_NEFSKE"), "core", "gas", "exits", "ambient")
    assert (found["CV"], found["CP"], found["T"], found["LCT"], found["LCMT"]) == (718, 1005, 600, 11, 12)
    assert (found["C23"], found["A23"], found["PE"], found["RO"]) == (0.7, 1.2e-3, 1.013e5, 1.2)


@pytest.mark.parametrize("name", ["particle", "particle4"])
def test_particle_with_and_without_its_optional_card(folder, name):
    cards = cards_of(model(folder, name), "AIRBAG_PARTICLE")
    found = read(cards, "bag", "particles")
    assert (found["SID1"], found["NP"], found["UNIT"], found["PATM"], found["NVENT"]) == (1, 1e5, 1, 101325.0, 2)
    if cards.starts_with(b"+"):
        cards.unsign()
        assert read(cards, "tracking")["TSTOP"] == 1e10
    found = read(cards, "gases", "vent#1", "vent#2", "air", "gas#1", "gas#2", *(f"orifice#{k}" for k in (3, 4, 5)))
    assert (found["NGAS"], found["NORIF"], found["SID31"], found["SID32"]) == (2, 3, 21, 22)
    assert (found["XMAIR"], found["XM1"], found["XM2"], found["LCM2"]) == (0.0288, 0.028, 0.044, 103)
    assert [found[f"NID{k}"] for k in (3, 4, 5)] == [1001, 1002, 1003]
    assert cards.left == 0


def test_reference_geometry(folder):
    expected = [[0.1 * i, 0.2 * i, 0.0] for i in range(1, 6)]
    for name in ("refgeo", "refgeo_birth"):
        found = model(folder, name)
        (block,) = found.deck.blocks
        cards = Cards(found.deck.parameters, block)
        if "BIRTH" in block.name:
            assert cards.card("birth", "BIRTH")["BIRTH"].number == 2e-3
        from billow.decks.tables import rest

        rows = table(found.deck.parameters, rest(block, int("BIRTH" in block.name)), REFERENCE)
        assert rows["nid"].tolist() == [1, 2, 3, 4, 5]
        assert np.allclose(np.column_stack([rows[c] for c in "xyz"]), expected, rtol=1e-12, atol=0)
    found = model(folder, "shellref")
    rows = table(found.deck.parameters, found.deck.blocks[0], SHELL)
    assert rows["n4"].tolist() == [8, 12, 16, 20, 24]


@pytest.mark.parametrize("name", ["fabric0", "fabric_num", "fabric14", "fabric14m", "two_mats"])
def test_fabric_in_all_forms(folder, name):
    found = model(folder, name)
    context = Context(found, SYSTEMS["kg-mm-ms"], Report())
    form = {"fabric14": 14, "fabric14m": -14}.get(name, 0)
    f = fabric_cards(context, found.deck.blocks[0])
    assert (f["MID"].whole, f["RO"].number, f["EA"].number, f["PRBA"].number) == (5, 8e-7, 0.4, 0.2)
    assert (f["GAB"].number, f["LRATIO"].number, f["FORM"].whole, f["FVOPT"].whole) == (0.01, 0.1, form, 7)
    assert (f["FLC"].number, f["FAC"].number, f["X1"].number, f["BETA"].number) == (0.02, 1.0, 1.0, 30.0)
    if form:
        assert [f[n].whole for n in ("LCA", "LCB", "LCAB", "LCUA", "LCUB", "LCUAB")] == [31, 32, 33, 41, 42, 43]
    if form == -14:
        assert (f["LCAA"].whole, f["TCOAT"].number) == (34, -0.07)
    if name == "two_mats":
        other = fabric_cards(context, found.deck.blocks[1])
        assert (other["MID"].whole, other["FORM"].whole, other["LCUAB"].whole) == (6, 14, 43)


@pytest.mark.parametrize(
    ("name", "keyword", "cards", "expected"),
    [
        ("poroleak", "MAT_ADD_AIRBAG_POROSITY_LEAKAGE", ["leakage"], {"MID": 5, "FLC": 0.02, "FVOPT": 7, "X1": 1}),
        ("contact", "CONTACT_AIRBAG_SINGLE_SURFACE_ID", ["sides", "friction", "scales"], {"FS": 0.25, "DT": 1e20}),
        ("rigidwall", "RIGIDWALL_PLANAR_ID", ["nodes", "wall"], {"ZT": -1.0, "ZH": 5.0, "FRIC": 0.2}),
        (
            "rigidsphere",
            "RIGIDWALL_GEOMETRIC_SPHERE_ID",
            ["nodes", "wall", "sphere"],
            {"ZT": 300.0, "ZH": 301.0, "RADSPH": 82.5},
        ),
        ("inivel", "INITIAL_VELOCITY_GENERATION", ["velocity", "axis"], {"ID": 2, "STYP": 2, "VZ": -5.0}),
        ("term", "CONTROL_TERMINATION", ["termination"], {"ENDTIM": 0.05}),
    ],
)
def test_other_keywords(folder, name, keyword, cards, expected):
    found = read(cards_of(model(folder, name), keyword), *cards)
    assert {key: found[key] for key in expected} == expected


def test_every_small_deck_is_tested():
    text = Path(__file__).read_text(encoding="utf-8")
    assert [name for name in DECKS if f'"{name}"' not in text and not name.startswith("node_")] == []


@pytest.mark.parametrize(
    ("text", "code", "place", "words"),
    [
        ("*NODE\n       1     1.0x\n", "E-DCK-004", ":2", "NODE.x"),
        ("*NODE\n$\n\n     1.5             1.0\n", "E-DCK-004", ":4", "NODE.nid"),
        ("*NODE\n       1             nan\n", "E-DCK-004", ":2", "nan"),
        ("*PARAMETER\nR a       1+\n", "E-DCK-003", ":2", "no number"),
        ("*PARAMETER_EXPRESSION\nR a       __import__('os')\n", "E-DCK-003", ":2", "arithmetic"),
        ("*PARAMETER_EXPRESSION\nR a       9**9**9**9\n", "E-DCK-003", ":2", "no value"),
        ("*PARAMETER_EXPRESSION\nR a       b+1\n", "E-DCK-003", ":2", "'b'"),
        ("*INCLUDE\nnowhere.k\n", "E-DCK-002", ":2", "no such file"),
        ("*INCLUDE\n../outside.k\n", "E-DCK-002", ":2", "outside"),
        ("*INCLUDE\nself.k\n", "E-DCK-002", ":2", "deep"),
        ("*NODE\n       1\n       1             1.0\n", "E-DCK-007", ":3", "twice"),
        ("*NODE\n1\n*ELEMENT_SHELL\n1,1,1,-2,3,3\n", "E-DCK-004", ":4", "from 1 on"),
        ("*DEFINE_CURVE\n", "E-DCK-005", ":1", "curve"),
        ("just text\n", "E-DCK-001", "", "no line begins with"),
        ("*NODE\n\0\n", "E-DCK-001", "", "line 2"),
    ],
)
def test_what_is_wrong_is_named_with_file_and_line(tmp_path, text, code, place, words):
    folder = tmp_path / "deck"
    folder.mkdir()
    (tmp_path / "outside.k").write_text("*NODE\n")
    path = folder / "self.k"
    path.write_text(text)

    def use():
        found = Model(Deck(path))
        return found.nodes, found.shells, found.curves, found.parts, found.thicknesses

    with pytest.raises(InputError) as error:
        use()
    assert error.value.code == code
    assert f"self.k{place}" in error.value.where
    assert words in str(error.value)


def test_what_stands_behind_the_end_is_not_read(tmp_path):
    (tmp_path / "a.k").write_text("*NODE\n       1\n*END\n*NODE\n       2\n")
    assert Model(Deck(tmp_path / "a.k")).nodes.number.tolist() == [1]


def test_includes_are_found_along_paths_and_names_go_on_in_the_next_line(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "a long name.k").write_text("*NODE\n       7\n")
    (tmp_path / "a.k").write_text("*INCLUDE_PATH\nparts\n*INCLUDE\na long +\n name.k\n")
    assert Model(Deck(tmp_path / "a.k")).nodes.number.tolist() == [7]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2*(3+4)-1", 13.0),
        ("-2**2", -4.0),
        ("sqrt(16)/4", 1.0),
        ("1.5D+1", 15.0),
        ("MAX(1,thick)", 2.5),
        ("sin(0)+cos(0)", 1.0),
        ("&thick*2", 5.0),
    ],
)
def test_expressions(tmp_path, text, value):
    (tmp_path / "a.k").write_text(f"*PARAMETER\nR thick         2.5\n*PARAMETER_EXPRESSION\nR a       {text}\n")
    assert Deck(tmp_path / "a.k").parameters.values["a"] == value


def test_a_large_deck_takes_little_time_and_memory(tmp_path):
    """100,000 shells in 2 s, and at most ten times the file in memory; here a sixteenth of them."""
    n = 81
    index = np.arange(n * n)
    nodes = "".join(f"{i + 1:8d}{i % n:16.9E}{i // n:16.9E}{0.0:16.9E}       0       0\n" for i in index)
    first = index.reshape(n, n)[:-1, :-1].ravel() + 1
    shells = "".join(f"{k:8d}       3{a:8d}{a + 1:8d}{a + n + 1:8d}{a + n:8d}\n" for k, a in enumerate(first, 1))
    path = tmp_path / "large.k"
    path.write_text(f"*KEYWORD\n*NODE\n{nodes}*ELEMENT_SHELL\n{shells}*END\n")
    begun = time.process_time()
    found = Model(Deck(path))
    assert (len(found.nodes.number), len(found.shells.number)) == (n * n, (n - 1) ** 2)
    assert time.process_time() - begun < 0.2
    tracemalloc.start()
    found = Model(Deck(path))
    assert (len(found.nodes.number), len(found.shells.number)) == (n * n, (n - 1) ** 2)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10 * path.stat().st_size
