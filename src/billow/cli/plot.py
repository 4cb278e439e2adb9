"""`billow plot`: histories of runs and tests over one another."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from billow.cli.picture_files import picture_at, picture_kind
from billow.cli.render import Units

Quantities = Annotated[
    list[str] | None,
    typer.Option(
        "--quantity",
        "-q",
        metavar="NAME",
        help="A column of histories.csv without its unit, such as pressure; of a vector, such as impactor_velocity, "
        "its resultant, or one component. May be repeated.",
    ),
]
BETWEEN = 2.0
"""[s] between two pictures of runs that go on."""
ChannelClass = Annotated[
    int | None,
    typer.Option("--cfc", metavar="60|180|600|1000", help="Channel filter (SAE J211) for every curve drawn."),
]


def plot(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Result folders, or tables of curves (CSV).")],
    out: Annotated[Path, typer.Option(help="Picture (.png, .svg, .pdf).")] = Path("plot.png"),
    quantity: Quantities = None,
    cfc: ChannelClass = None,
    unit: Units = None,
    title: Annotated[str | None, typer.Option(help="Title (default: that of the case, if there is one run).")] = None,
    follow: Annotated[bool, typer.Option("--follow", help="Draw again every 2 s until all runs have ended.")] = False,
) -> None:
    """Draw histories, several runs over one another; of a run that goes on, what there is so far.

    Without --quantity: pressure and volume, accelerations of free obstacles, forces on the others.
    """
    from billow.pictures.source import is_running

    while True:
        goes_on = follow and any(is_running(run) for run in runs)
        _draw(runs, out, quantity, cfc, unit, title)
        if not goes_on:
            return
        time.sleep(BETWEEN)


def _draw(runs, out, quantity, cfc, unit, title) -> None:
    from billow.pictures.curve_figure import curve_figure
    from billow.pictures.curves import curve_of, require_quantities, usual_quantities
    from billow.pictures.sheet import printed
    from billow.pictures.shot import saved
    from billow.pictures.shown_units import check_units
    from billow.pictures.source import NOTHING_TO_DRAW, open_sources
    from billow.results.atomic import write_atomically

    kind = picture_kind(out, "plot")
    check_units(unit or ())
    sources = open_sources(runs, "plot")
    for source in sources:
        if source.histories is None:
            raise NOTHING_TO_DRAW(path=source.path, command="plot", why="it holds frames of a bag, and no curves")
    histories = [source.histories for source in sources]
    names = list(dict.fromkeys(quantity or usual_quantities(histories)))
    require_quantities(names, histories, ", ".join(str(source.path) for source in sources))
    panels = []
    for name in names:
        curves = {source.label: curve_of(source.histories, name, cfc) for source in sources}
        panels.append({label: curve for label, curve in curves.items() if curve is not None})
    if title is None:
        title = sources[0].result.record.get("title", "") if len(sources) == 1 and sources[0].result else ""
    with picture_at(out), printed():
        write_atomically(out, saved(curve_figure(panels, title, unit or ()), kind))
    print(f"{out}: {', '.join(names)}")
    for name, panel in zip(names, panels, strict=True):
        missing = [source.label for source in sources if source.label not in panel]
        if missing:
            print(f"{name} is not in {', '.join(missing)}")
