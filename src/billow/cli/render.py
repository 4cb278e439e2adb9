"""`billow render`: pictures and films of a deployment."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from billow.base.units import in_unit
from billow.cli.options import usable
from billow.cli.picture_files import FILMS, STILLS, picture_at, picture_kind

SMALLEST, LARGEST = 160, 8000
"""Pixels a side."""
Units = Annotated[
    list[str] | None,
    typer.Option("--unit", metavar="UNIT", help="Show values in this unit where it fits, such as bar."),
]


def render(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Result folder of a run, or a predicted .vtkhdf file.")],
    out: Annotated[
        Path, typer.Option(help="Picture (.png, .svg, .pdf) or film (.gif, .mp4 where ffmpeg is installed).")
    ] = Path("render.png"),
    field: Annotated[
        str | None,
        typer.Option(
            help="Colour the bag by displacement, speed, pressure, stress, stretch, ..., a field of the frames."
        ),
    ] = None,
    view: Annotated[str, typer.Option(metavar="iso|front|side|top|below", help="From where.")] = "iso",
    section: Annotated[
        str | None, typer.Option(metavar="AXIS=PLACE", help="Cut along a plane, such as y=0 or 'z=120 mm'.")
    ] = None,
    times: Annotated[
        str | None,
        typer.Option(
            metavar="T,T,...",
            help="Times such as '5 ms,20 ms'; several make a filmstrip. Default: the last frame; a film "
            "shows all frames, or those between two times.",
        ),
    ] = None,
    limits: Annotated[
        str | None, typer.Option("--range", metavar="LOW,HIGH", help="Values at the ends of the colour bar.")
    ] = None,
    unit: Units = None,
    size: Annotated[str | None, typer.Option(metavar="WIDTHxHEIGHT", help="Pixels.")] = None,
    speed: Annotated[float, typer.Option(min=0.5, max=60.0, help="Frames a second of a film.")] = 15.0,
    title: Annotated[str | None, typer.Option(help="Title (default: that of the case).")] = None,
) -> None:
    """Draw a deployment: one picture, a filmstrip or a film, without a display.

    The bag is shaded, obstacles and straps are drawn; the camera and the colours stay the same through all times.
    """
    from billow.pictures.deployment import Deployment, colouring_of
    from billow.pictures.fields import read_field
    from billow.pictures.film import gif, mp4
    from billow.pictures.section import parse_plane
    from billow.pictures.shot import Shot, drawn
    from billow.pictures.shown_units import check_units
    from billow.pictures.source import open_source
    from billow.results.atomic import write_atomically

    kind = picture_kind(out, "render", (*STILLS, *FILMS))
    check_view(view, "render")
    check_units(unit or ())
    plane = None if section is None else parse_plane(section)
    pixels = None if size is None else parse_size(size, "render")
    chosen = None if times is None else parse_times(times, "render")
    source = open_source(run, "render")
    if source.fabric is None:
        raise no_frames(run, "render")
    colouring = None
    if field is not None:
        read = read_field(source.fabric, field)
        colouring = colouring_of(read, None if limits is None else parse_range(limits, read.unit, "render"))
    deployment = Deployment(source.fabric, source.result, colouring)
    recorded = source.fabric.times.tolist()
    if kind in FILMS:
        span = chosen or [recorded[0], recorded[-1]]
        shown = [time for time in recorded if min(span) <= time <= max(span)] or [recorded[-1]]
    else:
        shown = chosen or [recorded[-1]]
    name = title if title is not None else source.result.record.get("title", "") if source.result else source.label
    shot = Shot.at([deployment], shown, view=view, plane=plane, size=pixels, title=name, units=unit or ())
    with picture_at(out):
        if kind in FILMS:
            data = gif(shot.film(), speed) if kind == "gif" else mp4(shot.film(), speed, out)
        else:
            data = drawn(shot, kind)
        write_atomically(out, data)
    what = f"{len(shot.times)} frames" if len(shot.times) > 1 else f"{1e3 * shot.times[0]:.1f} ms"
    print(f"{out}: {what}")


def parse_times(text: str, command: str) -> list[float]:
    """Times [s] of "5 ms,20 ms". InputError E-CLI-007."""
    with usable(command, "times", text, "write for example --times '0,5 ms,20 ms'"):
        times = [in_unit(part, "s") for part in text.split(",") if part.strip()]
        if not times or len(times) > 100:
            raise ValueError("expected 1 to 100 times")
        return times


def parse_size(text: str, command: str) -> tuple[int, int]:
    """Width and height of "1280x960". InputError E-CLI-007."""
    with usable(command, "size", text, "write for example --size 1280x960"):
        wide, _, tall = text.lower().partition("x")
        if not (wide.isascii() and wide.isdigit() and tall.isascii() and tall.isdigit()):
            raise ValueError("expected width and height in pixels with an x between them")
        size = int(wide[:9]), int(tall[:9])
        if not all(SMALLEST <= side <= LARGEST for side in size):
            raise ValueError(f"each side has {SMALLEST} to {LARGEST} pixels")
        return size


def parse_range(text: str, unit: str, command: str) -> tuple[float, float]:
    """Lowest and highest value of "0,40 kPa" in `unit` of SI. InputError E-CLI-007."""
    from billow.base.units import CONVERSIONS

    with usable(command, "range", text, f"write for example --range 0,100 (in {unit})"):
        parts = text.split(",")
        if len(parts) != 2:
            raise ValueError("expected two values with a comma between them")
        low, high = (in_unit(part, unit) if unit in CONVERSIONS else float(part) for part in parts)
        if not low < high:
            raise ValueError("the first value must be the smaller one")
        return low, high


def check_view(view: str, command: str) -> None:
    """InputError E-CLI-007 unless there is such a view."""
    from billow.pictures.camera import VIEWS

    with usable(command, "view", view, f"choose one of {', '.join(VIEWS)}"):
        if view not in VIEWS:
            raise ValueError("there is no such view")


def no_frames(path: Path, command: str):
    """InputError E-PIC-006: a table of curves has no frames."""
    from billow.pictures.source import NOTHING_TO_DRAW

    return NOTHING_TO_DRAW(path=path, command=command, why="it holds curves, and no frames of a bag")
