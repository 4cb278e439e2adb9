"""Accuracy of a surrogate on unseen runs, compared with simpler answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from billow.base.blas_threads import one_blas_thread
from billow.base.errors import InputError
from billow.results.dataset_files import fingerprint, same_times
from billow.results.floor_file import Floor
from billow.rom.judge import errors
from billow.rom.judge.timing import Timing, measure, training_seconds
from billow.rom.judge.unseen import UnseenRuns, unseen_runs
from billow.rom.learn.dataset import Dataset, read_run
from billow.rom.learn.left_out import LeftOut, left_out
from billow.rom.learn.progress import Announcement, Announcer
from billow.rom.learn.reduction import DEFAULT_MEMORY, reduce_runs
from billow.rom.learn.side_by_side import side_by_side
from billow.rom.learn.simple_answers import (
    BASELINES,
    MEAN_TRAJECTORY,
    NEAREST_RUN,
    RADIAL_BASIS,
    comparisons,
    nearest,
    radial_basis,
)
from billow.rom.learn.train import Recipe, import_network, same_training, train_networks, unvaried
from billow.rom.surrogate.basis import Basis, Z
from billow.rom.surrogate.design_space import distinct, neighbour_distances, to_unit
from billow.rom.surrogate.judgement import UNSEEN, Judgement
from billow.rom.surrogate.surrogate import Surrogate

OTHER_DATASET = InputError.declare(
    "E-ROM-012",
    "the surrogate was not trained on this dataset",
    where="{title}",
    cause="a surrogate of another study, or of an earlier state of this one",
    remedy="evaluate it with its own dataset, or train one on this: billow train FOLDER",
)
Predict = Callable[[np.ndarray], np.ndarray]
"""As `Surrogate.predict`: the displacement [m], (times, nodes, 3), of one design (parameters,) at the trained times."""

SWEEP_MODES = (1, 2, 4, 6, 8, 10, 12, 16)


@dataclass(frozen=True, eq=False)
class SweepModel:
    """One model of the learning curve, not calibrated, so that all it answers is believed: number of training runs,
    [s] that making them (`generation`) and learning from them took, errors on the unseen runs with several numbers of
    modes."""

    runs: int
    generation: float
    training: float
    errors: errors.ErrorsByModes


@dataclass(frozen=True)
class Coverage:
    """Where the unseen designs lie among the trained ones; distances with every range scaled to [0, 1].

    nearest: [-], (test runs,), from each unseen design to the nearest training design
    between: [-], mean of the same distance among the training designs themselves
    ranges: [-], (parameters,), part of each parameter's range that lies between the training designs' extremes
    """

    nearest: np.ndarray
    between: float
    ranges: np.ndarray


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Everything measured on unseen runs.

    surrogate: what was judged; unseen: by which runs; design: theirs, (runs, parameters)
    errors: [m], name -> (runs, times, 3) float64, RMSE of each snapshot's components (inside paper equation 5) for
        "surrogate", "truncation" (the best any coefficients could do), "regression" (coefficients predicted instead of
        known; truncation^2 + regression^2 = surrogate^2) and each of `BASELINES`
    spread: [m], (runs, times, 3), disagreement of the ensemble; None without one
    intervals: how many unseen values the intervals of each level hold; empty without calibration
    sweep: against training runs and modes
    missing: runs of the design that are not there -> why; left_out: training runs that were not learned from
    ledgers: run -> balance errors from its record, of all runs that kept one
    floor: how far runs are off when they are made again, which no model can beat; None if nobody measured it
    """

    surrogate: Surrogate
    reference_length: float
    unseen: UnseenRuns
    missing: dict[str, str]
    left_out: LeftOut
    design: np.ndarray
    errors: dict[str, np.ndarray]
    spread: np.ndarray | None
    intervals: tuple[errors.IntervalCheck, ...]
    sweep: tuple[SweepModel, ...]
    coverage: Coverage
    timing: Timing
    ledgers: dict[str, dict[str, float]]
    floor: Floor | None = None

    def over_floor(self, component: int) -> float | None:
        """Mean RMSE of a component over that of the floor: [-]; None without a floor, or one of zero."""
        floor = 0.0 if self.floor is None else float(self.floor.means[component])
        return self.summary("surrogate", component).mean / floor if floor else None

    def summary(self, name: str, component: int) -> errors.Summary:
        """Distribution of one kind of error over unseen runs and times."""
        return errors.Summary.of(self.errors[name][:, :, component])

    def regression_share(self, component: int) -> float:
        """Part of the squared error that is regression, not truncation: [-]; 0 in a component that never moves."""
        regression, total = (np.square(self.errors[n][:, :, component]).sum() for n in ("regression", "surrogate"))
        return regression / total if total else 0.0

    @property
    def test(self) -> tuple[str, ...]:
        """The unseen runs, in the order of everything else."""
        return self.unseen.runs

    @property
    def judgement(self) -> Judgement:
        """The surrogate beside `BASELINES`, by the distance of nodes, all components together."""
        squares = {name: np.square(self.errors[name]).mean(axis=1).sum(axis=1) for name in ("surrogate", *BASELINES)}
        own, *others = (float(np.sqrt(of_run).mean()) for of_run in squares.values())
        return Judgement(UNSEEN, len(self.test), comparisons(own, dict(zip(BASELINES, others, strict=True))))

    def learning_curve(self, component: int) -> errors.LearningCurve | None:
        """Mean RMSE against training runs, from the models of the sweep with the surrogate's own number of modes."""
        rows = [int(np.abs(np.array(model.errors.counts) - self.surrogate.modes).argmin()) for model in self.sweep]
        means = [model.errors.summary(component, row).mean for model, row in zip(self.sweep, rows, strict=True)]
        return errors.fit_learning_curve([model.runs for model in self.sweep], means)

    def typical_and_worst(self) -> tuple[str, str]:
        """The unseen runs with the median and the largest mean z RMSE."""
        order = self.errors["surrogate"][:, :, Z].mean(axis=1).argsort()
        return self.test[order[(len(order) - 1) // 2]], self.test[order[-1]]


def evaluate(
    dataset: Dataset,
    surrogate: Surrogate,
    *,
    sizes: tuple[int, ...] | None = None,
    modes: tuple[int, ...] = SWEEP_MODES,
    memory: int = DEFAULT_MEMORY,
    progress: Announcement | None = None,
) -> Evaluation:
    """Predict every unseen run of a dataset and compare.

    sizes: numbers of training runs (the first ones of the surrogate's own) for which another model is trained with the
        same recipe and epochs; default a quarter, half and all for `shared`, as far as they vary every parameter, none
        for `paper`, which takes hours
    modes: numbers of modes to report for each size, as `ErrorsByModes`
    memory: [byte] for the models of `sizes`, as `Recipe`; all else reads one run at a time

    Raises InputError E-ROM-012 if surrogate and dataset do not belong together, E-ROM-015 without unseen runs, and the
    errors of `train`.
    """
    _require_match(dataset, surrogate)
    surrogate, judged_by = surrogate.despite_verdict(), unseen_runs(dataset)
    test = judged_by.runs
    if sizes is None:
        count = len(surrogate.runs)
        sizes = tuple(sorted({count // 4, count // 2, count})) if surrogate.recipe == "shared" else ()
        sizes = tuple(size for size in sizes if size > 1 and not unvaried(dataset, surrogate.runs[:size]))
    if sizes:
        import_network()  # before the work that needs none
    announce = Announcer(progress, 2 + len(sizes))
    announce(f"comparing with {len(test)} unseen runs and simple answers")
    unseen = np.asarray(dataset.design(test), float)
    rmse = _errors(dataset, surrogate, test)
    spread = surrogate.spread(unseen) if surrogate.regression.members > 1 else None
    intervals = errors.check_intervals(surrogate, dataset, test)
    sweep = _sweep(dataset, surrogate, sizes, test, modes, memory, announce)
    announce("measuring times")
    return Evaluation(
        surrogate=surrogate,
        reference_length=float(dataset.reference_length),
        unseen=judged_by,
        missing=dict(dataset.missing),
        left_out=left_out(dataset, surrogate.runs),
        design=unseen,
        errors=rmse,
        spread=spread,
        intervals=intervals,
        sweep=tuple(sweep),
        coverage=_coverage(surrogate.parameters, np.asarray(dataset.design(surrogate.runs), float), unseen),
        timing=measure(dataset, surrogate),
        ledgers=_ledgers(dataset, (*surrogate.runs, *test)),
        floor=getattr(dataset, "floor", None),
    )


def _same_mesh(dataset, surrogate) -> bool:
    own = getattr(dataset, "own_starts", False)
    return fingerprint(dataset.reference, dataset.triangles, own) == surrogate.training["mesh_sha256"]


def _require_match(dataset, surrogate):
    names = [parameter.name for parameter in dataset.parameters]
    if names != [parameter.name for parameter in surrogate.parameters]:
        why = f"the dataset varies {', '.join(names)}"
    elif not _same_mesh(dataset, surrogate):
        why = "their start meshes differ"
    elif not same_times(dataset.times, surrogate.times):
        why = "their times differ"
    elif not set(surrogate.runs) <= set(dataset.train):
        why = "it was trained on runs that are not training runs of this dataset"
    else:
        return
    raise OTHER_DATASET(title=surrogate.title or "surrogate", why=why)


def _errors(dataset, surrogate, test) -> dict[str, np.ndarray]:
    """As in `Evaluation`, from one pass over the unseen runs."""
    answers = {"surrogate": surrogate.predict} | baselines(dataset, surrogate.runs, surrogate.bases)
    designs = dataset.design(test)
    rmse = {name: [] for name in answers}

    def compared():
        for run, design in zip(test, designs, strict=True):
            truth = read_run(dataset, run)
            for name, predict in answers.items():
                rmse[name].append(errors.snapshot_rmse(predict(design), truth))
            yield truth

    seen = errors.project(compared(), surrogate.bases)
    regression = seen.regression(surrogate.coefficients(designs), surrogate.modes)
    parts = {"truncation": seen.truncation(surrogate.modes), "regression": regression}
    return {name: np.array(values) for name, values in rmse.items()} | parts


def _sweep(dataset, surrogate, sizes, test, modes, memory, announce: Announcer) -> list[SweepModel]:
    """Models of the first so many runs, trained side by side."""
    found, reductions, seed = [], [], same_training(surrogate)["seed"]

    def trainings():
        for size in reversed(sizes):  # what takes longest begins first
            announce(f"training on {size} runs")
            runs = surrogate.runs[:size]
            most = max(_possible(modes, surrogate, runs))
            with one_blas_thread():  # bits must not depend on who trains meanwhile
                reductions.append(reduce_runs(dataset, runs, most, seed, memory))
            recipe = Recipe(surrogate.recipe, most, calibrate=False, memory=memory, **same_training(surrogate))
            yield partial(train_networks, dataset, reductions[-1], recipe, None)

    if not sizes:
        return []
    with import_network().one_thread():
        models = list(side_by_side(trainings(), 0, len(sizes), None))
    for size, model in zip(sizes, reversed(models), strict=True):
        runs = surrogate.runs[:size]
        unseen = errors.project((read_run(dataset, run) for run in test), model.bases)
        by_modes = errors.ErrorsByModes.of(
            _possible(modes, surrogate, runs), unseen, model.coefficients(dataset.design(test))
        )
        generation, training = float(np.sum(dataset.computing_seconds(runs))), sum(training_seconds(model).values())
        found.append(SweepModel(size, generation, training, by_modes))
    return found


def _possible(modes, surrogate, runs) -> tuple[int, ...]:
    """Numbers of modes that some runs can have."""
    return tuple(count for count in modes if count <= min(surrogate.nodes, len(runs) * len(surrogate.times)))


def _coverage(parameters, seen: np.ndarray, unseen: np.ndarray) -> Coverage:
    seen = seen[[group[0] for group in distinct(seen, parameters)]]
    seen, unseen = to_unit(seen, parameters), to_unit(unseen, parameters)
    between = float(neighbour_distances(seen).mean()) if len(seen) > 1 else float("nan")
    nearest = np.linalg.norm(unseen[:, None] - seen[None], axis=2).min(axis=1)
    return Coverage(nearest, between, seen.max(axis=0) - seen.min(axis=0))


def _ledgers(dataset, runs) -> dict[str, dict[str, float]]:
    """Balance errors of runs whose records hold them; datasets made by other solvers may have none."""
    ledgers = {run: dataset.result(run).record.get("ledger") or {} for run in runs}
    numbers = {run: {n: float(v) for n, v in of.items() if isinstance(v, int | float)} for run, of in ledgers.items()}
    return {run: ledger for run, ledger in numbers.items() if ledger}


def baselines(dataset: Dataset, runs: tuple[str, ...], bases: tuple[Basis, ...]) -> dict[str, Predict]:
    """The answers `BASELINES`, made from `runs`, which are read once, one after the other; none holds more than a run.

    The mean of all runs at each time, whatever the design; the run of the nearest design, every parameter's range
    counting as one; `radial_basis` in `bases`, the reduced bases of x, y and z.
    Raises InputError E-ROM-009 if a run holds a value that is not finite.
    """
    total, trajectories = 0.0, []
    for run in runs:
        shape = read_run(dataset, run)
        total = total + shape.astype(float)
        trajectories.append(np.stack([shape[:, :, c] @ basis.modes.T for c, basis in enumerate(bases)], axis=1))
    mean = (total / len(runs)).astype(np.float32)
    designs = np.asarray(dataset.design(runs), float)
    known, parameters = to_unit(designs, dataset.parameters), dataset.parameters
    radial = radial_basis(designs, np.stack(trajectories), parameters)

    def by_radial_basis(design):
        found = radial(design)
        return np.stack([basis.fields(found[:, c].T) for c, basis in enumerate(bases)]).transpose(2, 1, 0)

    return {
        MEAN_TRAJECTORY: lambda design: mean,
        NEAREST_RUN: lambda design: read_run(dataset, runs[nearest(known, to_unit(design, parameters))]),
        RADIAL_BASIS: by_radial_basis,
    }
