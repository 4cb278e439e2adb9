"""From a dataset to everything a surrogate consists of: snapshots, bases, coefficients, networks."""

from __future__ import annotations

import platform
import time

import numpy as np

from billow import __version__
from billow.errors import InputError, ResourceError
from billow.results.dataset_files import Parameter, mesh_sha256
from billow.rom.basis import pod
from billow.rom.regression import ACTIVATIONS, Regression
from billow.rom.scaling import InputScaling, OutputScaling
from billow.rom.snapshots import collect


def learn(dataset, recipe, modes, runs, seed, epochs, progress) -> dict:
    """The fields of a `Surrogate`, learned from `runs` of `dataset`. Arguments and errors as `Surrogate.train`."""
    network = _import_network()
    inputs = _input_scaling(dataset, recipe)
    clock = [time.perf_counter()]
    snapshots = collect(dataset, runs)
    clock.append(time.perf_counter())
    bases = tuple(pod(matrix, modes, seed) for matrix in snapshots.matrices)
    coefficients = np.stack([b.coefficients(m) for b, m in zip(bases, snapshots.matrices, strict=True)])
    clock.append(time.perf_counter())
    known = snapshots.by_run(coefficients)  # (runs, times, components, modes)
    outputs = OutputScaling.of(known, snapshots.times, recipe)
    targets = outputs.forward(known.reshape(*known.shape[:2], -1)).reshape(-1, 3 * modes)
    losses = []

    def record_loss(epoch, of, loss):
        losses.append(loss)
        if progress is not None:
            progress(epoch, of, loss)

    train = network.train_shared if recipe == "shared" else network.train_paper
    features = inputs(snapshots.design, snapshots.times)
    weights, biases = train(features, targets, epochs=epochs, seed=seed, progress=record_loss)
    clock.append(time.perf_counter())
    return {
        "title": getattr(dataset, "title", ""),
        "parameters": tuple(Parameter(p.name, p.label, p.unit, p.low, p.high) for p in dataset.parameters),
        "times": snapshots.times,
        "reference": np.array(dataset.reference, np.float32),
        "triangles": np.array(dataset.triangles, np.int64),
        "bases": bases,
        "regression": Regression(recipe, weights, biases, inputs, outputs),
        "training": {
            "runs": list(snapshots.runs),
            "seed": seed,
            "epochs": len(losses),
            "first_loss": losses[0],
            "last_loss": losses[-1],
            "snapshot_bytes": snapshots.memory,
            "read_seconds": clock[1] - clock[0],
            "pod_seconds": clock[2] - clock[1],
            "network_seconds": clock[3] - clock[2],
            "mesh_sha256": mesh_sha256(dataset.reference, dataset.triangles),
            "versions": {
                "billow": __version__,
                "python": platform.python_version(),
                "numpy": np.__version__,
                "torch": network.torch.__version__,
            },
        },
    }


def _import_network():
    try:
        from billow.rom import network
    except ImportError as error:
        raise ResourceError(
            "E-ROM-006",
            "PyTorch is not installed",
            where="billow.rom.network",
            why=f"training needs it, prediction does not ({error})",
            remedy="pip install torch",
        ) from error
    return network


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
