"""`billow respond` and `billow design`: responses of runs, their surfaces, and what can be asked of these."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from billow.cli.options import StudyFolder, make_console

app = typer.Typer(
    name="design",
    no_args_is_help=True,
    rich_markup_mode="rich",
    help="""Response surfaces of a study: what matters, the best design, how robust it is.

A first round:

\b
  billow respond STUDY --out responses.csv                        a row for each run
  billow design train STUDY --out responses.safetensors           surfaces and their verdicts
  billow design sensitivity responses.safetensors --out what_matters
  billow design optimise responses.safetensors goals.toml --out best --verify 3 --study STUDY
  billow design report responses.safetensors --optimum best --out design.html
""",
)

ResponsesFile = Annotated[Path, typer.Argument(metavar="RESPONSES", help="File of `billow design train`.")]
OutFolder = Annotated[Path, typer.Option(help="Folder for tables and figures.")]


def respond(
    folder: StudyFolder,
    out: Annotated[Path | None, typer.Option(help="Table (.csv); default: print it.")] = None,
) -> None:
    """Read the responses of every run of a study, those of its study.toml or the usual ones; the header has units."""
    from billow.design.table import respond as read
    from billow.results.atomic import write_atomically
    from billow.results.ownership import owned_file

    table = read(folder)
    text = table.csv()
    if out is None:
        print(text, end="")
        return
    with owned_file(out, b"run,split,"):
        write_atomically(out, text)
    print(f"{out}: {len(table.responses)} responses of {len(table.runs)} runs; {len(table.left_out)} left out")


@app.command()
def train(
    folder: StudyFolder,
    out: Annotated[Path | None, typer.Option(help="File (default: STUDY/responses.safetensors).")] = None,
) -> None:
    """Make a response surface for each response of a study, with intervals and a verdict from runs held out."""
    from billow.design.surfaces import ResponseSurfaces
    from billow.design.table import respond as read
    from billow.results.ownership import owned_file
    from billow.results.tensor_file import SIGN

    console = make_console()
    table = read(folder)
    for run, why in table.left_out.items():
        console.print(f"run {run} is left out: {why}")
    surfaces = ResponseSurfaces.learn(table)
    out = out or folder / "responses.safetensors"
    with owned_file(out, SIGN):
        surfaces.save(out)
    for name, unit, surface in zip(surfaces.names, surfaces.units, surfaces.surfaces, strict=True):
        console.print(f"{name} [{unit}]: {surface.verdict}; rmse {surface.verdict.rmse:.4g}")
    console.print(f"{out}: {len(surfaces.runs)} runs")


@app.command()
def sensitivity(
    responses: ResponsesFile,
    out: OutFolder,
    response: Annotated[list[str] | None, typer.Option(help="Only these responses.")] = None,
    samples: Annotated[int, typer.Option(help="Base samples, a power of two.")] = 1024,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the samples.")] = 0,
) -> None:
    """Sobol' indices of the responses: sensitivity.csv and figures."""
    from billow.design import figures
    from billow.design.sensitivity import sensitivity as indices
    from billow.design.surfaces import ResponseSurfaces
    from billow.results.atomic import write_atomically
    from billow.results.csv_files import csv_text
    from billow.results.ownership import owned

    console, surfaces = make_console(), ResponseSurfaces.load(responses)
    names = response or [name for name in surfaces.names if surfaces.verdict(name).usable]
    found = [indices(surfaces, name, samples, seed) for name in names]
    ends = ("", " low", " high")
    head = ["response", "parameter", *(f"{kind}{end} [-]" for kind in ("first", "total") for end in ends), "seed"]
    rows = [
        [one.response, name, *map(float, first), *map(float, total), seed]
        for one in found
        for name, first, total in zip(one.names, one.first, one.total, strict=True)
    ]
    with owned(out):
        write_atomically(out / "sensitivity.csv", csv_text([head, *rows]))
        if found:
            write_atomically(out / "sobol.svg", figures.draw(figures.sobol_bars, surfaces, found))
            write_atomically(out / "prognosis.svg", figures.draw(figures.prognosis, surfaces, found))
    for name in surfaces.names:
        if name not in names:
            console.print(f"{name}: no indices, {surfaces.verdict(name)}")
    for one in found:
        order = one.total[:, 0].argsort()[::-1]
        told = ", ".join(
            f"{one.names[k]} {one.total[k, 0]:.2f} ({one.total[k, 1]:.2f} to {one.total[k, 2]:.2f})" for k in order
        )
        console.print(f"{one.response}, {surfaces.verdict(one.response).word}: {told}")


