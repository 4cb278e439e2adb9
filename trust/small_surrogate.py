"""A surrogate of four nodes, made by hand: sound in form, for tests of what reads and answers."""

from __future__ import annotations

import itertools

import numpy as np

from billow.results.dataset_files import Parameter, mesh_sha256
from billow.rom.surrogate.basis import Basis
from billow.rom.surrogate.regression import InputScaling, OutputScaling, Regression
from billow.rom.surrogate.surrogate import Surrogate


def small_surrogate() -> Surrogate:
    """Two parameters, three times, two modes of each component, an ensemble of two networks with random weights."""
    random = np.random.default_rng(1)
    times = np.array([0.01, 0.02, 0.03])
    reference = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int64)
    parameters = (
        Parameter("permeability", "Airbag permeability", "-", 0.02, 0.035),
        Parameter("temperature", "Gas temperature", "K", 500.0, 800.0),
    )
    low, high = (np.array([getattr(p, side) for p in parameters]) for side in ("low", "high"))
    inputs = InputScaling(low, high, float(times[0]), float(times[-1]), "shared")
    sizes = (inputs.width, 5, 6)
    weights = tuple(random.normal(size=(2, a, b)).astype(np.float32) for a, b in itertools.pairwise(sizes))
    biases = tuple(random.normal(size=(2, 1, b)).astype(np.float32) for b in sizes[1:])
    outputs = OutputScaling(times, np.zeros((3, 6), np.float32), np.ones((3, 6), np.float32))
    modes = np.eye(2, 4, dtype=np.float32)
    return Surrogate(
        title="Four nodes",
        parameters=parameters,
        times=times,
        reference=reference,
        triangles=triangles,
        bases=tuple(Basis(modes, np.array([2.0, 1.0, 0.5, 0.1]), 5.26) for _ in range(3)),
        regression=Regression("shared", weights, biases, inputs, outputs),
        training={"runs": ["0000", "0001"], "seed": 1, "mesh_sha256": mesh_sha256(reference, triangles)},
    )
