"""`billow dataset`: what a study is for others."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from billow.cli.options import StudyFolder

app = typer.Typer(name="dataset", no_args_is_help=True, help="A study as a data set for others.")


@app.callback()
def _one_group() -> None:
    """With one command Typer would leave its name out."""


@app.command()
def publish(
    folder: StudyFolder,
    out: Annotated[Path, typer.Option(help="Folder of the data set; must not exist yet.")],
    precision: Annotated[float, typer.Option(help="How far a coordinate may be from that of the run \\[mm].")] = 0.05,
    licence: Annotated[str, typer.Option(help="SPDX identifier of the licence.")] = "CC-BY-4.0",
) -> None:
    """Write the runs of a study as a data set that says what it is and needs no Billow to be read.

    Frames as Zarr in the layout of PhysicsNeMo's crash example, a table of parameters and responses, the split, a card
    with units, origin, verdicts and licence, and checksums. Runs that failed or are in doubt are left out and named.
    """
    from billow.design.publish import publish as write

    made = write(folder, out, 1e-3 * precision, licence)
    files = [path for path in made.rglob("*") if path.is_file()]
    megabytes = 1e-6 * sum(path.stat().st_size for path in files)
    print(f"{made}: {megabytes:.1f} MB; every coordinate within {precision:g} mm; licence {licence}; see README.md")