@app.command()
def optimise(
    responses: ResponsesFile,
    goals: Annotated[Path, typer.Argument(metavar="GOALS", help="What is wanted (TOML).")],
    out: OutFolder,
    verify: Annotated[int, typer.Option(min=0, max=3, help="Rounds in which the optimum is run in the solver.")] = 0,
    study: Annotated[Path | None, typer.Option(help="Study folder (default: where RESPONSES lies).")] = None,
) -> None:
    """Find the best design within the limits and the reach of the runs; with --verify, run it, learn from it, go on.

    An optimum that the solver has not run is a proposal. Exit code 1 if the solver does not confirm the last one.
    """
    from billow.design.optimum import Goal
    from billow.design.optimum import optimise as search
    from billow.design.report import OPTIMUM_FILE, optimum_record
    from billow.design.surfaces import ResponseSurfaces
    from billow.design.verify import Round, verified
    from billow.results.atomic import write_atomically
    from billow.results.ownership import owned, owned_file
    from billow.results.tensor_file import SIGN

    console, surfaces = make_console(), ResponseSurfaces.load(responses)
    goal = Goal.load(goals, surfaces)
    with owned(out):
        if verify:
            rounds, surfaces = verified(surfaces, goal, study or responses.parent, verify, console.print)
            with owned_file(responses, SIGN):
                surfaces.save(responses)
        else:
            rounds = [Round(search(surfaces, goal), "", {})]
        record = json.dumps(optimum_record(rounds, surfaces), indent=1, allow_nan=False) + "\n"
        write_atomically(out / OPTIMUM_FILE, record)
    best = rounds[-1].optimum
    for parameter in surfaces.parameters:
        console.print(f"{parameter.name} = {best.design[parameter.name]:.6g} {parameter.unit}")
    for name, (value, low, high) in best.responses.items():
        word = surfaces.verdict(name).word
        console.print(f"{name}: {value:.4g} {surfaces.unit(name)}, {low:.4g} to {high:.4g} ({word})")
    said = "not run in the solver yet: --verify 3" if not verify else (
        "confirmed by the solver" if rounds[-1].holds else "NOT confirmed by the solver")  # fmt: skip
    console.print(f"{out / OPTIMUM_FILE}: {said}")
    raise typer.Exit(1 if verify and not rounds[-1].holds else 0)


