"""Seconds: of one answer, of loading, of making the model, and when the effort has paid."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from billow.rom.learn.dataset import Dataset
from billow.rom.surrogate.surrogate import Surrogate

REPEATS = 50


@dataclass(frozen=True)
class Inference:
    """Median time [s] of each part; all parts are measured in turn, so that a slow phase hits all alike.

    networks: coefficients of all components; fields: of x, y and z from their coefficients; whole: one deployment, all
    times and components; loading: the model from its file, checked; copy: of the answer in memory, the floor of `whole`
    """

    networks: float
    fields: tuple[float, float, float]
    whole: float
    loading: float
    copy: float


@dataclass(frozen=True)
class Timing:
    """Times behind paper Tables 2 and 3 and Figure 6: [s].

    simulation: mean of one training run; generation: all training runs together
    training: from finished runs to a finished surrogate; inference: of one deployment
    """

    simulation: float
    generation: float
    training: float
    inference: Inference

    @property
    def speed_up(self) -> float:
        """How many deployments the surrogate answers while the solver makes one: [-]."""
        return self.simulation / self.inference.whole

    @property
    def break_even(self) -> int | None:
        """As the function of this name, with the training runs counted."""
        return break_even(self.generation + self.training, self.simulation, self.inference.whole)


def break_even(making: float, simulation: float, inference: float) -> int | None:
    """Fewest deployments for which making [s] and asking a surrogate takes less time than simulating them all."""
    gain = simulation - inference
    return math.ceil(making / gain) if gain > 0.0 else None


def training_seconds(surrogate: Surrogate) -> dict[str, float]:
    """[s] of each step of training."""
    steps = {"reading": "read", "pod": "pod", "network": "network", "calibration": "calibration"}
    return {name: surrogate.training.get(f"{key}_seconds", 0.0) for name, key in steps.items()}


def measure(dataset: Dataset, surrogate: Surrogate) -> Timing:
    """Measure inference on this machine, wall time, and take the rest from the records of runs and training."""
    seconds, training = dataset.computing_seconds(surrogate.runs), sum(training_seconds(surrogate).values())
    asked = measure_inference(surrogate, dataset.design(surrogate.runs[:1])[0], time.perf_counter)
    return Timing(float(np.mean(seconds)), float(np.sum(seconds)), training, asked)


def measure_inference(surrogate: Surrogate, design: np.ndarray, clock: Callable[[], float]) -> Inference:
    """Measure on this machine. design: (parameters,); clock: of wall or processor time"""
    answer = np.ascontiguousarray(surrogate.predict(design))
    target = np.empty_like(answer)
    coefficients = surrogate.coefficients(design)
    alone = [np.ascontiguousarray(coefficients[:, c]) for c in range(3)]
    fields = [partial(np.matmul, one, basis.modes) for one, basis in zip(alone, surrogate.bases, strict=True)]
    asked = partial(surrogate.coefficients, design), *fields, partial(surrogate.predict, design)
    networks, x, y, z, whole, copy = _medians(clock, REPEATS, *asked, partial(np.copyto, target, answer))
    with tempfile.TemporaryDirectory() as folder:
        path = surrogate.save(Path(folder, "surrogate.safetensors"))
        (loading,) = _medians(clock, 5, partial(Surrogate.load, path))
    return Inference(networks, (x, y, z), whole, loading, copy)


def _medians(clock, repeats: int, *calls: Callable[[], object]) -> list[float]:
    taken = np.empty((repeats, len(calls)))
    for call in calls:
        call()  # the first call pays for lazy imports and cold caches
    for times in taken:
        for number, call in enumerate(calls):
            begun = clock()
            call()
            times[number] = clock() - begun
    return np.median(taken, axis=0).tolist()
