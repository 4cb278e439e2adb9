"""From a dataset to everything a surrogate consists of: snapshots, bases, coefficients, networks."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from billow import __version__
from billow.base.errors import InputError, ResourceError
from billow.results.dataset_files import Parameter, mesh_sha256
from billow.rom.learn.force_inputs import ForceInputs
from billow.rom.learn.reduction import Reduction, reduce_runs
from billow.rom.surrogate.regression import ACTIVATIONS, Regression
from billow.rom.surrogate.scaling import InputScaling, OutputScaling

Progress = Callable[[int, int, float], None]


@dataclass(frozen=True)
class Plan:
    """How to learn. Fields as the arguments of `Surrogate.train`."""

    recipe: str
    modes: int
    seed: int
    epochs: int | None
    force_modes: int
    force_components: str
    memory: int
    client: object = None


class Stages:
    """Progress of several trainings as that of one."""

    def __init__(self, progress: Progress | None, stages: int):
        self._progress, self._stages, self._begun = progress, stages, 0

    def next(self) -> Progress | None:
        """What the next training reports to."""
        before, self._begun = self._begun, self._begun + 1
        if self._progress is None:
            return None
        return lambda epoch, of, loss: self._progress(before * of + epoch, self._stages * of, loss)


def learn(dataset, runs: tuple[str, ...], plan: Plan, progress: Progress | None = None) -> tuple[dict, Reduction]:
    """The fields of a `Surrogate` learned from `runs`, and what it was learned from. Errors as `Surrogate.train`."""
    import_network()
    _input_scaling(dataset, plan.recipe)  # refuses what cannot be learned before the long work
    reduction = reduce_runs(dataset, runs, plan.modes, plan.seed, plan.memory, plan.client)
    forces = None
    if plan.force_modes:
        forces = ForceInputs.learn(dataset, runs, plan.force_modes, plan.force_components, plan.seed, plan.memory)
    return learn_networks(dataset, reduction, plan, forces, progress), reduction


def learn_networks(
    dataset,
    reduction: Reduction,
    plan: Plan,
    forces: tuple[ForceInputs, np.ndarray] | None = None,
    progress: Progress | None = None,
) -> dict:
    """The fields of a `Surrogate` from runs that are reduced already.

    reduction: with `plan.modes` modes; forces: as `ForceInputs.learn` returns them, for the runs of `reduction`
    Errors as `Surrogate.train`.
    """
    network = import_network()
    inputs = _input_scaling(dataset, plan.recipe)
    begun = time.perf_counter()
    known, times = reduction.coefficients, reduction.times
    outputs = OutputScaling.of(known, times, plan.recipe)
    targets = outputs.forward(known.reshape(*known.shape[:2], -1)).reshape(-1, 3 * plan.modes)
    model, further = (None, None) if forces is None else forces
    if model is not None:
        inputs = replace(inputs, further=model.width)
    losses = []

    def record_loss(epoch, of, loss):
        losses.append(loss)
        if progress is not None:
            progress(epoch, of, loss)

    features = inputs(reduction.design, times, further)
    train = network.train_shared if plan.recipe == "shared" else network.train_paper
    weights, biases = train(features, targets, epochs=plan.epochs, seed=plan.seed, progress=record_loss)
    return {
        "title": getattr(dataset, "title", ""),
        "parameters": tuple(Parameter(p.name, p.label, p.unit, p.low, p.high) for p in dataset.parameters),
        "times": times,
        "reference": np.array(dataset.reference, np.float32),
        "triangles": np.array(dataset.triangles, np.int64),
        "bases": reduction.bases,
        "regression": Regression(plan.recipe, weights, biases, inputs, outputs),
        "forces": model,
        "training": {
            "runs": list(reduction.runs),
            "seed": plan.seed,
            "epochs": len(losses),
            "first_loss": losses[0],
            "last_loss": losses[-1],
            "snapshot_bytes": reduction.snapshot_bytes,
            "read_seconds": reduction.read_seconds,
            "pod_seconds": reduction.pod_seconds,
            "network_seconds": time.perf_counter() - begun,
            "mesh_sha256": mesh_sha256(dataset.reference, dataset.triangles),
            "versions": {
                "billow": __version__,
                "python": platform.python_version(),
                "numpy": np.__version__,
                "torch": network.torch.__version__,
            },
        },
    }


def import_network():
    """`billow.rom.learn.network`, which needs PyTorch; ResourceError E-ROM-006 without it."""
    try:
        from billow.rom.learn import network
    except ImportError as error:
        raise ResourceError(
            "E-ROM-006",
            "PyTorch is not installed",
            where="billow.rom.learn.network",
            why=f"training needs it, prediction does not ({error})",
            remedy="pip install torch",
        ) from error
    return network


def shared_settings() -> dict:
    """What the default recipe is at present, as plain JSON: what was learned by another one must not pass for it."""
    network = import_network()
    return {
        "layers": [network.MEMBERS, *network.HIDDEN_SHARED],
        "steps": [network.BATCH_SHARED, *network.EPOCHS_SHARED, network.STEPS_SHARED],
    }


def _input_scaling(dataset, recipe) -> InputScaling:
    if recipe not in ACTIVATIONS:
        raise InputError(
            "E-ROM-008",
            f"there is no recipe {recipe!r}",
            where="recipe",
            why=f"recipes are {' and '.join(ACTIVATIONS)}",
            remedy='use recipe "shared"',
        )
    ranges = [(parameter.name, parameter.low, parameter.high) for parameter in dataset.parameters]
    for name, low, high in [*ranges, ("time", dataset.times[0], dataset.times[-1])]:
        if not low < high:
            raise InputError(
                "E-ROM-010",
                f"{name} has no range to learn from ({low:g} to {high:g})",
                where="dataset.toml",
                why="a surrogate can only learn what was varied",
                remedy=f"vary {name}, or leave it out of the parameters",
            )
    low, high = (np.array([bounds[side] for bounds in ranges], float) for side in (1, 2))
    return InputScaling(low, high, float(dataset.times[0]), float(dataset.times[-1]), recipe)
