"""A study that grows until it is good enough: runs are added where the model is least certain, in batches."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from billow.base.errors import InputError
from billow.base.units import CONVERSIONS
from billow.design.surfaces import ResponseSurfaces
from billow.results.dataset import Dataset
from billow.rom.judge.errors import fit_learning_curve
from billow.rom.surrogate.design_space import from_unit, levelled, to_unit
from billow.study.drive import StudySummary
from billow.study.study import Study

NO_AIM = InputError.declare(
    "E-DES-050",
    "--until {text!r} cannot be used",
    where="billow study",
    cause="a misspelt response, or a unit that is not the response's",
    remedy='write for example "rmse < 3 mm", for the moving bag, or "hic15 < 40", for the rmse of a response',
)
FIELD = "rmse"
"""Name of the error of the moving bag."""
BATCH, MOST_RUNS = 8, 400
LEVEL_STAGES = 5
"""Last stages that show whether the error still falls."""
CANDIDATES = 1_024
_AIM = re.compile(r"\s*([A-Za-z][A-Za-z0-9_]*)\s*<\s*([0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(\S.*)?")


@dataclass(frozen=True)
class Aim:
    """name: of a response, or `FIELD`; limit: its rmse on runs held out is to be below it, in `unit`."""

    name: str
    limit: float
    unit: str

    @classmethod
    def read(cls, text: str) -> Aim:
        """From "rmse < 3 mm" or "hic15 < 40". InputError E-DES-050."""
        found = _AIM.fullmatch(text)
        if found is None or not float(found[2]) > 0.0:
            raise NO_AIM(text=text, why="it is no name, <, and a number above zero")
        aim = cls(found[1], float(found[2]), (found[3] or "").strip())
        if aim.name == FIELD and (aim.unit or "m") not in CONVERSIONS["m"]:
            raise NO_AIM(text=text, why=f"{aim.unit!r} is no unit of length")
        return aim

    @property
    def suffix(self) -> str:
        """The unit after a number, with a space before it."""
        return f" {self.unit}" if self.unit else ""


@dataclass(frozen=True)
class Stage:
    """runs: learned from; error: rmse on runs held out, in the aim's unit."""

    runs: int
    error: float


@dataclass(frozen=True)
class Growth:
    """stages: passed, in order; reached: whether the last is below the aim; why: else, why no more runs were added;
    summary: of the study after the last batch, None if none was needed."""

    stages: list[Stage]
    reached: bool
    why: str
    summary: StudySummary | None


def grow(
    folder: str | Path,
    aim: Aim,
    hours: float = np.inf,
    say: Callable[[str], None] | None = None,
    **running,
) -> Growth:
    """Add batches of runs to a study whose runs are made, until the error of `aim` is reached.

    It also ends after `hours`, with `MOST_RUNS` training runs, or when the error is level (`out_of_reach`).
    say: called with a line for each stage; running: as `Study.run`. InputError E-DES-050: the study has no such
    response, or it is in another unit.
    """
    begun, stages, summary = time.monotonic(), [], None
    while True:
        study = Study.open(folder)
        error, choose = _judged(study, aim)
        stages.append(Stage(len(Dataset.open(folder).trusted), error))
        if say is not None:
            say(f"{stages[-1].runs} runs: {aim.name} {error:.4g}{aim.suffix}, wanted below {aim.limit:g}{aim.suffix}")
        if error < aim.limit:
            return Growth(stages, True, "", summary)
        if why := _enough(time.monotonic() - begun, hours, len(study.train)) or out_of_reach(stages, aim):
            return Growth(stages, False, why, summary)
        known = len(study.runs)
        for row in choose(np.array(list(study.runs.values()))):
            values = tuple(v.stepped(value) for v, value in zip(study.definition.variables, row, strict=True))
            study, _ = study.with_run(values)
        if len(study.runs) == known:
            why = "no other design fulfils the constraints and keeps to the steps of the study"
            return Growth(stages, False, why, summary)
        summary = study.run(**running)


def _enough(seconds: float, hours: float, train: int) -> str:
    """Why no batch is added however the error goes, empty while one may be."""
    if seconds > 3600.0 * hours:
        return f"{hours:g} hours are over"
    return f"it has {train} training runs, and no more than {MOST_RUNS} are made" if train + BATCH > MOST_RUNS else ""


