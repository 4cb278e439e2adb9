"""`billow suggest`: the next runs a study should make."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def suggest(
    folder: Annotated[Path, typer.Argument(help="Study folder.")],
    out: Annotated[Path, typer.Option(help="Table of designs (CSV), for added_designs in study.toml.")],
    count: Annotated[int, typer.Option(min=1, help="How many designs.")] = 8,
    surrogate_file: Annotated[
        Path | None, typer.Option("--surrogate", help="Surrogate file (default: FOLDER/surrogate.safetensors).")
    ] = None,
) -> None:
    """Suggest the next training runs: designs where the surrogate is most uncertain and no run is near.

    OUT holds the designs added before, if any, and the new ones. Write added_designs = "OUT" into the study file and
    give the command of the study again: it makes the new runs.
    """
    from billow.results.atomic import write_atomically
    from billow.rom.learn.suggest import suggest as next_designs
    from billow.rom.surrogate.surrogate import Surrogate
    from billow.study.added_designs import added_designs_text, read_added_designs
    from billow.study.study import ADDED_FILE, Study

    study = Study.open(folder)
    surrogate = Surrogate.load(surrogate_file or folder / "surrogate.safetensors")
    added = []
    if study.definition.added_designs is not None:
        added = read_added_designs(folder / ADDED_FILE, study.definition.axes)
    rows = next_designs(surrogate, count, list(study.runs.values()), seed=len(study.runs))
    write_atomically(out, added_designs_text(study.definition.axes, [*added, *rows.tolist()]))
    print(f"{out}: {len(added)} designs added before, {count} new ones")
    print(f'next: write added_designs = "{out.name}" into the study file, and give the command of the study again')
