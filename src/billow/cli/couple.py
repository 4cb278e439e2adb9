"""`billow couple`: a surrogate that moves an impactor."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from billow.cli.options import (
    DesignValues,
    DespiteVerdict,
    Extrapolate,
    StudyFolder,
    SurrogateOption,
    epochs,
    make_console,
    parse_settings,
    steps,
)

app = typer.Typer(
    name="couple",
    no_args_is_help=True,
    rich_markup_mode="rich",
    help="""Couple a surrogate to an impactor: acceleration, velocity, HIC of a free obstacle without a run.

A first round, with a study of a free obstacle:

\b
  billow train STUDY                                          the bag
  billow couple train STUDY                                   the force on the obstacle
  billow couple evaluate STUDY                                both against unseen runs
  billow couple predict STUDY/coupled.safetensors --set permeability=0.03 ...
""",
)


@app.command()
def train(
    folder: StudyFolder,
    surrogate_file: SurrogateOption = None,
    out: Annotated[Path | None, typer.Option(help="Coupled file (default: STUDY/coupled.safetensors).")] = None,
    seed: Annotated[int, typer.Option(help="Seed of the networks.")] = 0,
) -> None:
    """Learn the contact force on the free obstacle, from the training runs of the surrogate.

    Bag and force are learned up to four more times, each time without a quarter of the runs: their errors on these make
    the intervals of every answer, and the verdict.
    """
    from billow.results.dataset import Dataset
    from billow.results.ownership import owned_file
    from billow.results.tensor_file import SIGN as TENSORS
    from billow.rom.coupled.coupled_model import Coupled
    from billow.rom.learn.train import import_network
    from billow.rom.surrogate.prediction import describe_judgement
    from billow.rom.surrogate.surrogate import Surrogate

    import_network()
    dataset = Dataset.open(folder)
    surrogate = Surrogate.load(surrogate_file or folder / "surrogate.safetensors")
    out = out or folder / "coupled.safetensors"
    with owned_file(out, TENSORS), epochs(make_console(), "training") as progress:
        coupled = Coupled.train(dataset, surrogate, seed, progress)
        path = coupled.save(out)
    make_console().print(f"{path}: {coupled}")
    make_console().print(f"motion {describe_judgement(coupled.judgement, 'billow couple evaluate STUDY')}")


@app.command()
def evaluate(
    folder: StudyFolder,
    coupled_file: Annotated[
        Path | None, typer.Option("--coupled", help="Coupled file (default: STUDY/coupled.safetensors).")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write the numbers as JSON.")] = None,
) -> None:
    """Compare with the solver on unseen runs: ISO/TS 18571 ratings and injury metrics.

    The coupled file keeps the verdict, and says it with every answer.
    """
    from dataclasses import replace

    from billow.results.atomic import write_atomically
    from billow.results.dataset import Dataset
    from billow.results.ownership import owned_file
    from billow.results.tensor_file import SIGN as TENSORS
    from billow.rom.coupled.coupled_evaluation import describe_evaluation, evaluate_coupled
    from billow.rom.coupled.coupled_model import Coupled

    dataset = Dataset.open(folder)
    path = coupled_file or folder / "coupled.safetensors"
    coupled = Coupled.load(path)
    with steps(make_console()) as progress:
        found = evaluate_coupled(dataset, coupled, progress)
    if out is not None:
        with owned_file(out, b'{\n "runs": ['):
            write_atomically(out, json.dumps(found.record(), indent=1, allow_nan=False) + "\n")
    calibration = coupled.calibration and replace(coupled.calibration, of_injury=found.of_injury)
    with owned_file(path, TENSORS):
        replace(coupled, judgement=found.judgement, calibration=calibration).save(path)
    print(describe_evaluation(found))
    print(f"{path} keeps the verdict")


@app.command()
def predict(
    coupled_file: Annotated[Path, typer.Argument(help="Coupled file.")],
    settings: DesignValues = None,
    out: Annotated[Path | None, typer.Option(help="Write motion.csv, injury.json and motion.svg here.")] = None,
    extrapolate: Extrapolate = False,
    despite_verdict: DespiteVerdict = False,
) -> None:
    """Motion and injury metrics of the obstacle in one deployment. Without --set, list the parameters."""
    from billow.rom.coupled.coupled_answer import describe_answer
    from billow.rom.coupled.coupled_model import Coupled
    from billow.rom.surrogate.prediction import describe_surrogate

    coupled = Coupled.load(coupled_file)
    if not settings:
        print(describe_surrogate(coupled.surrogate))
        return
    if despite_verdict:
        coupled = coupled.despite_verdict()
    answer = coupled.answer(parse_settings(settings), extrapolate=extrapolate)
    print(describe_answer(answer, despite_verdict))
    if out is not None:
        from billow.results.ownership import owned
        from billow.rom.coupled.answer_files import write_answer

        with owned(out):
            write_answer(answer, out)
        print(f"{out}: motion.csv, injury.json, motion.svg")
