"""Training: from the runs of a dataset to a surrogate."""

from __future__ import annotations

import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from numbers import Integral

import numpy as np

from billow import __version__
from billow.base.blas_threads import one_blas_thread
from billow.base.errors import InputError, ResourceError, shown
from billow.results.dataset_files import Parameter, fingerprint
from billow.rom.learn.clock import clock_helps, learn_clock
from billow.rom.learn.dataset import TOO_FEW_RUNS, Dataset, ReadOnce, read_run, snapshot_bytes
from billow.rom.learn.force_modes import learn_force_inputs
from billow.rom.learn.left_out import left_out
from billow.rom.learn.progress import Progress
from billow.rom.learn.reduction import DEFAULT_MEMORY, Reduction, reduce_runs
from billow.rom.learn.shrinkage import Agreement, disbelieved, shrunk
from billow.rom.learn.shrinkage import factors as believed
from billow.rom.learn.side_by_side import side_by_side
from billow.rom.learn.simple_answers import BASELINES, comparisons, simple_coefficients
from billow.rom.surrogate.basis import Basis
from billow.rom.surrogate.design_space import SAME_DESIGN, bounds, distinct, has_range, to_unit
from billow.rom.surrogate.force_inputs import ForceInputs
from billow.rom.surrogate.intervals import BINS, FEWEST_RUNS, LEVELS, Intervals, histogram, quantiles, scale
from billow.rom.surrogate.judgement import HELD_OUT, Judgement
from billow.rom.surrogate.locked_obstacles import LockedObstacle, locked_obstacles
from billow.rom.surrogate.regression import ACTIVATIONS, BY_CLOCK, InputScaling, OutputScaling, Regression
from billow.rom.surrogate.start_shapes import StartShapes
from billow.rom.surrogate.surrogate import Surrogate

NO_PYTORCH = ResourceError.declare(
    "E-ROM-006",
    "PyTorch is not installed",
    where="training",
    why="training needs it, prediction does not ({reason})",
    remedy='pip install "billow[train]"',
)
NO_SUCH_RECIPE = InputError.declare(
    "E-ROM-008",
    "unknown recipe {recipe!r}",
    where="recipe",
    why="recipes are {known}",
    cause="a misspelt name after --recipe",
    remedy='use recipe "shared"',
)
OUT_OF_BOUNDS = InputError.declare(
    "E-ROM-026",
    "{name} {value} cannot be used",
    where="recipe",
    why="it is a whole number from {least} to {most}",
    cause="a slip in a number",
    remedy="choose {name} inside, or leave it out",
)
NO_RANGE = InputError.declare(
    "E-ROM-010",
    "{name} has no range to learn from ({low:g} to {high:g})",
    where="dataset.toml",
    why="a surrogate can only learn what was varied",
    cause="a dataset in which a parameter is the same everywhere, or with one recorded time",
    remedy="vary {name}, or leave it out of the parameters",
)
NO_ORDER = InputError.declare(
    "E-ROM-250",
    "{name} allows no clock",
    where="recipe",
    why="a clock is a polynomial of the design, and the levels {levels} have no order",
    cause="clock = True with a factor of more than two levels",
    remedy="leave clock out, or make a study for each two levels",
)

FOLDS = 4
ENOUGH_RUNS = 60
"""Folds are left out once this many runs have been held out: they would add less than their training costs."""

MOST_NODES = 2_000
"""Nodes whose errors are counted: every n-th one of a larger mesh, because neighbours have the same errors."""


