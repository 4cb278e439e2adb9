"""`billow compare`: two runs, a run and a surrogate, or a run and a test."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from billow.cli.options import DesignValues, parse_settings
from billow.cli.page_files import check_page_name, write_page
from billow.cli.picture_files import picture_at, picture_kind
from billow.cli.plot import ChannelClass, Quantities
from billow.cli.render import Units, check_view


def compare(
    first: Annotated[
        Path, typer.Argument(metavar="A", help="Run, prediction (.vtkhdf), table of curves (.csv), or surrogate.")
    ],
    second: Annotated[
        Path, typer.Argument(metavar="B", help="The same; the reference, which is the test if there is one.")
    ],
    out: Annotated[Path | None, typer.Option(help="Figure (.png, .svg, .pdf).")] = None,
    html: Annotated[Path | None, typer.Option(help="Page with both bags, sections and curves over time.")] = None,
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
    """Compare two: peaks and ends of curves with their ISO/TS 18571 rating, injury metrics, shapes and sections.

    A surrogate, or a coupled file, answers for the design of the other side, a run of a study, or for that of --set.
    """
    from billow.apps.compare.differences import compare_curves, compare_shapes, require_common
    from billow.apps.compare.report import describe, record, table
    from billow.apps.compare.sides import open_sides
    from billow.pictures.curves import require_quantities, usual_quantities
    from billow.pictures.section import parse_plane
    from billow.pictures.shown_units import check_units
    from billow.pictures.source import labels

    kind = None if out is None else picture_kind(out, "compare")
    if html is not None:
        check_page_name(html)
    check_view(view, "compare")
    check_units(unit or ())
    plane = parse_plane(section)
    paths = first, second
    one, other = open_sides(paths, tuple(labels(paths)), parse_settings(settings) or None)
    with_curves = [side.curves for side in (one, other) if side.curves is not None]
    names = list(dict.fromkeys(quantity or usual_quantities(with_curves)))
    require_quantities(quantity or (), with_curves, f"{first}, {second}")
    curves = compare_curves(one, other, names, cfc) if len(with_curves) == 2 else []
    shapes = compare_shapes(one, other)
    require_common(one, other, curves)
    if out is not None:
        from billow.apps.compare.figure import comparison_figure
        from billow.pictures.sheet import printed
        from billow.pictures.shot import saved
        from billow.results.atomic import write_atomically

        with picture_at(out), printed():
            write_atomically(out, saved(comparison_figure(one, other, curves, plane, view, unit or ()), kind))
    if html is not None:
        _write_page(html, one, other, table(one, other, curves, unit or ()), quiet=as_json)
    if as_json:
        print(json.dumps(record(one, other, curves, shapes), indent=1, allow_nan=False))
        return
    print(describe(one, other, curves, shapes, unit or ()))
    missing = [name for name in quantity or () if name not in {found.name for found in curves}]
    if missing:
        print(f"only one of the two has {', '.join(missing)}")
    if out is not None:
        print(f"{out}: written")


def _write_page(out: Path, one, other, table: dict, quiet: bool) -> None:
    from billow.pages.viewer import Shown, viewer_page

    sides = [Shown(side.label, side.fabric, side.source.result, side.curves, side.remark) for side in (one, other)]
    write_page(out, viewer_page(sides, f"{one.label} against {other.label}", table=table), quiet)
