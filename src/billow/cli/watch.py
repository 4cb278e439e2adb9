"""How a run is watched: a table that lives while it runs, on a terminal; plain lines anywhere else."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator

HEADER = " Ekin[J]"
"""In the header of the frames in the log, which the table shows instead."""
FRAME_CELLS = 13
"""Numbers in a line of them."""


@contextlib.contextmanager
def watched(quiet: bool) -> Iterator[Callable | None]:
    """What `simulate` calls with its progress; None if nothing is to be shown."""
    if quiet:
        yield None
    elif sys.stdout.isatty():
        with _live() as show:
            yield show
    else:
        yield _lines


def _lines(progress) -> None:
    if progress.line:
        print(progress.line, flush=True)


@contextlib.contextmanager
def _live() -> Iterator[Callable]:
    """Rich is loaded here alone, 20 ms."""
    from rich.console import Console
    from rich.live import Live

    console = Console(highlight=False, markup=False)
    with Live(console=console, auto_refresh=False, transient=True) as live:

        def show(progress) -> None:
            if progress.status is not None:
                live.update(table(progress.status), refresh=True)
            elif progress.line and not is_frame(progress.line):
                console.print(progress.line, soft_wrap=True)

        yield show


def is_frame(line: str) -> bool:
    """Whether a line of the log is one of the table of frames, or its header."""
    words = line.split()
    return HEADER in line or (len(words) == FRAME_CELLS and words[0].isdigit() and words[1][0].isdigit())


def table(status: dict):
    """A status as Rich draws it: how far, the gas of each chamber, energies, and where bodies are."""
    from rich.console import Group
    from rich.progress_bar import ProgressBar
    from rich.text import Text

    values = status["values"]
    left = status["seconds_to_go"]
    to_go = "" if left is None else f"   {left:.0f} s to go"
    head = Text(
        f"{1e3 * status['time_s']:.2f} of {1e3 * status['end_s']:g} ms{to_go}\n"
        f"step {status['step']:,}, {1e6 * values.get('dt [s]', float('nan')):.2f} us, limited by {status['limited_by']}"
    )
    bar = ProgressBar(total=status["end_s"], completed=status["time_s"], width=60)
    gas, bodies = (
        _table("gas", "p [kPa]", "V [l]", "T [K]", "m [g]"),
        _table("body", "z [mm]", "v_z [m/s]", "force [N]"),
    )
    for chamber in chambers(values):
        prefix = f"{chamber}_" if chamber else ""
        mass = values.get(f"{prefix}gas_mass [kg]", values.get(f"{prefix}mass [kg]"))
        pressure, volume = values.get(f"{prefix}pressure [Pa]"), values.get(f"{prefix}volume [m^3]")
        temperature = values.get(f"{prefix}temperature [K]")
        cells = ((pressure, 1e-3), (volume, 1e3), (temperature, 1.0), (mass, 1e3))
        gas.add_row(chamber or "bag", *(_cell(value, factor) for value, factor in cells))
    for body in [name.removesuffix("_force_z [N]") for name in values if name.endswith("_force_z [N]")]:
        if f"{body}_penetration [m]" in values:
            force = sum(values[f"{body}_force_{axis} [N]"] ** 2 for axis in "xyz") ** 0.5
            place, speed = values.get(f"{body}_centre_z [m]"), values.get(f"{body}_velocity_z [m/s]")
            bodies.add_row(body, _cell(place, 1e3), _cell(speed), _cell(force))
    energies = "   ".join(
        f"{name} {values[f'{name} [J]']:.4g} J" for name in ("kinetic", "strain", "gas_work", "energy_residual")
        if f"{name} [J]" in values
    )  # fmt: skip
    return Group(head, bar, gas, bodies, Text(energies.replace("_", " ")))


def _table(first: str, *others: str):
    from rich.table import Table

    made = Table(box=None, pad_edge=False)
    made.add_column(first, min_width=12)
    for name in others:
        made.add_column(name, justify="right", min_width=9)
    return made


def _cell(value: float | None, factor: float = 1.0) -> str:
    return "-" if value is None else f"{factor * value:.4g}"


def chambers(values: dict) -> list[str]:
    """Names of the chambers of a row of histories; an empty one for the whole gas."""
    names = [name.removesuffix("_volume [m^3]") for name in values if name.endswith("_volume [m^3]")]
    return names or ([""] if "volume [m^3]" in values else [])


def say_end(result, quiet: bool) -> None:
    """Peaks and injury metrics of a run that has ended, and where it is."""
    if not quiet:
        from billow.pictures.highlights import highlights

        for name, value in highlights(result):
            print(f"{name:<34} {value}")
    print(f"{result.folder}: {result.status}")
