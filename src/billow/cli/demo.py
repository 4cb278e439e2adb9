"""A small study from start to report: the ROM paper's first test case, from design parameters to a tested surrogate."""

from __future__ import annotations

import time
from pathlib import Path

from rich.console import Console

from billow.base.errors import InputError
from billow.results.atomic import write_atomically

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

STUDY = """\
# Latin hypercube over the six parameters of Table 1 of the ROM paper.
title = "Airbag deployment against a locked obstacle"
case = "case.toml"
seed = 1
train = {train}
test = {test}
reference_length = 0.28

[[parameters]]
name = "permeability"
label = "Airbag permeability"
unit = "-"
low = 0.02
high = 0.035
keys = ["fabric.permeability"]

[[parameters]]
name = "inflator_temperature"
label = "Inflator temperature"
unit = "K"
low = 500.0
high = 800.0
keys = ["inflator.temperature"]

[[parameters]]
name = "jet_direction"
label = "Jet direction"
unit = "deg"
low = 30.0
high = 60.0
keys = ["inflator.jets.angle"]

[[parameters]]
name = "impactor_radius"
label = "Impactor radius"
unit = "m"
low = 0.1
high = 0.25
keys = ["obstacles.impactor.radii"]

[[parameters]]
name = "impactor_degree"
label = "Ellipsoid degree"
unit = "-"
low = 2.0
high = 4.5
keys = ["obstacles.impactor.degree"]

[[parameters]]
name = "contact_slope"
label = "Contact characteristic slope"
unit = "N/m"
low = 1000.0
high = 1e6
keys = ["obstacles.impactor.slope"]
"""


def write_definition(folder: Path, train: int, test: int) -> Path:
    """Write case.toml and study.toml into `folder`, unless they are there; returns the study's path.

    Raises InputError E-CLI-002 if the folder holds something else.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (("case.toml", CASE), ("study.toml", STUDY.format(train=train, test=test))):
        path = folder / name
        if path.exists() and path.read_text(encoding="utf-8") != text:
            raise OTHER_DEMO(path=path)
        write_atomically(path, text)
    return folder / "study.toml"


def run_demo(folder: Path, train: int, test: int, workers: int | None, console: Console) -> Path:
    """Simulate, train, evaluate; returns the path of the report. May be interrupted and started again."""
    from billow.cli.terminal import epochs, steps
    from billow.rom.judge.evaluate import evaluate
    from billow.rom.judge.report import write_report
    from billow.rom.learn.left_out import left_out
    from billow.rom.learn.train import train as learn
    from billow.study.progress import study_progress
    from billow.study.study import Study

    begun = time.perf_counter()
    definition = write_definition(folder, train, test)
    study = Study.create(definition, folder / "study")
    console.print(f"1/3 simulating {len(study.runs)} deployments (kernels are compiled at the first one, about 20 s)")
    with study_progress(console) as report:
        study.run(workers=workers, progress=report)
    dataset = study.dataset()
    lost = left_out(dataset, dataset.trusted)
    note = f" ({len(lost.why)} left out: {lost.reasons()})" if lost.why else ""
    console.print(f"2/3 training on {len(dataset.trusted)} runs{note}")
    with epochs(console, "training") as progress:
        surrogate = learn(dataset, progress=progress)
    surrogate.save(folder / "surrogate.safetensors")
    console.print(f"3/3 evaluating on {len(dataset.test)} unseen runs")
    with steps(console) as progress:
        evaluation = evaluate(dataset, surrogate, progress=progress)
    path = write_report(dataset, evaluation, folder)
    console.print(f"done in {time.perf_counter() - begun:.0f} s: {path}")
    return path