@dataclass(frozen=True)
class Recipe:
    """How to learn. Same data, recipe and number of BLAS threads: same bits.

    networks: "shared", one ensemble of networks for all coefficients, or "paper", one network for each coefficient
    modes: K, size of each component's basis
    epochs: default 30 to 200, fewer for more runs (`shared`), 15,000 (`paper`)
    force_modes: M, modes of each contact-force component whose coefficients of the previous time become inputs (the
        paper's "Model Including Forces"), 0 for none; force_components: which, such as "z" or "xyz"
    calibrate: learn up to four more times, each time without a quarter of the runs, for `Surrogate.half_width`; costs
        three times the training again (once, with many runs). Not done with fewer than `FEWEST_RUNS` runs, with force
        modes, whose inputs are not known in advance, or for `paper`, which has no ensemble
    memory: [byte] larger snapshots are read from disk block by block; calibrating may take twice as much
    clock: learn a clock of each design (docs/theory.md); default if that helps on runs held out, and there are
        `FEWEST_RUNS` designs. There is none with force modes, for `paper`, or with a factor of more than two levels.
    """

    networks: str = "shared"
    modes: int = 12
    seed: int = 0
    epochs: int | None = None
    force_modes: int = 0
    force_components: str = "z"
    calibrate: bool = True
    memory: int = DEFAULT_MEMORY
    clock: bool | None = None


DEFAULT = Recipe()

MOST_EPOCHS, MOST_MODES, MOST_SEED = 1_000_000, 1_000, 2**63 - 1
"""Of a recipe: beyond the first two, training would not end, or networks would have too many outputs for their runs."""


def same_training(surrogate: Surrogate) -> dict:
    """Seed, epochs and clock of a surrogate, for a `Recipe`."""
    told = {name: surrogate.training.get(name, default) for name, default in (("seed", 0), ("epochs", None))}
    return told | {"clock": surrogate.regression.clock is not None}


def check_recipe(recipe: Recipe) -> None:
    """InputError E-ROM-008 for an unknown kind of networks, E-ROM-026 for a number out of bounds."""
    if recipe.networks not in ACTIVATIONS:
        raise NO_SUCH_RECIPE(recipe=recipe.networks, known=" and ".join(ACTIVATIONS))
    for name, least, most in (
        ("modes", 1, MOST_MODES),
        ("seed", 0, MOST_SEED),
        ("epochs", 1, MOST_EPOCHS),
        ("force_modes", 0, MOST_MODES),
        ("memory", 1, 2**60),
    ):
        value = getattr(recipe, name)
        if not (name == "epochs" and value is None) and not (isinstance(value, Integral) and least <= value <= most):
            raise OUT_OF_BOUNDS(name=name, value=shown(value), least=least, most=most)


def train(
    dataset: Dataset,
    recipe: Recipe = DEFAULT,
    *,
    runs: Sequence[str] | None = None,
    progress: Progress | None = None,
    client=None,
) -> Surrogate:
    """Learn the displacement of a dataset's training runs. Test runs are never read.

    runs: names of the runs to learn from, default `dataset.trusted`, the training runs with the verdict PASS
    client: a Dask client; its workers, which must see the dataset, then make the bases

    Raises InputError E-ROM-007 (too few runs or modes), E-ROM-008, -026 and -250 (recipe), E-ROM-009 (snapshots not
    finite), E-ROM-010 (a parameter or the time has no range), E-CPL-001 (force components), ResourceError E-ROM-006
    (no PyTorch), NumericalStop E-ROM-013 and E-ROM-014 (basis or training failed).
    """
    runs = tuple(dataset.trusted if runs is None else runs)
    import_network()
    check_recipe(recipe)
    if recipe.clock and (without := _without_order(dataset)):
        raise NO_ORDER(name=without[0].name, levels=", ".join(without[0].levels))
    _input_scaling(dataset, recipe.networks)  # refuses what cannot be learned before the long work
    require_runs(dataset, runs)
    calibrated = recipe.calibrate and recipe.networks == "shared" and not recipe.force_modes
    if not calibrated or len(runs) < FEWEST_RUNS or len(groups := of_one_design(dataset, runs)) < FEWEST_RUNS:
        return _learn(dataset, runs, recipe, progress, client)[0]
    folds = held_out(groups)
    if client is None and snapshot_bytes(dataset, runs) <= recipe.memory:
        dataset = ReadOnce(dataset)
    reduction = reduce_runs(dataset, runs, recipe.modes, recipe.seed, recipe.memory, client)
    begun = time.perf_counter()
    recipe = _of_all(dataset, reduction, recipe)
    with import_network().one_thread():
        surrogate, factors, judgement, agreements = _calibrate(dataset, reduction, folds, recipe, progress, client)
    part = believed(agreements)
    lost = reduction.lost_by_time + disbelieved(agreements, part)
    beside = time.perf_counter() - begun - surrogate.training["network_seconds"]
    return replace(
        shrunk(surrogate, part),
        judgement=judgement,
        training=surrogate.training | {"calibration_seconds": beside},
        intervals=Intervals(np.array(LEVELS), factors, lost, reduction.lost_by_node),
    )


