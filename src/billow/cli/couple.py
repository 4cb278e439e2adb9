"""`billow couple`: a surrogate that moves an impactor."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from billow.cli.options import (
    DesignValues,
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
    """Learn the contact force on the free obstacle, from the training runs of the surrogate."""
    from billow.results.dataset import Dataset
    from billow.results.ownership import owned_file
    from billow.results.tensor_file import SIGN as TENSORS
    from billow.rom.coupled.coupled_model import Coupled
    from billow.rom.surrogate.surrogate import Surrogate

    dataset = Dataset.open(folder)
    surrogate = Surrogate.load(surrogate_file or folder / "surrogate.safetensors")
    out = out or folder / "coupled.safetensors"
    with owned_file(out, TENSORS), epochs(make_console(), "training") as progress:
        coupled = Coupled.train(dataset, surrogate, seed, progress)
        path = coupled.save(out)
    make_console().print(f"{path}: {coupled}")


@app.command()
def evaluate(
    folder: StudyFolder,
    coupled_file: Annotated[
        Path | None, typer.Option("--coupled", help="Coupled file (default: STUDY/coupled.safetensors).")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write the numbers as JSON.")] = None,
) -> None:
    """Compare with the solver on unseen runs: ISO/TS 18571 ratings and injury metrics."""
    from billow.results.atomic import write_atomically
    from billow.results.dataset import Dataset
    from billow.results.ownership import owned_file
    from billow.rom.coupled.coupled_evaluation import MEAN_MOTION, QUANTITIES, TRUE_CONTACT, evaluate_coupled
    from billow.rom.coupled.coupled_model import Coupled

    dataset = Dataset.open(folder)
    coupled = Coupled.load(coupled_file or folder / "coupled.safetensors")
    with steps(make_console()) as progress:
        found = evaluate_coupled(dataset, coupled, progress)
    print(f"{len(found.runs)} unseen runs; ISO/TS 18571 ratings against the solver, median and worst")
    print(f"  {'':<20} {'  '.join(f'{answer:<20}' for answer in found.ratings)}")
    for quantity in QUANTITIES:
        pairs = (f"{found.median(quantity, a):.3f}  {found.worst(quantity, a):.3f}" for a in found.ratings)
        print(f"  {quantity:<20} {'  '.join(f'{pair:<20}' for pair in pairs)}")
    print(f"  {TRUE_CONTACT}: the same steps under the force the solver recorded: the best a perfect law can reach;")
    print(f"  {MEAN_MOTION}: mean of the training runs, which ignores the design")
    print(f"  one deployment takes {found.seconds:.3g} s")
    if out is not None:
        with owned_file(out, b'{\n "runs": ['):
            write_atomically(out, json.dumps(found.record(), indent=1, allow_nan=False) + "\n")


@app.command()
def predict(
    coupled_file: Annotated[Path, typer.Argument(help="Coupled file.")],
    settings: DesignValues = None,
    out: Annotated[Path | None, typer.Option(help="Write motion.csv, injury.json and motion.svg here.")] = None,
    extrapolate: Extrapolate = False,
) -> None:
    """Motion and injury metrics of the obstacle in one deployment. Without --set, list the parameters."""
    from billow.rom.coupled.coupled_evaluation import injury_record, write_motion
    from billow.rom.coupled.coupled_model import Coupled
    from billow.rom.surrogate.prediction import describe_surrogate

    coupled = Coupled.load(coupled_file)
    if not settings:
        print(describe_surrogate(coupled.surrogate))
        return
    from billow.injury.criteria import assess
    from billow.results.ownership import owned

    motion = coupled.deploy(parse_settings(settings), extrapolate=extrapolate)
    found = injury_record(assess(motion.times, motion.velocity))
    print(
        f"{coupled.impactor.name}: HIC15 {found['hic15']:.1f}, HIC36 {found['hic36']:.1f}, 3 ms clip "
        f"{found['clip_3ms_g']:.1f} g, peak {found['peak_g']:.1f} g, speed at the end {motion.velocity[-1, 2]:.2f} m/s"
    )
    if out is not None:
        with owned(out):
            write_motion(motion, coupled.impactor.name, out)
        print(f"{out}: motion.csv, injury.json, motion.svg")
