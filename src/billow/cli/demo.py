"""A small study from start to report: the ROM paper's first test case, from design parameters to a tested surrogate."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from billow.base.errors import InputError
from billow.cli.options import epochs, steps
from billow.results.atomic import write_atomically
from billow.results.ownership import owned

OTHER_DEMO = InputError.declare(
    "E-CLI-002",
    "the folder holds another demo",
    where="{path}",
    why="it differs from what this command would write",
    cause="the file was changed, or the demo was made with other options",
    remedy="choose another folder with --out, or delete this one",
)

CASE = """\
# Driver bag with straps of 0.28 m on a rigid plate, unfolded, against a locked super-ellipsoid obstacle with a
# force-based contact characteristic (ROM paper, first test case). Every key and default: docs/case.md.
title = "Driver bag against a locked obstacle"

[bag]
diameter = 0.70
element_size = 0.020

[bag.straps]
length = 0.28

[[obstacles]]
shape = "plate"

[[obstacles]]
shape = "super-ellipsoid"
name = "impactor"
clearance = 0.15
locked = true
"""

PARAMETER = """
[[parameters]]
name = "{}"
label = "{}"
unit = "{}"
low = {}
high = {}
keys = ["{}"]
"""

PARAMETERS = (
    ("permeability", "Airbag permeability", "-", "0.02", "0.035", "fabric.permeability"),
    ("inflator_temperature", "Inflator temperature", "K", "500.0", "800.0", "inflator.temperature"),
    ("jet_direction", "Jet direction", "deg", "30.0", "60.0", "inflator.jets.angle"),
    ("impactor_radius", "Impactor radius", "m", "0.1", "0.25", "obstacles.impactor.radii"),
    ("impactor_degree", "Ellipsoid degree", "-", "2.0", "4.5", "obstacles.impactor.degree"),
    ("contact_slope", "Contact characteristic slope", "N/m", "1000.0", "1e6", "obstacles.impactor.slope"),
)  # name, label, unit, low, high, and the key of the case

STUDY = """\
# Latin hypercube over the six parameters of Table 1 of the ROM paper.
title = "Airbag deployment against a locked obstacle"
case = "case.toml"
seed = 1
train = {train}
test = {test}
reference_length = 0.28
""" + "".join(PARAMETER.format(*row) for row in PARAMETERS)


def run_demo(folder: Path, train: int, test: int, workers: int | None, console: Console) -> None:
    """Simulate, train, evaluate. May be interrupted and started again.

    Raises InputError E-CLI-002 if the folder holds something else, ResourceError E-ROM-006 without PyTorch.
    """
    from billow.pages.explorer import explorer_in_report
    from billow.rom.judge.evaluate import evaluate
    from billow.rom.judge.report import write_report
    from billow.rom.learn.left_out import left_out
    from billow.rom.learn.train import import_network
    from billow.rom.learn.train import train as learn
    from billow.study.progress import study_progress
    from billow.study.study import Study

    import_network()  # before minutes of simulation
    begun = time.perf_counter()
    texts = {folder / "case.toml": CASE, folder / "study.toml": STUDY.format(train=train, test=test)}
    for path, text in texts.items():
        if path.exists() and path.read_text(encoding="utf-8") != text:
            raise OTHER_DEMO(path=path)
    with owned(folder, "study/study.toml"):
        for path, text in texts.items():
            write_atomically(path, text)
        study = Study.create(folder / "study.toml", folder / "study")
        console.print(
            f"1/3 simulating {len(study.runs)} deployments (the first one compiles kernels, about 20 s, unless an "
            "earlier run has)"
        )
        with study_progress(console) as report:
            study.run(workers=workers, progress=report)
        dataset = study.dataset()
        lost = left_out(dataset, dataset.trusted)
        note = f" ({len(lost.why)} left out: {lost.reasons()})" if lost.why else ""
        console.print(f"2/3 training on {len(dataset.trusted)} runs{note}")
        with epochs(console, "training") as progress:
            surrogate = learn(dataset, progress=progress)
        file = surrogate.save(folder / "surrogate.safetensors")
        console.print(f"3/3 evaluating on {len(dataset.test)} unseen runs")
        with steps(console) as progress:
            evaluation = evaluate(dataset, surrogate, progress=progress)
        judged = replace(surrogate, judgement=evaluation.judgement)
        judged.save(file)
        path = write_report(dataset, evaluation, folder, explorer_in_report(judged, file))
        console.print(f"done in {time.perf_counter() - begun:.0f} s: {path}")