@app.command()
def robust(
    responses: ResponsesFile,
    design: Annotated[Path, typer.Argument(metavar="DESIGN", help="Value of each parameter (TOML), or optimum.json.")],
    scatter: Annotated[Path, typer.Option(help="Standard deviation of each parameter that scatters (TOML).")],
    out: OutFolder,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the scatter.")] = 0,
    verify: Annotated[int, typer.Option(min=0, max=200, help="Runs of the scatter to make in the solver first.")] = 0,
    study: Annotated[Path | None, typer.Option(help="Study folder (default: where RESPONSES lies).")] = None,
) -> None:
    """Percentiles of the responses under scatter, and chances that limits are broken: robustness.csv and a figure.

    With --verify, so many designs of the scatter are run in the solver, added to the study, and learned from: near one
    design a surface is off by much the same everywhere, which a dozen runs mend.
    """
    from billow.design import figures
    from billow.design.report import rounds_of
    from billow.design.robust import PERCENTILES, read_values, robustness
    from billow.design.surfaces import ResponseSurfaces
    from billow.results.atomic import write_atomically
    from billow.results.csv_files import csv_text
    from billow.results.ownership import owned

    surfaces = ResponseSurfaces.load(responses)
    point = rounds_of(design.parent)[-1].optimum.design if design.suffix == ".json" else read_values(design, surfaces)
    if verify:
        from billow.design.verify import scatter_runs
        from billow.results.ownership import owned_file
        from billow.results.tensor_file import SIGN

        about = read_values(scatter, surfaces)
        shifts, surfaces = scatter_runs(surfaces, point, about, study or responses.parent, verify, seed)
        with owned_file(responses, SIGN):
            surfaces.save(responses)
        for one in shifts:
            unit = surfaces.unit(one.response).strip("-")
            away = f"{one.mean:+.3g} (+-{one.error:.2g}) {unit}".rstrip()
            print(f"{one.response}: {verify} runs there lie {away} from the surface, which was made again with them")
    found = robustness(surfaces, point, read_values(scatter, surfaces), seed)
    keys = ("probability", "with_error", "low", "high", "outside", "near")
    head = ["response", "unit", *(f"{p:g} %" for p in PERCENTILES), "below", "above", *keys, "light", "seed"]
    rows = [
        [name, one.unit, *map(float, one.percentiles),
         *("" if end is None else end for end in (one.limit.below, one.limit.above)),
         *(float(getattr(one, key)) for key in keys), one.light, seed]
        for name, one in found.items()
    ]  # fmt: skip
    with owned(out):
        write_atomically(out / "robustness.csv", csv_text([head, *rows]))
        if found:
            write_atomically(out / "robustness.svg", figures.draw(figures.robustness_histograms, list(found.values())))
    for name, one in found.items():
        unit = f" {one.unit}" if one.unit != "-" else ""
        told = f"{name}: {', '.join(f'{p:.4g}' for p in one.percentiles)}{unit} (5, 50, 95 %)"
        if one.broken:
            told += f"; P({one.broken}) = {one.probability:.3g}, with the surface's "
            told += f"own error {one.with_error:.3g} ({one.low:.2g} to {one.high:.2g}): {one.light}"
        print(told)
    if found and not (one := next(iter(found.values()))).resolved:
        told = f"{one.near} runs lie within the scatter, so that nothing shows how far the surface is off there"
        print(f"{told}; --verify 12 makes such runs")


@app.command()
def report(
    responses: ResponsesFile,
    out: Annotated[Path, typer.Option(help="Page (.html).")],
    optimum: Annotated[Path | None, typer.Option(help="Folder of `billow design optimise`.")] = None,
    design: Annotated[Path | None, typer.Option(help="Design that scatters (TOML; default: the optimum).")] = None,
    scatter: Annotated[Path | None, typer.Option(help="Standard deviations (TOML), for robustness.")] = None,
) -> None:
    """All figures on one page that needs no other file: verdicts, sensitivity, optimum, robustness."""
    from billow.design.report import rounds_of, write_report
    from billow.design.robust import SCATTER, read_values, robustness
    from billow.design.surfaces import ResponseSurfaces
    from billow.results.ownership import owned_file

    if (design and not scatter) or (scatter and not (design or optimum)):
        given, missing = ("--design", "--scatter") if design else ("--scatter", "--optimum or --design")
        raise SCATTER(where=given, why="it takes a design and what scatters about it", remedy=f"give {missing}, too")
    surfaces = ResponseSurfaces.load(responses)
    rounds = rounds_of(optimum) if optimum else []
    point = read_values(design, surfaces) if design else rounds[-1].optimum.design if rounds else None
    chances = robustness(surfaces, point, read_values(scatter, surfaces)) if scatter and point else None
    with owned_file(out, b"<!DOCTYPE html>"):
        print(f"{write_report(surfaces, out, rounds, chances)}: written")