def train_networks(
    dataset: Dataset,
    reduction: Reduction,
    recipe: Recipe,
    forces: tuple[ForceInputs, np.ndarray] | None = None,
    progress: Progress | None = None,
) -> Surrogate:
    """A surrogate, without intervals, from runs that are reduced already, to `recipe.modes` modes. forces: as
    `learn_force_inputs` returns them, for the runs of `reduction`. Errors as `train`."""
    network = import_network()
    inputs = _input_scaling(dataset, recipe.networks)
    begun, spent = time.perf_counter(), time.thread_time()
    known, times = reduction.coefficients, reduction.times
    model, further = forces or (None, None)
    clock, at, centred = None, times, inputs.design(reduction.design)
    if _has_clock(dataset, reduction, recipe, centred):
        clock, outputs = learn_clock(centred, times, known)
        at = clock(centred, times)
        mean, deviation = outputs.at(at)
        targets = (known.reshape(*known.shape[:2], -1) - mean) / deviation
        inputs = replace(inputs, start=0.0, end=clock.end, frequencies=BY_CLOCK)
    else:
        outputs = OutputScaling.of(known, times, recipe.networks)
        targets = outputs.forward(known.reshape(*known.shape[:2], -1))
    targets = targets.reshape(-1, 3 * recipe.modes)
    if model is not None:
        inputs = replace(inputs, further=model.width)
    losses = []

    def record_loss(epoch, of, loss):
        losses.append(loss)
        if progress is not None:
            progress(epoch, of, loss)

    reference, starts, own_starts = np.array(dataset.reference, np.float32), None, getattr(dataset, "own_starts", False)
    if own_starts:
        shapes = dataset.starts(reduction.runs)
        starts = StartShapes.learn(reduction.design, shapes, reference, dataset.parameters)
    features = inputs(reduction.design, at, further)
    fit = network.train_shared if recipe.networks == "shared" else network.train_paper
    weights, biases = fit(features, targets, epochs=recipe.epochs, seed=recipe.seed, progress=record_loss)
    return Surrogate(
        title=dataset.title,
        parameters=tuple(dataset.parameters),
        times=times,
        reference=reference,
        starts=starts,
        triangles=np.array(dataset.triangles, np.int64),
        parts=getattr(dataset, "parts", None),
        obstacles=_obstacles(dataset, reduction),
        bases=reduction.bases,
        regression=Regression(recipe.networks, weights, biases, inputs, outputs, clock),
        forces=model,
        designs=reduction.design,
        training={
            "runs": list(reduction.runs),
            "seed": recipe.seed,
            "epochs": len(losses),
            "first_loss": losses[0],
            "last_loss": losses[-1],
            **{n: getattr(reduction, n) for n in ("snapshot_bytes", "read_seconds", "pod_seconds", "pod_cpu_seconds")},
            "network_seconds": time.perf_counter() - begun,
            "network_cpu_seconds": time.thread_time() - spent,
            "mesh_sha256": fingerprint(dataset.reference, dataset.triangles, own_starts),
            "versions": {
                "billow": __version__,
                "python": platform.python_version(),
                "numpy": np.__version__,
                "torch": network.torch.__version__,
            },
        },
    )


