"""Bases, coefficients and force inputs of a nested design, computed once, and the networks fitted to them."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from billow.reproductions.rom_paper.kept import Kept, Piece, fingerprint, shared_settings
from billow.rom.judge.errors import ErrorsByModes, Projection, project
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.force_modes import learn_force_inputs
from billow.rom.learn.progress import Progress
from billow.rom.learn.reduction import Reduction, reduce_runs
from billow.rom.learn.train import Recipe, train_networks
from billow.rom.surrogate.basis import bases_content, bases_from
from billow.rom.surrogate.force_inputs import ForceInputs, previous

SEED = 0
FORCE_MODES = 3
"""M of the paper's second test case."""
FORCE_COMPONENTS = "z"

ARRAYS = ("coefficients", "lost_by_time", "lost_by_node")
NUMBERS = ("snapshot_bytes", "read_seconds", "pod_seconds", "pod_cpu_seconds")
"""Fields of a `Reduction` that are kept on disk, beside its bases."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """reduction: of the training runs; unseen: the test runs in the same bases; made_of: fingerprint of both."""

    reduction: Reduction
    unseen: Projection
    unseen_design: np.ndarray
    made_of: str


@dataclass(frozen=True, eq=False)
class Forces:
    """model: from nodal forces to inputs; seen, unseen: inputs of training and test runs, (runs, times, width)."""

    model: ForceInputs
    seen: np.ndarray
    unseen: np.ndarray


def reduced(dataset: Dataset, runs, test, modes: int, kept: Kept, memory: int) -> Reduced:
    """The reduction of `runs` with `modes` modes, and `test` in it. memory: [byte], as `reduce_runs`."""
    made_of = fingerprint(dataset, [*runs, *test])
    inputs = {"of": made_of, "modes": modes, "seed": SEED, "memory": memory}
    arrays, record = kept.piece("reduction", inputs, lambda: _reduce(dataset, runs, test, modes, memory))
    reduction = Reduction(
        bases=bases_from(arrays),
        design=np.asarray(dataset.design(runs), float),
        times=np.asarray(dataset.times, float),
        runs=tuple(runs),
        **{name: arrays[name] for name in ARRAYS},
        **record["reduction"],
    )
    unseen = Projection(arrays["unseen.known"], arrays["unseen.outside"], len(dataset.reference))
    return Reduced(reduction, unseen, np.asarray(dataset.design(test), float), made_of)


def _reduce(dataset, runs, test, modes, memory) -> Piece:
    reduction = reduce_runs(dataset, runs, modes, SEED, memory)
    unseen = project((dataset.snapshots("displacement", [run])[0] for run in test), reduction.bases)
    arrays = bases_content(reduction.bases) | {"unseen.known": unseen.known, "unseen.outside": unseen.outside}
    arrays |= {name: getattr(reduction, name) for name in ARRAYS}
    return arrays, {"reduction": {name: getattr(reduction, name) for name in NUMBERS}}


def force_inputs(dataset: Dataset, runs, test, reduced: Reduced, kept: Kept, memory: int) -> Forces:
    """Inputs from the contact forces of training and unseen runs, as the paper makes them; the unseen runs' are true,
    known only because these runs have been made. memory: [byte], as `force_bases`. Errors as `learn_force_inputs`."""
    inputs = {"of": reduced.made_of, "modes": FORCE_MODES, "components": FORCE_COMPONENTS, "seed": SEED}

    def make() -> Piece:
        model, seen = learn_force_inputs(dataset, runs, FORCE_MODES, FORCE_COMPONENTS, SEED, memory)
        unseen = [model(previous(dataset.snapshots("contact_force", [run])))[0] for run in test]
        arrays = {"modes": model.modes, "mean": model.mean, "deviation": model.deviation}
        arrays |= {"components": np.array(model.components), "seen": seen, "unseen": np.stack(unseen)}
        return arrays, {}

    arrays, _ = kept.piece("forces", inputs, make)
    model = ForceInputs(tuple(arrays["components"].tolist()), arrays["modes"], arrays["mean"], arrays["deviation"])
    return Forces(model, arrays["seen"], arrays["unseen"])


@dataclass(frozen=True, eq=False)
class Fit(ErrorsByModes):
    """One training of the recipe `shared`, judged on unseen runs. cpu_seconds: [s] of training the networks; epochs"""

    cpu_seconds: float
    epochs: int


def fit(
    dataset: Dataset,
    reduced: Reduced,
    counts: tuple[int, ...],
    kept: Kept,
    *,
    seed: int = 0,
    forces: Forces | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Train with `counts[-1]` modes and judge with each of `counts`.

    forces: also an input, and then known of the unseen runs too. Errors as `train`.
    """
    inputs = {"of": reduced.made_of, "counts": counts, "seed": seed, "forces": forces is not None} | shared_settings()
    if forces is not None:
        inputs |= {"force_modes": forces.model.width}

    def make() -> Piece:
        modes = counts[-1]
        given = None if forces is None else (forces.model, forces.seen)
        recipe, reduction = Recipe(modes=modes, seed=seed), reduced.reduction.cut(modes)
        begun = time.process_time()
        surrogate = train_networks(dataset, reduction, recipe, given, progress)
        spent = time.process_time() - begun
        design, times = reduced.unseen_design, surrogate.times
        learned = surrogate.regression(design, times, None if forces is None else forces.unseen)
        errors = ErrorsByModes.of(counts, reduced.unseen, learned.reshape(len(design), len(times), 3, modes))
        arrays = {"truncation": errors.truncation, "regression": errors.regression}
        return arrays, {"cpu_seconds": spent, "epochs": surrogate.training["epochs"]}

    arrays, record = kept.piece("fit", inputs, make)
    return Fit(counts, arrays["truncation"], arrays["regression"], record["cpu_seconds"], record["epochs"])
