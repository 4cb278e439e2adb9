"""`billow compare`: runs, surrogates and tests against one of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from billow.base.errors import InputError
from billow.cli.options import DesignValues, parse_settings
from billow.cli.page_files import check_page_name, write_page
from billow.cli.picture_files import picture_at, picture_kind
from billow.cli.plot import ChannelClass, Quantities
from billow.cli.render import Units, check_view

if TYPE_CHECKING:
    from billow.apps.compare.side import Side

NOT_SO_MANY = InputError.declare(
    "E-CMP-004",
    "{count} cannot be compared",
    where="billow compare",
    why="two to four are: each against the last",
    remedy="give runs, predictions, tables of curves or surrogates, the reference last",
)
FEWEST, MOST = 2, 4


def compare(
    sides: Annotated[
        list[Path],
        typer.Argument(
            metavar="A [B ...] REFERENCE",
            help="Two to four runs, predictions (.vtkhdf), tables of curves (.csv) or surrogates; the last is the "
            "reference, which is the test if there is one.",
        ),
    ],
    out: Annotated[Path | None, typer.Option(help="Figure (.png, .svg, .pdf).")] = None,
    html: Annotated[Path | None, typer.Option(help="Page with all bags, sections and curves over time.")] = None,
    quantity: Quantities = None,
    cfc: ChannelClass = None,
    section: Annotated[str, typer.Option(metavar="AXIS=PLACE", help="Plane of the sections.")] = "y=0",
    view: Annotated[
        str, typer.Option(metavar="iso|front|side|top|below", help="From where the bags are seen.")
    ] = "iso",
    unit: Units = None,
    settings: DesignValues = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, in SI.")] = False,
) -> None:
    """Compare with a reference: peaks and ends of curves with their ISO/TS 18571 rating, injury metrics, shapes and
    sections.

    A surrogate, or a coupled file, answers for the design of the last side that is none, a run of a study, or for that
    of --set.
    """
    from billow.apps.compare.differences import compare_sides
    from billow.apps.compare.report import describe, record, table
    from billow.apps.compare.sides import open_sides
    from billow.pictures.curves import require_quantities, usual_quantities
    from billow.pictures.section import parse_plane
    from billow.pictures.shown_units import check_units
    from billow.pictures.source import labels

    if not FEWEST <= len(sides) <= MOST:
        raise NOT_SO_MANY(count=len(sides))
    kind = None if out is None else picture_kind(out, "compare")
    if html is not None:
        check_page_name(html)
    check_view(view, "compare")
    check_units(unit or ())
    plane = parse_plane(section)
    *others, reference = opened = open_sides(sides, labels(sides), parse_settings(settings) or None)
    with_curves = [side.curves for side in opened if side.curves is not None]
    names = list(dict.fromkeys(quantity or usual_quantities(with_curves)))
    require_quantities(quantity or (), with_curves, ", ".join(map(str, sides)))
    comparisons = [compare_sides(side, reference, names, cfc) for side in others]
    if out is not None:
        from billow.apps.compare.figure import comparison_figure
        from billow.pictures.sheet import printed
        from billow.pictures.shot import saved
        from billow.results.atomic import write_atomically

        with picture_at(out), printed():
            write_atomically(out, saved(comparison_figure(comparisons, plane, view, unit or ()), kind))
    if html is not None:
        _write_page(html, opened, table(comparisons, unit or ()), quiet=as_json)
    if as_json:
        found = [record(comparison) for comparison in comparisons]
        print(json.dumps(found[0] if len(found) == 1 else found, indent=1, allow_nan=False))
        return
    told = [describe(one, unit or (), "ABC"[k] + "ABCD"[len(others)]) for k, one in enumerate(comparisons)]
    print("\n\n".join(told))
    for comparison in comparisons:
        missing = [name for name in quantity or () if name not in {found.name for found in comparison.curves}]
        if missing:
            print(f"only one of {comparison.side.label} and {reference.label} has {', '.join(missing)}")
    if out is not None:
        print(f"{out}: written")


def _write_page(out: Path, sides: list[Side], table: dict, quiet: bool) -> None:
    from billow.pages.viewer import Shown, viewer_page

    shown = [Shown(side.label, side.fabric, side.source.result, side.curves, side.remark) for side in sides]
    title = f"{', '.join(side.label for side in sides[:-1])} against {sides[-1].label}"
    write_page(out, viewer_page(shown, title, table=table), quiet)