def _has_clock(dataset: Dataset, reduction: Reduction, recipe: Recipe, centred: np.ndarray) -> bool:
    # Forces of the time before belong to that time, whatever a clock says; the paper has no clock.
    if recipe.networks != "shared" or recipe.force_modes:
        return False
    if _without_order(dataset):
        return False
    if recipe.clock is not None:
        return recipe.clock
    if len(distinct(reduction.design, dataset.parameters)) < FEWEST_RUNS:
        return False
    return clock_helps(reduction.design, dataset.parameters, centred, reduction.times, reduction.coefficients)


def _of_all(dataset: Dataset, reduction: Reduction, recipe: Recipe) -> Recipe:
    """The recipe with the epochs and the clock of all runs, which trainings without some of them share."""
    centred = _input_scaling(dataset, recipe.networks).design(reduction.design)
    samples = len(reduction.runs) * len(reduction.times)
    epochs = recipe.epochs or import_network().epochs_for(samples)
    return replace(recipe, epochs=epochs, clock=_has_clock(dataset, reduction, recipe, centred))


def _without_order(dataset: Dataset) -> list[Parameter]:
    """Factors of more than two levels: a polynomial of their numbers would give them an order."""
    return [parameter for parameter in dataset.parameters if len(parameter.levels) > 2]


def _obstacles(dataset: Dataset, reduction: Reduction) -> tuple[LockedObstacle, ...]:
    described = getattr(dataset, "obstacles", None)
    return () if described is None else locked_obstacles(described(reduction.runs), reduction.design)