def out_of_reach(stages: list[Stage], aim: Aim) -> str:
    """Why the aim cannot be reached, empty while it may be: a power law through the last `LEVEL_STAGES` stages needs
    more than `MOST_RUNS` runs, or does not fall."""
    last = stages[-LEVEL_STAGES:]
    curve = fit_learning_curve([stage.runs for stage in last], [stage.error for stage in last])
    if len(last) < LEVEL_STAGES or curve is None:
        return ""
    needed = (curve.scale / aim.limit) ** (1.0 / curve.rate) if curve.rate > 0.0 else np.inf
    if needed <= MOST_RUNS:
        return ""
    told = f"about {needed:.2g} runs would be needed" if needed < 1e9 else "it does not fall"
    return f"the error is level: by the last {LEVEL_STAGES} stages {told}; narrow the ranges, or loosen the aim"


def _judged(study: Study, aim: Aim):
    """Error of the aim, and what chooses the next designs from those known."""
    if aim.name == FIELD:
        return _of_field(study, aim)
    surfaces = ResponseSurfaces.train(study)
    if aim.name not in surfaces.names:
        raise NO_AIM(text=aim.name, why=f"responses are {', '.join(surfaces.names)}; of the moving bag it is {FIELD}")
    unit = surfaces.unit(aim.name)
    if aim.unit not in ("", unit) and not (aim.unit == "-" == unit):
        raise NO_AIM(text=f"{aim.name} < {aim.limit:g} {aim.unit}", why=f"it is in {unit}")
    surface = surfaces.surfaces[surfaces.index(aim.name)]
    if surface.process is None:
        raise NO_AIM(text=aim.name, why=surface.verdict.why)

    def choose(known: np.ndarray) -> np.ndarray:
        return spread_out(lambda unit: surface.process.predict(unit)[1], known, surfaces.parameters,
                          study.definition.drawable)  # fmt: skip

    return surface.verdict.rmse, choose


def _of_field(study: Study, aim: Aim):
    from billow.rom.learn.suggest import suggest
    from billow.rom.learn.train import train

    surrogate, drawable = train(study.dataset()), study.definition.drawable
    surrogate.save(study.folder / "surrogate.safetensors")
    millimetres = surrogate.judgement.comparisons[0].own if surrogate.judgement else np.inf
    unit = CONVERSIONS["m"][aim.unit or "m"]
    return 1e-3 * millimetres / unit, lambda known: suggest(surrogate, BATCH, known, seed=len(known), drawable=drawable)


def spread_out(
    uncertain: Callable[[np.ndarray], np.ndarray],
    known: np.ndarray,
    parameters,
    drawable: Callable[[np.ndarray], np.ndarray] = np.asarray,
) -> np.ndarray:
    """The next designs, (BATCH, parameters): one after the other the candidate with the largest deviation times
    distance to the nearest design known or chosen; fewer if there are no others. uncertain: (designs, parameters) in
    [0, 1] -> (designs,); drawable: as in `suggest`."""
    from scipy.stats import qmc

    points = levelled(qmc.Sobol(len(parameters), rng=np.random.default_rng(len(known))).random(CANDIDATES), parameters)
    designs = drawable(from_unit(points, parameters))
    points = to_unit(designs, parameters)
    weight = uncertain(points)
    nearest = np.min([np.linalg.norm(points - one, axis=1) for one in to_unit(known, parameters)], axis=0)
    chosen = []
    for _ in range(min(BATCH, len(points))):
        chosen.append(int((weight * nearest).argmax()))
        nearest = np.minimum(nearest, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return designs[chosen]


def learning_curve(stages: list[Stage], aim: Aim) -> Figure:
    """Error on runs held out against the number of runs, and where it was to end."""
    from billow.base.plot_style import GREY
    from billow.rom.judge.figures import plain_log

    figure = Figure(figsize=(5.0, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.loglog([s.runs for s in stages], [s.error for s in stages], "o-", color="#0072b2")
    axes.axhline(aim.limit, color=GREY, ls="--")
    axes.annotate(f"wanted: {aim.limit:g}{aim.suffix}", (stages[0].runs, aim.limit), color=GREY, va="bottom")
    axes.set(xlabel="training runs", ylabel=f"error of runs held out, {aim.name} [{aim.unit or '-'}]")
    for axis, limits in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        plain_log(axis, limits)
    return figure
