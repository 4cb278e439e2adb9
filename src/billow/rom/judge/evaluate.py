"""How good a surrogate is on runs it has not seen, and what it is worth against simpler answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.results.dataset_files import Parameter, mesh_sha256, same_times
from billow.rom.judge.baselines import MeanTrajectory, NearestRun, RadialBasis, baselines
from billow.rom.judge.interval_check import IntervalCheck, check_intervals
from billow.rom.judge.learning_curve import LearningCurve, fit
from billow.rom.judge.projection import project
from billow.rom.judge.rmse import Summary, snapshot_rmse
from billow.rom.judge.timing import Timing, measure
from billow.rom.learn.left_out import LeftOut, left_out
from billow.rom.learn.reduction import DEFAULT_MEMORY
from billow.rom.learn.snapshots import read_run
from billow.rom.surrogate.standing import neighbour_distances, to_unit
from billow.rom.surrogate.surrogate import Surrogate

SWEEP_MODES = (1, 2, 4, 6, 8, 10, 12, 16)
BASELINES = (MeanTrajectory.name, NearestRun.name, RadialBasis.name)


@dataclass(frozen=True, eq=False)
class SweepModel:
    """One model of the learning curve, judged on the unseen runs after every number of modes in `modes`.

    runs: number of training runs; generation, training: [s] that making them and learning from them took
    summaries: one per number of modes, each of the components x, y, z
    truncation: [m], (modes, 3), mean RMSE that no regression could avoid
    """

    runs: int
    generation: float
    training: float
    modes: tuple[int, ...]
    summaries: tuple[tuple[Summary, Summary, Summary], ...]
    truncation: np.ndarray


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

    errors: [m], name -> (runs, times, 3) float64, RMSE of each snapshot's components (inside paper equation 5) for
        "surrogate", "truncation" (the best any coefficients could do), "regression" (coefficients predicted instead of
        known; truncation^2 + regression^2 = surrogate^2) and each of `BASELINES`
    spread: [m], (runs, times, 3), disagreement of the ensemble; None without one
    intervals: how many unseen values the intervals of each level hold; empty without calibration
    sweep: against training runs and modes; singular_values: [m], (3, values); energy: [-], (3, modes), kept fraction
    missing: runs of the design that are not there -> why; left_out: training runs that were not learned from
    ledgers: run -> balance errors from its record, of all runs that kept one
    """

    title: str
    recipe: str
    modes: int
    nodes: int
    triangles: int
    parameters: tuple[Parameter, ...]
    reference_length: float
    times: np.ndarray
    train: tuple[str, ...]
    test: tuple[str, ...]
    missing: dict[str, str]
    left_out: LeftOut
    design: np.ndarray
    errors: dict[str, np.ndarray]
    spread: np.ndarray | None
    intervals: tuple[IntervalCheck, ...]
    sweep: tuple[SweepModel, ...]
    singular_values: np.ndarray
    energy: np.ndarray
    coverage: Coverage
    timing: Timing
    ledgers: dict[str, dict[str, float]]
    training: dict

    def summary(self, name: str, component: int) -> Summary:
        """Distribution of one kind of error over unseen runs and times."""
        return Summary.of(self.errors[name][:, :, component])

    def learning_curve(self, component: int) -> LearningCurve | None:
        """Mean RMSE against training runs, from the models of the sweep with the surrogate's own number of modes."""
        rows = [int(np.abs(np.array(model.modes) - self.modes).argmin()) for model in self.sweep]
        means = [model.summaries[row][component].mean for model, row in zip(self.sweep, rows, strict=True)]
        return fit([model.runs for model in self.sweep], means)