def of_one_design(dataset: Dataset, runs: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Runs of the same design together."""
    return [tuple(runs[row] for row in group) for group in distinct(dataset.design(runs), dataset.parameters)]


def held_out(groups: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """The runs that are held out together, fold by fold. groups: runs of the same design together: held out apart,
    one would be judged by a model that has seen the other."""
    folds = [sum(groups[fold::FOLDS], ()) for fold in range(FOLDS)]
    enough = next((n for n in range(1, FOLDS) if sum(map(len, folds[:n])) >= ENOUGH_RUNS), FOLDS)
    return folds[:enough]


def _calibrate(dataset: Dataset, whole: Reduction, folds, recipe: Recipe, progress, client):
    """The surrogate of all runs, and from others that each learn without one fold: factors for `LEVELS`, [-], (levels,
    3); the judgement; and the agreement of each run. Each is judged with what the others say of the part to believe."""
    counts, errors, reductions = np.zeros((3, BINS)), [], []

    def trainings():
        yield partial(train_networks, dataset, whole, recipe, None)  # takes longest, so it begins first
        for fold in folds:
            others = tuple(run for run in whole.runs if run not in fold)
            with one_blas_thread():  # bits must not depend on who trains meanwhile
                reductions.append(reduce_runs(dataset, others, recipe.modes, recipe.seed, recipe.memory, client))
            yield partial(train_networks, dataset, reductions[-1], recipe, None)

    of_all, *surrogates = side_by_side(trainings(), 0, 1 + len(folds), progress)
    agreements = {}
    for fold, surrogate in zip(folds, surrogates, strict=True):
        for run in fold:
            agreements[run] = Agreement.of(surrogate, dataset.design([run])[0], read_run(dataset, run))
    for fold, learned, reduction in zip(folds, surrogates, reductions, strict=True):
        simple = simple_coefficients(reduction.design, reduction.coefficients, learned.parameters)
        every = slice(None, None, -(-learned.nodes // MOST_NODES))
        for run in fold:
            others = [one for other, one in agreements.items() if other != run]
            part = believed(others)
            surrogate, lost = shrunk(learned, part), reduction.lost_by_time + disbelieved(others, part)
            design, whole = dataset.design([run])[0], read_run(dataset, run)
            truth = whole[:, every]
            scales = scale(surrogate, lost, reduction.lost_by_node, design, surrogate.times, every)
            error = surrogate.predict(design, extrapolate=True)[:, every] - truth
            # A held node would be covered by any interval, so it does not count.
            counts += histogram(np.where(np.any(truth != 0.0, axis=0), error, np.nan), scales)
            own = surrogate.coefficients(design, extrapolate=True)
            errors.append(_distances(whole, surrogate.bases, [own, *(answer(design) for answer in simple.values())]))
    own, *others = np.mean(errors, axis=0).tolist()
    judgement = Judgement(HELD_OUT, len(errors), comparisons(own, dict(zip(BASELINES, others, strict=True))))
    return of_all, quantiles(counts / len(errors)), judgement, list(agreements.values())


def _distances(truth: np.ndarray, bases: tuple[Basis, ...], answers: list[np.ndarray]) -> list[float]:
    """Root mean square distance of the nodes in one run: [m]. truth: [m], (times, nodes, 3); answers: [m], coefficients
    (times, 3, modes) in the bases, whose modes are orthonormal, so that squares over nodes are squares over modes."""
    known = np.stack([truth[:, :, c] @ basis.modes.T for c, basis in enumerate(bases)], axis=1)
    outside = max(np.square(truth, dtype=float).sum() - np.square(known, dtype=float).sum(), 0.0)
    wrong = (np.square(answer - known, dtype=float).sum() for answer in answers)
    return [float(np.sqrt((of_one + outside) / (truth.size / 3))) for of_one in wrong]


def unvaried(dataset: Dataset, runs: tuple[str, ...]) -> list[Parameter]:
    """Parameters that have one value in all of some runs."""
    extent = np.ptp(to_unit(np.asarray(dataset.design(runs), float), dataset.parameters), axis=0)
    return [p for p, of_one in zip(dataset.parameters, extent, strict=True) if of_one <= SAME_DESIGN]


def require_runs(dataset: Dataset, runs: tuple[str, ...]) -> None:
    """InputError E-ROM-007 unless the runs have at least two different designs, with what became of the others;
    E-ROM-010 if a parameter has one value in all of them."""
    if runs and len(of_one_design(dataset, runs)) >= 2:
        for parameter in unvaried(dataset, runs):
            value = dataset.design(runs[:1])[0][dataset.parameters.index(parameter)]
            why = f"all {len(runs)} training runs have one value of it; a surrogate can only learn what was varied"
            raise NO_RANGE(name=parameter.name, low=value, high=value, why=why)
        return
    why, remedy = f"{len(runs)} training runs can be learned from", None
    if runs:
        why += ", and they have one design: nothing shows what a parameter does"
    elif (lost := left_out(dataset, runs)).why:
        why += f"; left out are {lost.reasons()}"
        doubted = [run for run in lost.why if run not in dataset.missing]
        if doubted:
            remedy = f"see quality in runs/{doubted[0]}/run.json, mend the case, and make the study again"
    raise TOO_FEW_RUNS(title=dataset.title or "dataset", count=len(runs), why=why, remedy=remedy)


def import_network():
    """`billow.rom.learn.network`, which needs PyTorch; ResourceError E-ROM-006 without it."""
    try:
        from billow.rom.learn import network
    except ImportError as error:
        raise NO_PYTORCH(reason=error) from error
    return network


def _learn(dataset: Dataset, runs, recipe: Recipe, progress, client) -> tuple[Surrogate, Reduction]:
    """A surrogate without intervals, and what it was learned from."""
    reduction = reduce_runs(dataset, runs, recipe.modes, recipe.seed, recipe.memory, client)
    wanted = recipe.force_modes, recipe.force_components, recipe.seed, recipe.memory
    forces = learn_force_inputs(dataset, runs, *wanted) if recipe.force_modes else None
    return train_networks(dataset, reduction, recipe, forces, progress), reduction


def _input_scaling(dataset: Dataset, networks: str) -> InputScaling:
    low, high = bounds(dataset.parameters)
    start, end = dataset.times[0], dataset.times[-1]
    names = (*(parameter.name for parameter in dataset.parameters), "time")
    for name, least, most in zip(names, (*low, start), (*high, end), strict=True):
        if not has_range(least, most):
            raise NO_RANGE(name=name, low=least, high=most)
    return InputScaling(low, high, float(start), float(end), networks)
