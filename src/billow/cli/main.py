"""The `billow` command. Each command is a few lines over the Python interface of the same name."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Annotated

import typer

from billow import __version__
from billow.base.errors import BillowError, InputError, ResourceError
from billow.cli import converge, couple, coupon, export, import_runs, injury, paper, suggest, tank
from billow.cli.options import CaseFile, Settings, make_console, parse_settings

INTERRUPTED = 130
"""Exit code after Ctrl-C."""

# OpenBLAS threads spin while they wait: beside other work they cost more than they give (a POD of 0.2 s took 17 s),
# and the last bits of a POD depend on their number. Must be set before NumPy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

app = typer.Typer(
    name="billow",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    help="""Simulate airbag deployment, and learn a reduced-order model from it.

A first round:

\b
  billow demo --out demo                the whole idea, ends with a report
  billow check --example > bag.toml     a case to start from
  billow run bag.toml --out runs/bag    one deployment
""",
)


def main() -> None:
    """Entry point: every failure becomes a message in four parts and an exit code; a traceback is never the answer."""
    try:
        app()
    except SystemExit as end:
        if end.code == INTERRUPTED:  # what typer makes of Ctrl-C
            print("interrupted; billow resume RUN goes on with a run, the same command with a study", file=sys.stderr)
        raise
    except Exception as problem:
        error = problem if isinstance(problem, BillowError) else _unexpected(problem)
        print(error, file=sys.stderr)
        sys.exit(error.exit_code)


def _unexpected(problem: Exception) -> BillowError:
    """What the operating system refuses, E-CLI-005; anything else is a mistake in Billow, E-CLI-070."""
    if isinstance(problem, OSError):
        return ResourceError(
            "E-CLI-005",
            "a file or folder cannot be used",
            where=str(problem.filename or "unknown"),
            why=problem.strerror or str(problem),
            remedy="check path, permissions and free space, or choose another place with --out",
        )
    place = traceback.extract_tb(problem.__traceback__)[-1]
    with tempfile.NamedTemporaryFile("w", prefix="billow-report-", suffix=".txt", delete=False) as report:
        report.write(f"Billow {__version__}, {sys.argv[1:]}\n" + "".join(traceback.format_exception(problem)))
    return BillowError(
        "E-CLI-070",
        "Billow itself failed",
        where=f"{Path(place.filename).name}:{place.lineno}",
        why=f"{type(problem).__name__}: {problem}",
        remedy=f"please report it together with {report.name}",
    )


def _version(wanted: bool) -> None:
    if wanted:
        print(__version__)
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print it.")] = False,
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
        from billow.cli.demo import CASE

        print(CASE, end="")
        return
    if case_file is None:
        raise InputError(
            "E-CLI-003",
            "no case was given",
            where="billow check",
            why="it needs the path of a case file",
            remedy="billow check CASE.toml, or billow check --example > bag.toml",
        )
    from billow.case.schema import Case
    from billow.run.check import describe

    print(describe(Case.load(case_file).vary(parse_settings(settings))))


def _show(progress) -> None:
    print(progress.line, flush=True)


@app.command()
def run(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option(help="Result folder; must not exist yet.")],
    settings: Settings = None,
    threads: Annotated[int | None, typer.Option(min=1, help="Threads; results do not depend on it.")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="No solver log on the screen.")] = False,
) -> None:
    """Simulate one case.

    Writes case.toml (every default filled in), fabric.vtkhdf (opens in ParaView), histories.csv, solver.log, run.json.
    """
    from billow.case.schema import Case
    from billow.run.simulate import simulate

    case = Case.load(case_file).vary(parse_settings(settings))
    result = simulate(case, out, progress=None if quiet else _show, threads=threads)
    print(f"{result.folder}: {result.status}")


@app.command()
def resume(
    folder: Annotated[Path, typer.Argument(help="The --out folder of the interrupted run.")],
    threads: Annotated[int | None, typer.Option(min=1, help="Threads; results do not depend on it.")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="No solver log on the screen.")] = False,
) -> None:
    """Go on with an interrupted run from its newest checkpoint.

    A run saves itself every 30 s, on SIGUSR2, and when it is asked to stop: Ctrl-C, SIGTERM, or a file named STOP in
    its .partial folder. The results are the same bits as without interruption, whatever the number of threads.
    """
    from billow.run.simulate import resume as go_on

    result = go_on(folder, progress=None if quiet else _show, threads=threads)
    print(f"{result.folder}: {result.status}")


@app.command()
def study(
    study_file: Annotated[Path, typer.Argument(help="Study file (TOML): a case, parameters and their ranges.")],
    out: Annotated[Path, typer.Option(help="Study folder; the same command continues an interrupted study.")],
    workers: Annotated[int | None, typer.Option(min=1, help="Local worker processes (default: one per core).")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Use the Dask cluster at this address, e.g. tcp://host:8786.")
    ] = None,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="Try failed runs again.")] = False,
) -> None:
    """Run a design of experiments: draw the designs, simulate each, keep what fails with its reason."""
    from billow.study.progress import study_progress
    from billow.study.study import Study

    console = make_console()
    made = Study.create(study_file, out)
    with study_progress(console) as report:
        summary = made.run(workers, scheduler, report, retry_failed=retry_failed)
    for name, reason in summary.failed.items():
        console.print(f"run {name} failed: {reason}", markup=False)
    raise typer.Exit(1 if summary.failed else 0)


@app.command()
def train(
    folder: Annotated[Path, typer.Argument(help="Study folder.")],
    out: Annotated[Path | None, typer.Option(help="Surrogate file (default: FOLDER/surrogate.safetensors).")] = None,
    recipe: Annotated[str, typer.Option(help="shared: one network for all modes; paper: one per mode.")] = "shared",
    modes: Annotated[int, typer.Option(min=1, help="Modes of each displacement component (K).")] = 12,
    runs: Annotated[int | None, typer.Option(min=2, help="Use only the first so many training runs.")] = None,
    epochs: Annotated[int | None, typer.Option(min=1, help="Epochs (default: the recipe's).")] = None,
    seed: Annotated[int, typer.Option(help="Seed of basis and networks.")] = 0,
    memory: Annotated[float, typer.Option(min=0.1, help="GiB of snapshots held at once; more are streamed.")] = 4.0,
) -> None:
    """Learn a surrogate from the training runs of a study."""
    from billow.cli.terminal import epochs as show_epochs
    from billow.results.dataset import Dataset
    from billow.rom.learn.left_out import left_out
    from billow.rom.learn.train import Recipe
    from billow.rom.learn.train import train as learn

    console = make_console()
    dataset = Dataset.open(folder)
    lost = left_out(dataset, dataset.trusted)
    if lost.why:
        console.print(f"{len(lost.why)} training runs are left out: {lost.reasons()}", markup=False)
    with show_epochs(console, "training") as progress:
        how = Recipe(recipe, modes, seed, epochs, memory=int(memory * 2**30))
        surrogate = learn(dataset, how, runs=dataset.trusted[:runs], progress=progress)
    path = surrogate.save(out or folder / "surrogate.safetensors")
    seconds = surrogate.training["pod_seconds"] + surrogate.training["network_seconds"]
    console.print(f"{path}: learned {len(surrogate.training['runs'])} runs in {seconds:.1f} s", markup=False)


@app.command()
def evaluate(
    folder: Annotated[Path, typer.Argument(help="Study folder.")],
    surrogate_file: Annotated[
        Path | None, typer.Option("--surrogate", help="Surrogate file (default: FOLDER/surrogate.safetensors).")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Report folder (default: FOLDER/report).")] = None,
    memory: Annotated[float, typer.Option(min=0.1, help="GiB of snapshots held at once; more are streamed.")] = 4.0,
) -> None:
    """Measure a surrogate on the unseen runs of its study and write report.html, metrics.json and figures."""
    from billow.cli.terminal import steps
    from billow.results.dataset import Dataset
    from billow.rom.judge.evaluate import evaluate as measure
    from billow.rom.judge.report import write_report
    from billow.rom.surrogate.surrogate import Surrogate

    dataset = Dataset.open(folder)
    surrogate = Surrogate.load(surrogate_file or folder / "surrogate.safetensors")
    with steps(make_console()) as progress:
        evaluation = measure(dataset, surrogate, memory=int(memory * 2**30), progress=progress)
    path = write_report(dataset, evaluation, out or folder / "report")
    make_console().print(f"report: {path}", markup=False)


@app.command()
def predict(
    surrogate_file: Annotated[Path, typer.Argument(help="Surrogate file.")],
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="Value of a design parameter.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write the deployment as .vtkhdf (opens in ParaView).")] = None,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Allow values outside the trained ranges.")
    ] = False,
) -> None:
    """Predict one deployment. Without --set it lists the parameters and their trained ranges."""
    from billow.rom.surrogate.prediction import describe_surrogate, write_prediction
    from billow.rom.surrogate.surrogate import Surrogate

    surrogate = Surrogate.load(surrogate_file)
    if not settings:
        print(describe_surrogate(surrogate))
        return
    print(write_prediction(surrogate, parse_settings(settings), out, extrapolate))


@app.command()
def verify(
    ids: Annotated[list[str] | None, typer.Argument(help="Cases to run, e.g. T1 S6 (default: all).")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON list.")] = False,
) -> None:
    """Run closed-form cases through the solver: measured, expected, tolerance. Exit code 1 if one fails."""
    from billow.apps.verification.cases import run_cases

    if as_json:
        checks = run_cases(ids)
        print(json.dumps([check.record() for check in checks], indent=1))
    else:
        print(f"{'id':<4} {'measured':>14} {'expected':>14} {'tolerance':>10} {'':6} {'time':>7}  title")

        def show(check) -> None:
            verdict = "ok" if check.passed else "FAILED"
            print(
                f"{check.id:<4} {check.measured:>14.8g} {check.expected:>14.8g} {check.tolerance:>10.1e} {verdict:6}"
                f" {check.seconds:>6.1f}s  {check.title}",
                flush=True,
            )

        checks = run_cases(ids, progress=show)
        passed = sum(check.passed for check in checks)
        print(f"{passed} of {len(checks)} checks passed")
    raise typer.Exit(0 if all(check.passed for check in checks) else 1)


@app.command()
def demo(
    out: Annotated[Path, typer.Option(help="Folder; the same command continues an interrupted demo.")] = Path("demo"),
    train: Annotated[int, typer.Option(min=8, help="Training designs.")] = 48,
    test: Annotated[int, typer.Option(min=2, help="Unseen designs.")] = 12,
    workers: Annotated[int | None, typer.Option(min=1, help="Worker processes (default: one per core).")] = None,
) -> None:
    """The whole idea at reduced size: 60 deployments, a surrogate learned from 48, judged on 12, and a report."""
    from billow.cli.demo import run_demo

    run_demo(out, train, test, workers, make_console())


app.command()(converge.converge)
app.command()(coupon.coupon)
app.add_typer(tank.app)
app.command()(injury.injury)
app.add_typer(couple.app)
app.command()(suggest.suggest)
app.command()(export.export)
app.command("import")(import_runs.import_runs)
app.command()(paper.paper)

if __name__ == "__main__":
    main()
