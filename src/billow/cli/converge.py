"""`billow converge`: how many particles are enough, and how large their noise is."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from billow.cli.options import UNUSABLE_NUMBER, CaseFile, Settings, make_console, parse_settings


def converge(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option(help="Folder; the same command continues an interrupted study.")],
    particles: Annotated[
        str, typer.Option(metavar="N,N,...", help="Numbers of particles to compare; the largest is the reference.")
    ] = "5e3,1e4,2e4,4e4",
    seeds: Annotated[int, typer.Option(min=2, help="Runs for each number, which differ in gas.seed alone.")] = 3,
    tolerance: Annotated[
        str, typer.Option(help="Deviation of one run that is good enough, of the quantity's own size.")
    ] = "2 %",
    settings: Settings = None,
    threads: Annotated[int | None, typer.Option(min=1, help="Threads; results do not depend on it.")] = None,
) -> None:
    """Repeat a case of the corpuscular gas over numbers of particles and seeds, and say how many are enough.

    Compared are pressure, volume, velocity and acceleration of free obstacles, and the shape at the end. Deviation: a
    run against the mean of the largest number. Noise: runs that differ in the seed alone; it should fall with the
    square root of the number. Enough is the smallest number from which on a run deviates by at most the tolerance, or
    the mean over seeds by no more than one run of the largest number is off by chance.

    Begin small: time grows with the number of particles. To refine, give the command again with larger numbers: runs
    that are there are not repeated. Writes convergence.csv, summary.toml, errors.png, curves.png, shapes.png.
    """
    from billow.apps.converge.study import report, run_study
    from billow.apps.converge.sweep import Sweep
    from billow.case.schema import Case
    from billow.cli.terminal import steps

    good = _tolerance(tolerance)
    sweep = Sweep.of(Case.load(case_file).vary(parse_settings(settings)), _counts(particles), seeds)
    console = make_console()
    with steps(console) as progress:
        found = run_study(sweep, out, good, progress, threads)
    console.print(report(found, good), markup=False)
    console.print(f"{out}: written", markup=False)


def _counts(text: str) -> list[float]:
    try:
        counts = [float(part) for part in text.split(",") if part.strip()]
        if not all(1.0 <= count < 1e12 for count in counts):
            raise ValueError("a number of particles is from 1000 to 20000000")
    except ValueError as error:
        example = "write for example --particles 5e3,1e4,2e4"
        raise UNUSABLE_NUMBER(
            option="particles", text=text[:40], command="converge", why=error, remedy=example
        ) from None
    return counts


def _tolerance(text: str) -> float:
    from billow.base.units import to_si

    try:
        value = to_si(text, "-")
        if not 0.0 <= value < 1.0:
            raise ValueError("expected 0 to 100 %")
    except ValueError as error:
        example = "write for example --tolerance '2 %'"
        raise UNUSABLE_NUMBER(
            option="tolerance", text=text[:40], command="converge", why=error, remedy=example
        ) from None
    return value
