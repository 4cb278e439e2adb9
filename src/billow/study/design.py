"""Designs of a study: which values its parameters take in each run.

Training designs are one Latin hypercube, test designs another, drawn from a random stream of its own: what a
surrogate is judged on never depends on what it was trained on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.study.definition import StudyDefinition, StudyParameter

_TRAIN_STREAM, _TEST_STREAM = 0, 1
_DIGITS = 10
"""Significant digits of a design value: fewer than a float holds, so that the last bits of `pow`, which differ
between machines, never reach a design; more than any stratum needs."""


@dataclass(frozen=True)
class Design:
    """Runs of a study. train, test: run -> value of each parameter in its unit; runs are numbered through."""

    train: dict[str, tuple[float, ...]]
    test: dict[str, tuple[float, ...]]

    @property
    def runs(self) -> dict[str, tuple[float, ...]]:
        """All runs, training first."""
        return {**self.train, **self.test}


def latin_hypercube(count: int, dimensions: int, random: np.random.Generator) -> np.ndarray:
    """(count, dimensions) float64 in [0, 1): each axis cut into `count` equal strata, each holding one point.

    McKay, Beckman and Conover, Technometrics 21 (1979) 239-245, section 2.1. The points are in random order, so the
    first n are a fair sample too.
    """
    strata = np.stack([random.permutation(count) for _ in range(dimensions)], axis=1)
    return (strata + random.random((count, dimensions))) / count


def draw(definition: StudyDefinition) -> Design:
    """The designs of a study: the same for the same definition, always and everywhere."""
    values = []
    for count, stream in ((definition.train, _TRAIN_STREAM), (definition.test, _TEST_STREAM)):
        random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([definition.seed, stream])))
        for point in latin_hypercube(count, len(definition.parameters), random):
            values.append(tuple(_value(p, u) for p, u in zip(definition.parameters, point.tolist(), strict=True)))
    runs = {f"{number:04d}": row for number, row in enumerate(values)}
    names = list(runs)
    return Design(
        train={run: runs[run] for run in names[: definition.train]},
        test={run: runs[run] for run in names[definition.train :]},
    )


def _value(parameter: StudyParameter, fraction: float) -> float:
    """The value a fraction of the way from low to high."""
    if parameter.scale == "log":
        value = parameter.low * (parameter.high / parameter.low) ** fraction
    else:
        value = parameter.low + fraction * (parameter.high - parameter.low)
    return min(max(float(f"{value:.{_DIGITS}g}"), parameter.low), parameter.high)
