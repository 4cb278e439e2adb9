"""Designs of a study: which values its parameters take in each run.

Training designs are a Latin hypercube, or several nested ones. Test designs are another, from a separate random stream,
so that the tests of a surrogate never depend on its training.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.study.definition import StudyDefinition, StudyParameter

_TRAIN_STREAM, _TEST_STREAM = 0, 1
_DIGITS = 10
"""Significant digits of a design value: fewer than a float holds, so that the last bits of `pow`, which differ
between machines, never reach a design; more than any stratum needs."""

Values = tuple[float, ...]
"""Value of each parameter in its unit."""


@dataclass(frozen=True)
class Design:
    """Runs of a study. train, test: run -> value of each parameter in its unit; runs are numbered consecutively."""

    train: dict[str, Values]
    test: dict[str, Values]

    @property
    def runs(self) -> dict[str, Values]:
        """All runs, training first."""
        return {**self.train, **self.test}


def latin_hypercube(count: int, dimensions: int, random: np.random.Generator) -> np.ndarray:
    """(count, dimensions) float64 in [0, 1): each axis cut into `count` equal strata, each holding one point.

    McKay, Beckman and Conover, Technometrics 21 (1979) 239-245, section 2.1. The points are in random order, so that
    the first n are also a fair sample.
    """
    strata = np.stack([random.permutation(count) for _ in range(dimensions)], axis=1)
    return (strata + random.random((count, dimensions))) / count


def refine(points: np.ndarray, count: int, random: np.random.Generator) -> np.ndarray:
    """More points, so that all together are a Latin hypercube of `count`: (count - points, dimensions) float64.

    points: a Latin hypercube, (points, dimensions) in [0, 1); count: a multiple of its size. Each of its strata is cut
    into equal parts, of which its point fills one; new points fill the others, on every axis in random order (Qian,
    Annals of Statistics 37 (2009) 3616-3643, nested Latin hypercubes).
    """
    dimensions = points.shape[1]
    filled = np.floor(points * count).astype(int)
    empty = [random.permutation(np.setdiff1d(np.arange(count), filled[:, axis])) for axis in range(dimensions)]
    return (np.stack(empty, axis=1) + random.random((count - len(points), dimensions))) / count


def draw(definition: StudyDefinition) -> Design:
    """The designs of a study, without `added_designs`; the same for the same definition on every machine."""
    train = _rows(definition, _nested(definition.sizes, definition, _TRAIN_STREAM))
    test = _rows(definition, _nested((definition.test,), definition, _TEST_STREAM))
    return numbered(Design({}, {}), train, test)


def numbered(existing: Design, train: list[Values], test: list[Values]) -> Design:
    """`existing` with more runs after it; existing runs keep names and order, new ones take the next free numbers."""
    first = 1 + max((int(run) for run in existing.runs if run.isdecimal()), default=-1)
    names = [f"{number:04d}" for number in range(first, first + len(train) + len(test))]
    return Design(
        train={**existing.train, **dict(zip(names, train, strict=False))},
        test={**existing.test, **dict(zip(names[len(train) :], test, strict=True))},
    )


def _nested(sizes: tuple[int, ...], definition: StudyDefinition, stream: int) -> np.ndarray:
    """The first sizes[k] points are a Latin hypercube, for every k; larger sizes never change the points before."""
    dimensions = len(definition.parameters)
    points = latin_hypercube(sizes[0], dimensions, _random(definition.seed, stream))
    for size in sizes[1:]:
        points = np.vstack([points, refine(points, size, _random(definition.seed, stream, size))])
    return points


def _random(*entropy: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(entropy)))


def _rows(definition: StudyDefinition, points: np.ndarray) -> list[Values]:
    return [tuple(_value(p, u) for p, u in zip(definition.parameters, point, strict=True)) for point in points.tolist()]


def _value(parameter: StudyParameter, fraction: float) -> float:
    """The value a fraction of the way from low to high."""
    if parameter.scale == "log":
        value = parameter.low * (parameter.high / parameter.low) ** fraction
    else:
        value = parameter.low + fraction * (parameter.high - parameter.low)
    return min(max(float(f"{value:.{_DIGITS}g}"), parameter.low), parameter.high)
