"""`billow view` and `billow report`: a run as a page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from billow.cli.page_files import check_page_name, write_page


def view(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Result folder of a run, or a predicted .vtkhdf file.")],
    out: Annotated[Path, typer.Option(help="Page.")] = Path("view.html"),
    field: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Field to colour the bag by, as in `billow render`. May be repeated."),
    ] = None,
) -> None:
    """Write a page with the moving bag, its sections and its curves, for a browser, without a network.

    The page is one file that can be sent on.
    """
    from billow.cli.render import no_frames
    from billow.pages.viewer import Shown, viewer_page
    from billow.pictures.source import open_source

    check_page_name(out)
    source = open_source(run, "view")
    if source.fabric is None:
        raise no_frames(run, "view")
    title = (source.result.record.get("title") if source.result is not None else None) or source.label
    shown = Shown(source.label, source.fabric, source.result, source.histories)
    write_page(out, viewer_page([shown], title, field or ()))


def report(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Result folder of a run.")],
    out: Annotated[Path, typer.Option(help="Page.")] = Path("report.html"),
) -> None:
    """Write a run's own page: whether it can be used, peaks and injury metrics, the moving bag, curves, books, log."""
    from billow.pages.run_report import run_report
    from billow.results.result import Result

    check_page_name(out)
    write_page(out, run_report(Result.open(run)))
