"""The `billow` command. Each command is a few lines over the Python interface of the same name."""

from __future__ import annotations

import atexit
import errno
import gc
import json
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Annotated

from billow.cli.surroundings import settle, show_any_letter, take_away

settle()
# ruff: noqa: E402  what follows imports libraries

import typer

from billow import __version__
from billow.base.errors import BillowError, InputError, ResourceError
from billow.cli import (
    compare,
    converge,
    couple,
    coupon,
    dataset,
    decks,
    design,
    explore,
    fold,
    paper,
    plot,
    render,
    schema,
    surrogates,
    tank,
    view,
)
from billow.cli.endings import CONTINUES, end_as_with_ctrl_c, interruptible, lasting_streams
from billow.cli.options import CaseFile, Quiet, Settings, Threads, make_console, parse_settings
from billow.cli.watch import say_end, watched
from billow.results.atomic import NOT_WRITTEN

NO_CASE = InputError.declare(
    "E-CLI-003",
    "no case was given",
    where="billow check",
    why="it needs the path of a case file",
    remedy="billow check CASE.toml, or billow check --example > bag.toml",
)
UNUSABLE_PLACE = ResourceError.declare(
    "E-CLI-005",
    "a file or folder cannot be used",
    where="{path}",
    cause="no permission, a full disk, or a path that does not exist",
    remedy="check path, permissions and free space, or choose another place with --out",
)
OUT_OF_MEMORY = ResourceError.declare(
    "E-CLI-009",
    "there is not enough memory",
    where="this process",
    why="the system gave no more",
    cause="a fine mesh, many obstacles, a large dataset, or other programs",
    remedy="see what `billow check` says the case needs; use a coarser mesh, or close other programs",
)
BILLOW_FAILED = BillowError.declare(
    "E-CLI-070",
    "Billow itself failed",
    where="{file}:{line}",
    why="{kind}: {problem}",
    cause="a mistake in Billow",
    remedy="please report it together with {report}",
)

OBJECTS_OF_A_START = 300_000
"""Containers that Python has made when a run begins; nearly all of them stay."""

app = typer.Typer(
    name="billow",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    help="""Simulate airbag deployment, and train a reduced-order model on it.

A first round:

\b
  billow demo --out demo                a small study from start to report
  billow check --example > bag.toml     a case to start from
  billow run bag.toml --out runs/bag    one deployment
""",
)


def main() -> None:
    """Entry point: every failure becomes a message in four parts and an exit code, never a traceback."""
    show_any_letter()
    end_as_with_ctrl_c()
    gc.set_threshold(OBJECTS_OF_A_START)  # to look through them again and again takes a tenth of the start
    atexit.register(gc.freeze)  # Python's last search for garbage takes 0.15 s, and the system takes all back anyway
    with lasting_streams():
        code = 0
        try:
            app()
        except SystemExit as end:
            code = end.code
        except Exception as problem:
            error = problem if isinstance(problem, BillowError) else _unexpected(problem)
            print(error, file=sys.stderr)
            code = error.exit_code
        if sys.stdout is not None:
            sys.stdout.flush()
            if sys.stdout.problem is not None:
                error = UNUSABLE_PLACE(path="standard output", why=sys.stdout.problem)
                print(error, file=sys.stderr)
                code = code or error.exit_code
    sys.exit(code)


def _unexpected(problem: Exception) -> BillowError:
    """What the operating system refuses, E-RES-020, E-CLI-005 and -009; anything else is a mistake in Billow,
    E-CLI-070."""
    place = traceback.extract_tb(problem.__traceback__)[-1]
    if isinstance(problem, OSError) and problem.errno in (errno.ENOSPC, errno.EDQUOT):
        return NOT_WRITTEN(folder=problem.filename or "unknown", why=problem)
    if isinstance(problem, OSError):
        return UNUSABLE_PLACE(path=problem.filename or "unknown", why=problem)
    if isinstance(problem, UnicodeEncodeError):  # a name, where Python writes names in ASCII
        return UNUSABLE_PLACE(path=problem.object, why="its letters are not in the encoding of the environment")
    if isinstance(problem, RecursionError) and Path(place.filename).name == "pathlib.py":
        return UNUSABLE_PLACE(path="a path of the command", why="it has too many folders")
    if isinstance(problem, MemoryError):
        return OUT_OF_MEMORY(why=str(problem) or None)
    text = f"Billow {__version__}, {sys.argv[1:]}\n" + "".join(traceback.format_exception(problem))
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="billow-report-", suffix=".txt", delete=False, encoding="utf-8", errors="replace"
        ) as report:
            report.write(text)
        written = report.name
    except OSError:  # no room for it there either
        print(text, file=sys.stderr)
        written = "what stands above"
    return BILLOW_FAILED(
        file=Path(place.filename).name,
        line=place.lineno,
        kind=type(problem).__name__,
        problem=str(problem),
        report=written,
    )


