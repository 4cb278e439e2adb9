"""`billow train | evaluate | predict | suggest | export`: a surrogate from a study to its answers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from billow.cli.endings import interruptible
from billow.cli.options import (
    DesignValues,
    DespiteVerdict,
    Extrapolate,
    Memory,
    Settings,
    StudyFolder,
    SurrogateFile,
    SurrogateOption,
    Threads,
    make_console,
    memory_bytes,
    parse_settings,
    steps,
)
from billow.cli.options import epochs as show_epochs


def train(
    folder: StudyFolder,
    out: Annotated[Path | None, typer.Option(help="Surrogate file (default: STUDY/surrogate.safetensors).")] = None,
    recipe: Annotated[str, typer.Option(help="shared: one network for all modes; paper: one per mode.")] = "shared",
    modes: Annotated[int, typer.Option(min=1, help="Modes of each displacement component (K).")] = 12,
    runs: Annotated[int | None, typer.Option(min=2, help="Use only this many training runs, the first ones.")] = None,
    epochs: Annotated[int | None, typer.Option(min=1, help="Epochs (default: the recipe's).")] = None,
    seed: Annotated[int, typer.Option(help="Seed of basis and networks.")] = 0,
    memory: Memory = 4.0,
) -> None:
    """Train a surrogate on the training runs of a study."""
    from billow.results.dataset import Dataset
    from billow.results.ownership import owned_file
    from billow.results.tensor_file import SIGN as TENSORS
    from billow.rom.learn.left_out import left_out
    from billow.rom.learn.train import Recipe, check_recipe, import_network, of_one_design
    from billow.rom.learn.train import train as learn
    from billow.rom.surrogate.prediction import describe_judgement

    import_network()
    how = Recipe(recipe, modes, seed, epochs, memory=memory_bytes(memory, "train"))
    check_recipe(how)
    console = make_console()
    dataset = Dataset.open(folder)
    lost = left_out(dataset, dataset.trusted)
    if lost.why:
        console.print(f"{len(lost.why)} training runs are left out: {lost.reasons()}")
    for group in of_one_design(dataset, dataset.trusted):
        if len(group) > 1:
            console.print(f"runs {', '.join(group[:9])} have one design: to judge the surrogate they count as one run")
    out = out or folder / "surrogate.safetensors"
    with owned_file(out, TENSORS), show_epochs(console, "training") as progress:
        surrogate = learn(dataset, how, runs=dataset.trusted[:runs], progress=progress)
        path = surrogate.save(out)
    seconds = surrogate.training["pod_seconds"] + surrogate.training["network_seconds"]
    console.print(f"{path}: trained on {len(surrogate.training['runs'])} runs in {seconds:.1f} s")
    console.print(describe_judgement(surrogate.judgement, "billow evaluate STUDY"))
    _say_floors(console, surrogate.judgement, dataset.floor)


def floor(
    folder: StudyFolder,
    designs: Annotated[int, typer.Option(min=1, help="Designs to run again.")] = 5,
    settings: Settings = None,
    threads: Threads = None,
) -> None:
    """Measure how far runs of a study are off when they are made again with a change that means nothing.

    By default with a step 1 % shorter, and of particles with another seed; --set KEY=VALUE for another change. Writes
    STUDY/floor.json and floor.csv; `billow train` and `billow evaluate` then also say the error in floors.
    """
    from billow.study.floor import measure_floor

    console = make_console()
    with interruptible("finished runs are kept; the same command continues", folder):
        found = measure_floor(folder, designs, parse_settings(settings), console.print, threads)
    told = ", ".join(f"{axis} {1e3 * mean:.3g}" for axis, mean in zip("xyz", found.means, strict=True))
    nodes = f"{1e3 * found.distance:.3g} mm over nodes"
    console.print(
        f"{folder / 'floor.json'}: no model can be closer than {told} mm, {nodes}, by {len(found.runs)} designs"
    )


def _say_floors(console, judgement, floor) -> None:
    """The error of a surrogate in floors, where both are known."""
    if judgement is not None and floor is not None and floor.distance > 0.0:
        own = 1e-3 * judgement.comparisons[0].own
        console.print(f"error / floor: {own / floor.distance:.1f}; no model can be below 1")


def evaluate(
    folder: StudyFolder,
    surrogate_file: SurrogateOption = None,
    out: Annotated[Path | None, typer.Option(help="Report folder (default: STUDY/report).")] = None,
    memory: Memory = 4.0,
) -> None:
    """Test a surrogate on the unseen runs of its study; writes report.html, metrics.json and figures.

    The surrogate file keeps the verdict, and says it with every answer.
    """
    from dataclasses import replace

    from billow.pages.explorer import explorer_in_report
    from billow.results.dataset import Dataset
    from billow.results.ownership import owned, owned_file
    from billow.results.tensor_file import SIGN as TENSORS
    from billow.rom.judge.evaluate import evaluate as measure
    from billow.rom.judge.report import write_report
    from billow.rom.surrogate.prediction import describe_judgement
    from billow.rom.surrogate.surrogate import Surrogate

    console, held = make_console(), memory_bytes(memory, "evaluate")
    dataset = Dataset.open(folder)
    path, out = surrogate_file or folder / "surrogate.safetensors", out or folder / "report"
    surrogate = Surrogate.load(path)
    with owned(out), steps(console) as progress:
        evaluation = measure(dataset, surrogate, memory=held, progress=progress)
        judged = replace(surrogate, judgement=evaluation.judgement)
        with owned_file(path, TENSORS):
            judged.save(path)
        report = write_report(dataset, evaluation, out, explorer_in_report(judged, path))
    console.print(describe_judgement(evaluation.judgement, "billow evaluate STUDY"))
    _say_floors(console, evaluation.judgement, evaluation.floor)
    console.print(f"report: {report}; {path} keeps the verdict")


def predict(
    surrogate_file: SurrogateFile,
    settings: DesignValues = None,
    out: Annotated[Path | None, typer.Option(help="Write the deployment as .vtkhdf (opens in ParaView).")] = None,
    extrapolate: Extrapolate = False,
    despite_verdict: DespiteVerdict = False,
) -> None:
    """Predict one deployment. Without --set, list the parameters and their trained ranges."""
    from billow.rom.surrogate.prediction import describe_surrogate, write_prediction
    from billow.rom.surrogate.surrogate import Surrogate

    surrogate = Surrogate.load(surrogate_file)
    if not settings:
        print(describe_surrogate(surrogate))
        return
    if despite_verdict:
        surrogate = surrogate.despite_verdict()
    print(write_prediction(surrogate, parse_settings(settings), out, extrapolate))


def suggest(
    folder: StudyFolder,
    out: Annotated[Path, typer.Option(help="Table of designs (CSV), for added_designs in study.toml.")],
    count: Annotated[int, typer.Option(min=1, help="Number of designs.")] = 8,
    surrogate_file: SurrogateOption = None,
) -> None:
    """Suggest the next training runs: designs where the surrogate is least certain and no run is near.

    OUT contains the designs added before, if any, and the new ones. Write added_designs = "OUT" into the study file and
    run the study command again: it makes the new runs.
    """
    from billow.results.atomic import write_atomically
    from billow.results.ownership import owned_file
    from billow.rom.learn.suggest import suggest as next_designs
    from billow.rom.surrogate.surrogate import Surrogate
    from billow.study.grow import added_designs_text, read_added_designs
    from billow.study.study import ADDED_FILE, Study

    study = Study.open(folder)
    surrogate = Surrogate.load(surrogate_file or folder / "surrogate.safetensors")
    added = []
    if study.definition.added_designs is not None:
        added = read_added_designs(folder / ADDED_FILE, study.definition.axes)
    with owned_file(out, added_designs_text(study.definition.axes, []).encode()):
        known, drawable = list(study.runs.values()), study.definition.drawable
        rows = next_designs(surrogate, count, known, seed=len(study.runs), drawable=drawable)
        write_atomically(out, added_designs_text(study.definition.axes, [*added, *rows.tolist()]))
    print(f"{out}: {len(added)} designs added before, {count} new ones")
    print(f'next: write added_designs = "{out.name}" into the study file, and run the study command again')


def export(
    surrogate_file: SurrogateFile,
    out: Annotated[Path, typer.Option(help="ONNX file, such as surrogate.onnx.")],
    despite_verdict: DespiteVerdict = False,
) -> None:
    """Write a surrogate as ONNX: from a design to the displacement of every node at every trained time.

    Needs the packages onnx and onnxruntime; the file is checked against NumPy before it is written.
    """
    from billow.results.ownership import owned_file
    from billow.rom.surrogate.onnx_export import export_onnx
    from billow.rom.surrogate.surrogate import Surrogate

    surrogate = Surrogate.load(surrogate_file)
    if despite_verdict:
        surrogate = surrogate.despite_verdict()
    with owned_file(out, b"billow"):  # the name of its producer
        difference = export_onnx(surrogate, out)
    print(f"{out}: predictions differ from NumPy's by at most {difference:.1e} of the largest displacement")
