"""`billow explore`: a surrogate as a page with sliders."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from billow.cli.options import DespiteVerdict
from billow.cli.page_files import write_page


def explore(
    surrogate_file: Annotated[
        Path, typer.Argument(metavar="SURROGATE", help="Surrogate file, or that of a coupled model.")
    ],
    out: Annotated[Path | None, typer.Option(help="Page (default: the name of the file, with .html).")] = None,
    despite_verdict: DespiteVerdict = False,
) -> None:
    """Write a page with sliders: the bag, its curves and intervals for any design, in a browser, without a network.

    A coupled file adds the motion of its impactor and its injury metrics. The page is one file that can be sent on.
    """
    from billow.pages.explorer import explorer_page
    from billow.rom.coupled.coupled_model import load_if_coupled
    from billow.rom.surrogate.surrogate import Surrogate

    coupled = load_if_coupled(surrogate_file)
    surrogate = Surrogate.load(surrogate_file) if coupled is None else coupled.surrogate
    if despite_verdict:
        surrogate, coupled = surrogate.despite_verdict(), coupled and coupled.despite_verdict()
    write_page(out or surrogate_file.with_suffix(".html"), explorer_page(surrogate, coupled, surrogate_file))