def evaluate(
    dataset,
    surrogate: Surrogate,
    *,
    sizes: tuple[int, ...] | None = None,
    modes: tuple[int, ...] = SWEEP_MODES,
    memory: int = DEFAULT_MEMORY,
    progress: Callable[[int, int, str], None] | None = None,
) -> Evaluation:
    """Ask a surrogate for every unseen run of its dataset and compare.

    sizes: numbers of training runs (the first ones of the surrogate's own) for which another model is trained with the
        same recipe and epochs, to show errors against runs; default a quarter, half and all for `shared`, none for
        `paper`, whose training takes hours
    modes: numbers of modes to report for each size. One model is trained with the largest and cut: the basis of fewer
        modes is the start of the basis of more, and every coefficient has its own output
    memory: [byte] for the models of `sizes`, as `Surrogate.train`; all else reads one run at a time
    progress: called as progress(done, total, what) before each piece of work

    Raises InputError E-ROM-012 if surrogate and dataset do not belong together, E-ROM-015 without unseen runs, and the
    errors of `Surrogate.train`.
    """
    _require_match(dataset, surrogate)
    runs = tuple(surrogate.training["runs"])
    if sizes is None:
        sizes = tuple(sorted({len(runs) // 4, len(runs) // 2, len(runs)} - {0})) if surrogate.recipe == "shared" else ()
    announce = _Announcer(progress, 3 + len(sizes))

    announce(f"comparing with {len(dataset.test)} unseen runs")
    unseen = np.asarray(dataset.design(dataset.test), float)
    errors = _surrogate_errors(dataset, surrogate)
    spread = surrogate.spread(unseen) if surrogate.regression.members > 1 else None
    intervals = check_intervals(surrogate, dataset, tuple(dataset.test))
    announce("comparing with baselines")
    errors |= _baseline_errors(dataset, surrogate, runs)
    sweep = []
    for size in sizes:
        announce(f"training on {size} runs")
        sweep.append(_sweep(dataset, surrogate, runs[:size], modes, memory))
    announce("measuring times")
    return Evaluation(
        title=surrogate.title,
        recipe=surrogate.recipe,
        modes=surrogate.modes,
        nodes=surrogate.nodes,
        triangles=len(surrogate.triangles),
        parameters=surrogate.parameters,
        reference_length=float(dataset.reference_length),
        times=surrogate.times,
        train=runs,
        test=tuple(dataset.test),
        missing=dict(dataset.missing),
        left_out=left_out(dataset, runs),
        design=unseen,
        errors=errors,
        spread=spread,
        intervals=intervals,
        sweep=tuple(sweep),
        singular_values=np.stack([basis.singular_values for basis in surrogate.bases]),
        energy=np.stack([basis.energy_fraction for basis in surrogate.bases]),
        coverage=_coverage(surrogate.parameters, np.asarray(dataset.design(runs), float), unseen),
        timing=measure(dataset, surrogate),
        ledgers=_ledgers(dataset, (*runs, *dataset.test)),
        training=surrogate.training,
    )


class _Announcer:
    def __init__(self, progress, total):
        self._progress, self._done, self._total = progress, 0, total

    def __call__(self, what):
        if self._progress is not None:
            self._progress(self._done, self._total, what)
        self._done += 1


def _require_match(dataset, surrogate):
    names = [parameter.name for parameter in dataset.parameters]
    if names != [parameter.name for parameter in surrogate.parameters]:
        why = f"the dataset varies {', '.join(names)}"
    elif mesh_sha256(dataset.reference, dataset.triangles) != surrogate.training["mesh_sha256"]:
        why = "their start meshes differ"
    elif not same_times(dataset.times, surrogate.times):
        why = "their times differ"
    elif not set(surrogate.training["runs"]) <= set(dataset.train):
        why = "it was trained on runs that are not training runs of this dataset"
    elif not dataset.test:
        raise InputError(
            "E-ROM-015",
            "there are no unseen runs to compare with",
            where=surrogate.title or "dataset",
            why="the dataset has no completed test run",
            remedy="ask for test runs in study.toml, or finish the study: billow study STUDY.toml --out FOLDER",
        )
    else:
        return
    raise InputError(
        "E-ROM-012",
        "the surrogate was not trained on this dataset",
        where=surrogate.title or "surrogate",
        why=why,
        remedy="evaluate it with its own dataset, or train one on this: billow train FOLDER",
    )


def _surrogate_errors(dataset, surrogate) -> dict[str, np.ndarray]:
    errors = {name: [] for name in ("surrogate", "truncation", "regression")}
    for run, design in zip(dataset.test, dataset.design(dataset.test), strict=True):
        truth = read_run(dataset, run)
        known = np.stack([truth[:, :, c] @ basis.modes.T for c, basis in enumerate(surrogate.bases)], axis=1)
        best = np.stack([known[:, c] @ basis.modes for c, basis in enumerate(surrogate.bases)], axis=-1)
        learned = surrogate.coefficients(design)
        errors["surrogate"].append(snapshot_rmse(surrogate.predict(design), truth))
        errors["truncation"].append(snapshot_rmse(best, truth))
        errors["regression"].append(np.sqrt(np.square(learned - known).sum(axis=-1, dtype=float) / surrogate.nodes))
    return {name: np.array(values) for name, values in errors.items()}


def _baseline_errors(dataset, surrogate, runs) -> dict[str, np.ndarray]:
    simple = baselines(dataset, runs, surrogate.bases)
    errors = {baseline.name: [] for baseline in simple}
    for run, design in zip(dataset.test, dataset.design(dataset.test), strict=True):
        truth = read_run(dataset, run)
        for baseline in simple:
            errors[baseline.name].append(snapshot_rmse(baseline.predict(design), truth))
    return {name: np.array(values) for name, values in errors.items()}


def _sweep(dataset, surrogate, runs, modes, memory) -> SweepModel:
    possible = min(surrogate.nodes, len(runs) * len(surrogate.times))
    modes = tuple(count for count in modes if count <= possible)
    seed, epochs = surrogate.training["seed"], surrogate.training["epochs"]
    model = Surrogate.train(dataset, surrogate.recipe, max(modes), runs, seed, epochs, calibrate=False, memory=memory)
    learned = model.coefficients(dataset.design(dataset.test))
    seen = project((read_run(dataset, run) for run in dataset.test), model.bases)
    lost = [seen.truncation(count) for count in modes]
    total = [np.hypot(floor, seen.regression(learned, count)) for floor, count in zip(lost, modes, strict=True)]
    return SweepModel(
        runs=len(runs),
        generation=float(np.sum(dataset.wall_seconds(runs))),
        training=sum(model.training[f"{step}_seconds"] for step in ("read", "pod", "network")),
        modes=modes,
        summaries=tuple(tuple(Summary.of(errors[:, :, c]) for c in range(3)) for errors in total),
        truncation=np.stack([floor.mean(axis=(0, 1)) for floor in lost]),
    )


def _coverage(parameters, seen: np.ndarray, unseen: np.ndarray) -> Coverage:
    seen, unseen = to_unit(seen, parameters), to_unit(unseen, parameters)
    between = float(neighbour_distances(seen).mean()) if len(seen) > 1 else float("nan")
    nearest = np.linalg.norm(unseen[:, None] - seen[None], axis=2).min(axis=1)
    return Coverage(nearest, between, seen.max(axis=0) - seen.min(axis=0))


def _ledgers(dataset, runs) -> dict[str, dict[str, float]]:
    """Balance errors of runs whose records hold them; datasets made by other solvers may have none."""
    found = {}
    for run in runs:
        record = dataset.result(run).record if hasattr(dataset, "result") else {}
        if record.get("ledger"):
            found[run] = {n: float(value) for n, value in record["ledger"].items() if isinstance(value, int | float)}
    return found