def _version(wanted: bool) -> None:
    if wanted:
        print(__version__)
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


@app.command()
def check(
    case_file: Annotated[Path | None, typer.Argument(help="Case file (TOML).")] = None,
    settings: Settings = None,
    example: Annotated[bool, typer.Option("--example", help="Print a commented case to start from.")] = False,
) -> None:
    """Read a case and build its model without running it: errors, size, mass, time step, amount of gas."""
    if example:
        from billow.cli.example import EXAMPLE

        print(EXAMPLE, end="")
        return
    if case_file is None:
        raise NO_CASE()
    from billow.case.schema import Case
    from billow.run.check import describe

    print(describe(Case.load(case_file).vary(parse_settings(settings))))


@app.command()
def run(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option(help="Result folder; must not exist yet.")],
    settings: Settings = None,
    threads: Threads = None,
    quiet: Quiet = False,
) -> None:
    """Simulate one case.

    Writes case.toml (every default filled in), scene.vtkhdf (opens in ParaView), histories.csv, solver.log, run.json.
    """
    from billow.case.schema import Case
    from billow.run.simulate import simulate

    case = Case.load(case_file).vary(parse_settings(settings))
    with interruptible("it had saved nothing yet; the same command begins again", out), watched(quiet) as show:
        result = simulate(case, out, progress=show, threads=threads)
    say_end(result, quiet)


@app.command()
def resume(
    folder: Annotated[Path, typer.Argument(help="The --out folder of the interrupted run.")],
    threads: Threads = None,
    quiet: Quiet = False,
) -> None:
    """Continue an interrupted run from its newest checkpoint.

    A run saves itself every 30 s, on SIGUSR2, and when asked to stop: Ctrl-C, SIGTERM, SIGHUP, SIGXCPU, or a file named
    STOP in its .partial folder. The results are the same bits as without interruption, whatever the number of threads.
    """
    from billow.run.simulate import resume as continue_run

    with interruptible(CONTINUES, folder), watched(quiet) as show:
        result = continue_run(folder, progress=show, threads=threads)
    say_end(result, quiet)


@app.command()
def study(
    study_file: Annotated[Path, typer.Argument(help="Study file (TOML): a case, parameters and their ranges.")],
    out: Annotated[Path, typer.Option(help="Study folder; the same command continues an interrupted study.")],
    workers: Annotated[int | None, typer.Option(min=1, help="Local worker processes (default: one per core).")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Use the Dask cluster at this address, e.g. tcp://host:8786.")
    ] = None,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="Try failed runs again.")] = False,
    until: Annotated[
        str | None,
        typer.Option(metavar="AIM", help='Add runs until this holds for runs held out: "rmse < 3 mm", "hic15 < 40".'),
    ] = None,
    hours: Annotated[float, typer.Option(min=0.0, help="Hours after which --until adds no more.")] = 24.0,
) -> None:
    """Run a design of experiments: draw the designs and simulate each; failures are kept with their reason.

    With --until, batches of eight runs are added where the model is least certain; OUT/learning_curve.svg shows the
    error. --until needs no change of the study file, and may be given again.
    """
    from billow.study.progress import study_progress
    from billow.study.study import Study

    console = make_console()
    if scheduler is None:
        take_away(("DASK_",))  # settings of clusters, which could keep local workers from starting
    aim = None
    if until is not None:
        from billow.design.adaptive import Aim

        aim = Aim.read(until)
    made = Study.create(study_file, out)
    with interruptible(CONTINUES), study_progress(console) as report:
        summary = made.run(workers, scheduler, report, retry_failed=retry_failed)
        if aim is not None:
            again = _grow(out, aim, hours, console, workers=workers, scheduler=scheduler, progress=report)
            summary = again or summary
    for line in (*summary.reasons, *(f"run {name} failed: {reason}" for name, reason in summary.failed.items())):
        console.print(line, markup=False, soft_wrap=True)
    raise typer.Exit(1 if summary.failed else 0)


def _grow(out: Path, aim, hours: float, console, **running):
    """Add runs until the aim is reached, and draw how the error fell; the study's summary if runs were added."""
    from billow.design.adaptive import grow, learning_curve
    from billow.design.figures import draw
    from billow.results.atomic import write_atomically

    def say(line: str) -> None:
        console.print(line, markup=False, soft_wrap=True)

    grown = grow(out, aim, hours, say, **running)
    write_atomically(out / "learning_curve.svg", draw(learning_curve, grown.stages, aim))
    told = "reached" if grown.reached else f"NOT reached, {grown.why};"
    say(f"{out / 'learning_curve.svg'}: {told} with {grown.stages[-1].runs} runs")
    return grown.summary


