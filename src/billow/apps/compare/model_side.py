"""What a surrogate, or a coupled model, says of a design, as one side of a comparison."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from billow.apps.compare.side import PredictedFabric, Side
from billow.base.errors import InputError
from billow.pictures.source import Source
from billow.results.dataset import Dataset
from billow.results.histories import TIME, History, column_names
from billow.rom.coupled.coupled_model import Coupled, load_if_coupled
from billow.rom.coupled.motion_errors import CURVES
from billow.rom.surrogate.surrogate import Surrogate

NO_DESIGN = InputError.declare(
    "E-CMP-001",
    "the design that a surrogate is asked for is not known",
    where="{path}",
    why="{other} is no run of a study with a design, and no values were given",
    remedy="give a run STUDY/runs/ID, or its design values: --set NAME=VALUE for each parameter",
)
UNITS = {"centre": "m", "velocity": "m/s", "acceleration": "m/s^2"}


def answer(path: Path, label: str, there: Side | None, design: Mapping[str, float] | None) -> Side:
    """What a surrogate, or a coupled model, says of a design, by default that of the run `there`. There is no verdict
    to heed: this is how one looks."""
    coupled = load_if_coupled(path)
    surrogate = (Surrogate.load(path) if coupled is None else coupled.surrogate).despite_verdict()
    values = _design(path, there, surrogate) if design is None else design
    positions = surrogate.start(values) + surrogate.predict(values)
    part, names = np.zeros(len(surrogate.triangles), np.int64), ["fabric"]
    if surrogate.parts is not None:
        part, names = surrogate.parts.part, list(surrogate.parts.names)
    if there is not None and there.fabric is not None and np.array_equal(there.fabric.triangles, surrogate.triangles):
        part, names = there.fabric.part, there.fabric.part_names
    fabric = PredictedFabric(path, surrogate.times, positions, surrogate.triangles, part, names)
    said = "not judged on unseen runs" if surrogate.judgement is None else str(surrogate.judgement)
    curves = None if coupled is None else _curves(coupled.despite_verdict(), values)
    return Side(Source(path, label, curves=curves), curves, fabric, said)


def _design(path: Path, there: Side, surrogate: Surrogate) -> dict[str, float]:
    """Values of the parameters of a run, by its place in a study."""
    folder = there.source.path.absolute()
    study = folder.parent.parent
    if folder.parent.name != "runs" or not (study / "design.csv").is_file():
        raise NO_DESIGN(path=path, other=there.source.path)
    dataset = Dataset.open(study)
    row = dataset.design([folder.name])[0]
    return dict(zip((parameter.name for parameter in dataset.parameters), row.tolist(), strict=True))


def _curves(coupled: Coupled, design: Mapping[str, float]) -> History:
    """Centre, velocity and acceleration of the impactor, named as in the histories of a run."""
    motion = coupled.deploy(design)
    columns = {TIME: motion.times}
    for quantity, unit in UNITS.items():
        names = column_names(coupled.impactor.name, quantity, unit, 3)
        columns |= zip(names, CURVES[quantity](motion).T, strict=True)
    return History(columns)
