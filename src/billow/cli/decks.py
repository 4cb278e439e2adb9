"""`billow import-deck`, `export-deck` and `export-d3plot`: decks of LS-DYNA in and out, and frames out."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from billow.cli.options import CaseFile, Settings, parse_settings, usable


class Measure(StrEnum):
    """What curves of fabric measure."""

    true = "true"
    engineering = "engineering"
    green = "green"


def known_units(command: str, units: str | None) -> str | None:
    """The name of a system of units, if one is given. InputError E-CLI-007 for others."""
    from billow.decks.units import SYSTEMS

    with usable(command, "units", str(units)):
        if units is not None and units not in SYSTEMS:
            raise ValueError(f"it is none of {', '.join(SYSTEMS)}")
    return units


def import_deck(
    deck: Annotated[Path, typer.Argument(help="Deck of LS-DYNA or Radioss, or a mesh (.stl, .obj, .ply, .vtp, .vtu).")],
    out: Annotated[Path, typer.Option(help="Folder for the case; must not exist yet.")],
    units: Annotated[
        str, typer.Option(metavar="SYSTEM", help="auto, kg-mm-ms, t-mm-s, kg-m-s, g-mm-ms or lbf-in-s.")
    ] = "auto",
    airbag: Annotated[int | None, typer.Option(min=1, help="Which *AIRBAG of several, from 1.")] = None,
    part: Annotated[
        list[str] | None,
        typer.Option(metavar="N=KIND", help="What a part is: fabric, mouth, vent, obstacle, plate or ignore."),
    ] = None,
    close: Annotated[
        list[str] | None,
        typer.Option(metavar="\\[N=]KIND", help="What closes an open edge, or all of them: mouth or vent."),
    ] = None,
    merge: Annotated[
        float | None, typer.Option(min=0.0, help="Nodes on open edges that lie this close \\[m] are merged.")
    ] = None,
    base: Annotated[Path | None, typer.Option(help="Case file that gives what the deck does not say.")] = None,
    fabric_curves: Annotated[Measure, typer.Option(help="What curves of FORM 4 and 14 measure.")] = Measure.true,
    allow_outside: Annotated[
        bool, typer.Option("--allow-outside", help="Include files that lie outside the deck's folder.")
    ] = False,
) -> None:
    """Make a case from a deck of LS-DYNA or Radioss, and say what became of every field.

    Writes case.toml, start.vtkhdf, reference.vtkhdf if the deck has one, curves, and the report as import.md and
    import.json. Exit code 1 if a field means something that a case cannot say.
    """
    from billow.decks.block import shown
    from billow.decks.import_deck import Options
    from billow.decks.import_deck import import_deck as make_case
    from billow.decks.report import APPROXIMATED, IGNORED, MAPPED, REFUSED

    command = "import-deck"
    if units != "auto":
        known_units(command, units)
    options = Options(
        units=units, airbag=airbag, parts=_numbered(command, "part", part, ("fabric", "mouth", "vent", "obstacle",
        "plate", "ignore")), close=_numbered(command, "close", close, ("mouth", "vent")), merge=merge, base=base,
        measure=fabric_curves.value, allow_outside=allow_outside,
    )  # fmt: skip
    report = make_case(deck, out, options)
    for remark in report.remarks:
        print(remark)
    if report.keywords:
        print("not read: " + ", ".join(map(shown, report.keywords)))
    for row in report.of(REFUSED):
        print(f"refused: {row.field} = {row.deck} ({row.place}): {row.note}")
    counts = ", ".join(f"{len(report.of(s))} {s}" for s in (MAPPED, APPROXIMATED, IGNORED, REFUSED))
    print(f"{out}: fields {counts}; see {out / 'import.md'}\nnext: billow check {out / 'case.toml'}")
    raise typer.Exit(1 if report.of(REFUSED) else 0)


def export_deck(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option(help="Deck to write; must not exist yet.")],
    units: Annotated[
        str, typer.Option(metavar="SYSTEM", help="kg-mm-ms, t-mm-s, kg-m-s, g-mm-ms or lbf-in-s.")
    ] = "kg-mm-ms",
    settings: Settings = None,
) -> None:
    """Write a case as a deck of LS-DYNA, in LONG format, and say what a deck cannot hold of it."""
    from billow.case.schema import Case
    from billow.decks.export_deck import export_deck as write_deck

    known_units("export-deck", units)
    for note in write_deck(Case.load(case_file).vary(parse_settings(settings)), out, units):
        print(note)
    print(f"{out}: written, units {units}")


def export_d3plot(
    run: Annotated[Path, typer.Argument(help="Folder of a run.")],
    out: Annotated[Path, typer.Option(help="File to write, usually called d3plot; must not exist yet.")],
    units: Annotated[
        str, typer.Option(metavar="SYSTEM", help="kg-mm-ms, t-mm-s, kg-m-s, g-mm-ms or lbf-in-s.")
    ] = "kg-mm-ms",
) -> None:
    """Write the frames of a run as a d3plot of LS-DYNA, with the extra dyna."""
    from billow.results.result import Result
    from billow.study.d3plot_out import export_d3plot as write_d3plot

    known_units("export-d3plot", units)
    parts = write_d3plot(Result.open(run), out, units)
    print(f"{out}: written, units {units}; parts " + ", ".join(f"{number} {name}" for number, name in parts.items()))


def _numbered(command: str, option: str, texts: list[str] | None, kinds: tuple[str, ...]) -> dict[int, str]:
    """{number: kind} from "number=kind" texts; 0 for a kind without a number."""
    found = {}
    for text in texts or []:
        number, equals, kind = text.partition("=")
        if not equals and option == "close":
            number, kind = "0", text
        with usable(command, option, text):
            if kind not in kinds:
                raise ValueError(f"{kind[:20]!r} is none of {', '.join(kinds)}")
            if not (number.isascii() and number.isdigit()):
                raise ValueError("a number and = are expected before the kind")
            found[int(number)] = kind
    return found