@app.command("import")
def import_runs(
    folder: Annotated[Path, typer.Argument(help="Folder with runs.csv and the moving meshes.")],
    out: Annotated[Path, typer.Option(help="Study folder; must not exist yet.")],
    title: Annotated[str | None, typer.Option(help="Title of the dataset (default: the folder's name).")] = None,
    reference_length: Annotated[
        float | None,
        typer.Option(min=1e-9, help="Length \\[m] that errors are relative to (default: size of the mesh)."),
    ] = None,
    test_share: Annotated[
        float, typer.Option(min=0.0, max=0.9, help="Share of test runs, unless runs.csv has a column split.")
    ] = 0.2,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the split.")] = 0,
    units: Annotated[str | None, typer.Option(metavar="SYSTEM", help="Of d3plot files: kg-mm-ms, t-mm-s, ...")] = None,
    part: Annotated[list[int] | None, typer.Option(help="Part of a d3plot that belongs to the bag.")] = None,
) -> None:
    """Make a dataset from runs of another solver: CSV, NumPy or VTK frames or d3plot, and a table of parameters.

    Nodes, triangles, times and start shapes are checked against each other; nothing is written unless all agree.
    """
    from billow.study.import_runs import import_runs as make_dataset

    train, test = make_dataset(
        folder, out, title=title, reference_length=reference_length, test_share=test_share, seed=seed,
        units=decks.known_units("import", units), parts=tuple(part or ()),
    )  # fmt: skip
    print(f"{out}: {train} training and {test} unseen runs\nnext: billow train {out}")


@app.command()
def injury(run: Annotated[Path, typer.Argument(help="Result folder of a run with a free obstacle.")]) -> None:
    """Injury metrics of every free obstacle of a run, regarded as a head (CFC 1000).

    HIC15 and HIC36 with their windows, the 3 ms clip (cumulative and contiguous), and the peak.
    """
    from billow.injury.criteria import GRAVITY, assess_run
    from billow.results.result import Result

    for name, found in assess_run(Result.open(run)).items():
        for title, hic in (("HIC15", found.hic15), ("HIC36", found.hic36)):
            print(f"{name}  {title}      {hic.value:8.1f}    from {1e3 * hic.start:.2f} to {1e3 * hic.end:.2f} ms")
        print(f"{name}  3 ms clip  {found.clip / GRAVITY:8.2f} g  contiguous {found.contiguous_clip / GRAVITY:.2f} g")
        print(f"{name}  peak       {found.peak / GRAVITY:8.2f} g  at {1e3 * found.peak_time:.2f} ms")


@app.command()
def verify(
    ids: Annotated[list[str] | None, typer.Argument(help="Cases to run, e.g. T1 S6 (default: all).")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON list.")] = False,
) -> None:
    """Run the closed-form cases: measured, expected, tolerance. Exit code 1 if one fails."""
    from billow.apps.verification.cases import run_cases

    def show(check) -> None:
        verdict = "ok" if check.passed else "FAILED"
        print(
            f"{check.id:<4} {check.measured:>14.8g} {check.expected:>14.8g} {check.tolerance:>10.1e} {verdict:6}"
            f" {check.seconds:>6.1f}s  {check.title}",
            flush=True,
        )

    if as_json:
        checks = run_cases(ids)
        print(json.dumps([check.record() for check in checks], indent=1))
    else:
        print(f"{'id':<4} {'measured':>14} {'expected':>14} {'tolerance':>10} {'':6} {'time':>7}  title")
        checks = run_cases(ids, progress=show)
        print(f"{sum(check.passed for check in checks)} of {len(checks)} checks passed")
    raise typer.Exit(0 if all(check.passed for check in checks) else 1)


@app.command()
def demo(
    out: Annotated[Path, typer.Option(help="Folder; the same command continues an interrupted demo.")] = Path("demo"),
    train: Annotated[int, typer.Option(min=8, help="Training designs.")] = 48,
    test: Annotated[int, typer.Option(min=2, help="Unseen designs.")] = 12,
    workers: Annotated[int | None, typer.Option(min=1, help="Worker processes (default: one per core).")] = None,
) -> None:
    """A small study from start to report: 60 deployments, a surrogate trained on 48 of them and tested on 12."""
    from billow.cli.demo import run_demo

    with interruptible(CONTINUES):
        run_demo(out, train, test, workers, make_console())


for command in (
    surrogates.train, surrogates.floor, surrogates.evaluate, surrogates.predict, surrogates.suggest, surrogates.export,
    converge.converge, coupon.coupon, fold.fold, paper.paper, schema.schema, plot.plot, compare.compare,
    render.render, explore.explore, view.view, view.report, design.respond,
):  # fmt: skip
    app.command()(command)
app.command("import-deck")(decks.import_deck)
app.command("export-deck")(decks.export_deck)
app.command("export-d3plot")(decks.export_d3plot)
for group in (tank.app, couple.app, design.app, dataset.app):
    app.add_typer(group)

if __name__ == "__main__":
    main()
