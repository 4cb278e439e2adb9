"""`billow injury`: injury metrics of a finished run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def injury(run: Annotated[Path, typer.Argument(help="Result folder of a run with a free obstacle.")]) -> None:
    """Injury metrics of every free obstacle of a run, taken as a head (CFC 1000).

    HIC15 and HIC36 with their windows, the 3 ms clip (summed, and without interruption), and the peak.
    """
    from billow.injury.criteria import GRAVITY
    from billow.injury.motion import assess_run
    from billow.results.result import Result

    for name, found in assess_run(Result.open(run)).items():
        for title, hic in (("HIC15", found.hic15), ("HIC36", found.hic36)):
            print(f"{name}  {title}      {hic.value:8.1f}    from {1e3 * hic.start:.2f} to {1e3 * hic.end:.2f} ms")
        print(f"{name}  3 ms clip  {found.clip / GRAVITY:8.2f} g  contiguous {found.contiguous_clip / GRAVITY:.2f} g")
        print(f"{name}  peak       {found.peak / GRAVITY:8.2f} g  at {1e3 * found.peak_time:.2f} ms")
