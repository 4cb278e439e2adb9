"""Seconds: of one answer, of loading, of making the model, and when the effort has paid."""

from __future__ import annotations

import math
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Timing:
    """Times behind paper Tables 2 and 3 and Figure 6: [s].

    simulation: mean of one training run
    generation: all training runs together; reading, pod, network, calibration: the steps of training
    inference: one whole deployment (all times, nodes, components); of it, coefficients: the networks
    loading: the model from its file, checked; memcpy: copying one deployment in memory, the floor of `inference`
    """

    simulation: float
    generation: float
    reading: float
    pod: float
    network: float
    calibration: float
    inference: float
    coefficients: float
    loading: float
    memcpy: float

    @property
    def training(self) -> float:
        """From finished runs to a finished surrogate: [s]."""
        return self.reading + self.pod + self.network + self.calibration

    @property
    def speed_up(self) -> float:
        """How many deployments the surrogate answers while the solver makes one: [-]."""
        return self.simulation / self.inference

    @property
    def break_even(self) -> int | None:
        """Fewest evaluations for which making and asking the surrogate takes less time than simulating them all."""
        gain = self.simulation - self.inference
        return math.ceil((self.generation + self.training) / gain) if gain > 0.0 else None


def measure(dataset, surrogate) -> Timing:
    """Measure inference on this machine and take the rest from the records of runs and training."""
    runs = surrogate.training["runs"]
    design = dataset.design(runs[:1])[0]
    answer = np.ascontiguousarray(surrogate.predict(design))
    target = np.empty_like(answer)
    with tempfile.TemporaryDirectory() as folder:
        path = surrogate.save(Path(folder, "surrogate.safetensors"))
        loading = _median_seconds(lambda: type(surrogate).load(path), 5)
    return Timing(
        simulation=float(np.mean(dataset.wall_seconds(runs))),
        generation=float(np.sum(dataset.wall_seconds(runs))),
        reading=surrogate.training["read_seconds"],
        pod=surrogate.training["pod_seconds"],
        network=surrogate.training["network_seconds"],
        calibration=surrogate.training.get("calibration_seconds", 0.0),
        inference=_median_seconds(lambda: surrogate.predict(design)),
        coefficients=_median_seconds(lambda: surrogate.coefficients(design)),
        loading=loading,
        memcpy=_median_seconds(lambda: np.copyto(target, answer)),
    )


def _median_seconds(action, repeats: int = 50) -> float:
    action()  # the first call pays for lazy imports and cold caches
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        seconds.append(time.perf_counter() - start)
    return float(np.median(seconds))
