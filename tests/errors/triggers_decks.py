"""What is wrong with decks."""

from __future__ import annotations

import sys
import types
from collections.abc import Callable
from pathlib import Path

from here import Here

from billow.case.schema import Case
from billow.decks.export_deck import export_deck
from billow.decks.import_deck import Options, import_deck
from billow.study.import_runs import import_runs

# A bag of four triangles, in kg-mm-ms.
NODES = "*NODE\n1,0,0,0\n2,300,0,0\n3,0,300,0\n4,0,0,300\n"
SHELLS = "*ELEMENT_SHELL\n1,3,1,3,2,2\n2,3,1,2,4,4\n3,3,1,4,3,3\n4,3,2,3,4,4\n"
PARTS = "*PART\nbag\n3,3,3\n*SECTION_SHELL\n3,9\n0.3,0.3,0.3,0.3\n*SET_PART\n1\n3\n"
FABRIC = "*MAT_FABRIC\n3,8e-7,0.4,0.35,,0.2\n0.01,,,1\n2\n,,,1\n\n"
CURVES = "*DEFINE_CURVE\n1\n0,0\n10,1e-3\n40,0\n*DEFINE_CURVE\n2\n0,600\n100,600\n"
AIRBAG = "*AIRBAG_HYBRID\n1,1\n293,1.01e-4,,8.314,1\n0,,0\n0,,1\n1,2,,0.028,1,29\n\n"
DECK = "*KEYWORD\n" + NODES + SHELLS + PARTS + FABRIC + CURVES + AIRBAG


def deck(text: str, options: Callable[[Here], Options] = lambda here: Options()) -> Callable[[Here], object]:
    """Import a deck that is wrong."""

    def trigger(here: Here):
        path: Path = here.write("bag.k", text)
        return import_deck(path, path.parent / "case", options(here))

    return trigger


def changed(old: str, new: str, **options) -> Callable[[Here], object]:
    assert old in DECK
    return deck(DECK.replace(old, new), lambda here: Options(**options))


def exported(here: Here):
    several = Case.from_dict({
        "bag": {"shape": "rectangular", "chambers": 2, "element_size": 0.05}, "gas": {"model": "corpuscular"},
        "inflator": {"chamber": "chamber_2", "jets": {"count": 0}},
    })  # fmt: skip
    export_deck(several, here.write("case.toml", "").parent / "bag.k")


def starter(text: str) -> Callable[[Here], object]:
    """Import a starter deck of Radioss that is wrong."""

    def trigger(here: Here):
        path: Path = here.write("bag_0000.rad", "#RADIOSS STARTER\n" + text)
        return import_deck(path, path.parent / "case", Options())

    return trigger


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-DCK-001": deck("a text"),
    "E-DCK-002": changed("*NODE\n", "*INCLUDE\nnodes.k\n*NODE\n"),
    "E-DCK-003": changed("1,0,0,0\n", "1,&x,0,0\n"),
    "E-DCK-004": changed("2,300,0,0\n", "2,3oo,0,0\n"),
    "E-DCK-005": changed(AIRBAG, "*AIRBAG_HYBRID\n1,1\n"),
    "E-DCK-006": changed("*SET_PART\n1\n", "*SET_PART\n2\n"),
    "E-DCK-007": changed("4,0,0,300\n", "4,0,0,300\n4,0,0,301\n"),
    "E-DCK-008": lambda here: (
        here.write("airbag.k", AIRBAG),
        deck(DECK.replace(AIRBAG, "*INCLUDE_TRANSFORM\nairbag.k\n1000,0,0,0,0,0,0\n"))(here),
    ),
    "E-DCK-009": changed("8.314", "83.14"),
    "E-DCK-010": changed("*MAT_FABRIC\n3,8e-7,0.4,0.35,,0.2\n0.01,,,1\n2\n,,,1\n\n", "*MAT_NULL\n3,8e-7\n"),
    "E-DCK-011": changed("4,3,2,3,4,4\n", ""),
    "E-DCK-012": changed("4,3,2,3,4,4\n", "4,3,2,3,4,4\n5,3,2,1,4,4\n"),
    "E-DCK-013": changed("10,1e-3\n40,0\n", "10,1e-3\n5,0\n"),
    "E-DCK-015": changed(AIRBAG, AIRBAG + AIRBAG),
    "E-DCK-016": changed("*AIRBAG_HYBRID", "*AIRBAG_LINEAR_FLUID"),
    "E-DCK-017": changed("*SECTION_SHELL\n3,9\n0.3,0.3,0.3,0.3\n", ""),
    "E-DCK-018": changed("0,600\n100,600\n", "0,6000\n100,6000\n"),
    "E-DCK-020": exported,
}


def of_dyna(installed: bool) -> Callable[[Here], object]:
    """Import runs whose results are a d3plot, without saying its units; the library is there or not."""

    def trigger(here: Here):
        here.patch.setitem(sys.modules, "dynars", types.ModuleType("dynars") if installed else None)
        folder = here.write("runs.csv", "run,flow [kg/s]\n0000,1\n0001,2\n0002,3\n").parent
        (folder / "0000").mkdir()
        (folder / "0000" / "d3plot").write_bytes(b"d3plot")
        return import_runs(folder, folder / "study")

    return trigger


TRIGGERS |= {"E-STU-033": of_dyna(installed=False), "E-STU-034": of_dyna(installed=True)}
TRIGGERS |= {
    "E-DCK-160": starter("/NODE\n"),
    "E-DCK-161": starter("/BEGIN\nbag\n      2022\n" + "".join(f"{unit:>20}" for unit in ("lb", "mm", "ms")) + "\n"),
}
