"""`billow converge`: how many particles are enough, and how large the noise is."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from billow.base.units import in_unit
from billow.cli.endings import CONTINUES, interruptible
from billow.cli.options import CaseFile, Settings, Threads, make_console, parse_settings, steps, usable


def converge(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option(help="Folder; the same command continues an interrupted study.")],
    particles: Annotated[
        str, typer.Option(metavar="N,N,...", help="Numbers of particles to compare; the largest is the reference.")
    ] = "5e3,1e4,2e4,4e4",
    seeds: Annotated[int, typer.Option(min=2, help="Runs for each number; they differ only in gas.seed.")] = 3,
    tolerance: Annotated[
        str, typer.Option(help="Acceptable deviation of one run, relative to the size of the quantity.")
    ] = "2 %",
    settings: Settings = None,
    threads: Threads = None,
) -> None:
    """Repeat a case of the corpuscular gas with several numbers of particles and seeds, and say how many are enough.

    Compared are pressure, volume, velocity and acceleration of free obstacles, and the final shape. Deviation: one
    run against the mean of the largest number. Noise: runs that differ only in the seed; it should fall with the
    square root of the number. Enough is the smallest number from which on either a run deviates by at most the
    tolerance, or the mean over seeds deviates no more than the noise of one run with the largest number.

    Begin small: time grows with the number of particles. To refine, run the command again with larger numbers; existing
    runs are not repeated. Writes convergence.csv, summary.toml, errors.png, curves.png, shapes.png.
    """
    from billow.apps.converge.study import report, run_study
    from billow.apps.converge.sweep import Sweep
    from billow.case.schema import Case
    from billow.results.ownership import owned

    with usable("converge", "tolerance", tolerance, "write for example --tolerance '2 %'"):
        good = in_unit(tolerance, "-")
        if not 0.0 <= good < 1.0:
            raise ValueError("expected 0 to 100 %")
    case = Case.load(case_file).vary(parse_settings(settings))
    with usable("converge", "particles", particles, "write for example --particles 5e3,1e4,2e4"):
        counts = [float(part) for part in particles.split(",") if part.strip()]
        if not all(1.0 <= count < 1e12 for count in counts):
            raise ValueError("a number of particles is from 1000 to 20000000")
    sweep = Sweep.of(case, counts, seeds)
    console = make_console()
    with interruptible(CONTINUES), owned(out, "convergence.csv"), steps(console) as progress:
        found = run_study(sweep, out, good, progress, threads)
    console.print(f"{report(found, good)}\n{out}: written")
