"""How long one deployment takes to answer, part by part: the paper's tables of inference times."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.rom.surrogate.surrogate import Surrogate

REPEATS = 60


@dataclass(frozen=True)
class Inference:
    """Median processor time [s] of each part; all parts measured in turn, so that a slow phase hits all alike.

    networks: coefficients of all components; fields: of x, y and z from their coefficients; whole: one deployment, all
    times and components; loading: the model from its file, checked; copy: of the answer in memory, the floor of `whole`
    """

    networks: float
    fields: tuple[float, float, float]
    whole: float
    loading: float
    copy: float


def measure_inference(surrogate: Surrogate, design: np.ndarray) -> Inference:
    """Measure on this machine. design: (parameters,)"""
    answer = np.ascontiguousarray(surrogate.predict(design))
    target = np.empty_like(answer)
    coefficients = surrogate.coefficients(design)

    def field(component):
        alone = np.ascontiguousarray(coefficients[:, component])
        modes = surrogate.bases[component].modes
        return lambda: alone @ modes

    with tempfile.TemporaryDirectory() as folder:
        path = surrogate.save(Path(folder, "surrogate.safetensors"))
        networks, x, y, z, whole, copy = _medians(
            lambda: surrogate.coefficients(design), *map(field, range(3)), lambda: surrogate.predict(design),
            lambda: np.copyto(target, answer),
        )  # fmt: skip
        (loading,) = _medians(lambda: Surrogate.load(path), repeats=5)
    return Inference(networks, (x, y, z), whole, loading, copy)


def _medians(*calls: Callable[[], object], repeats: int = REPEATS) -> list[float]:
    taken = np.empty((repeats, len(calls)))
    for call in calls:
        call()  # the first call pays for lazy imports and cold caches
    for times in taken:
        for number, call in enumerate(calls):
            begun = time.process_time()
            call()
            times[number] = time.process_time() - begun
    return np.median(taken, axis=0).tolist()
