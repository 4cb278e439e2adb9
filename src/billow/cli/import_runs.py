"""`billow import`: runs of another solver become a dataset."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def import_runs(
    folder: Annotated[Path, typer.Argument(help="Folder with runs.csv and the moving meshes.")],
    out: Annotated[Path, typer.Option(help="Study folder; must not exist yet.")],
    title: Annotated[str | None, typer.Option(help="Title of the dataset (default: the folder's name).")] = None,
    reference_length: Annotated[
        float | None,
        typer.Option(min=1e-9, help="Length \\[m] to which errors are compared (default: size of the mesh)."),
    ] = None,
    test_share: Annotated[
        float, typer.Option(min=0.0, max=0.9, help="Part of the runs set aside, unless runs.csv has a column split.")
    ] = 0.2,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the split.")] = 0,
) -> None:
    """Make a dataset of runs made elsewhere: CSV, NumPy or VTK frames and a table of parameters.

    Nodes, triangles, times and start shapes are checked against each other; nothing is written unless all agree.
    """
    from billow.study.import_runs import import_runs as make_dataset

    train, test = make_dataset(
        folder, out, title=title, reference_length=reference_length, test_share=test_share, seed=seed
    )
    print(f"{out}: {train} training and {test} unseen runs")
    print(f"next: billow train {out}")
