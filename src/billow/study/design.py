"""Designs of a study: which values its parameters take in each run.

Training designs are a Latin hypercube, or several nested ones, or a Sobol' sequence. Test designs are another Latin
hypercube, from a separate random stream, so that the tests of a surrogate never depend on its training.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.study.definition import StudyDefinition

TOO_TIGHT = InputError.declare(
    "E-STU-041",
    "the constraints leave too few designs",
    where="[[constraints]]",
    why="of {drawn} designs drawn from the whole space, {allowed} fulfil them; {count} are needed",
    cause="conditions that contradict each other, or the ranges",
    remedy="loosen the constraints, or narrow the ranges to where they hold",
)

MOST_DOUBLINGS = 12
"""Times that a sample is doubled in search of designs that fulfil the constraints."""
EXCHANGES = 200
"""Exchanges that are tried for each point of a maximin design."""
_TRAIN_STREAM, _TEST_STREAM = 0, 1
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
    """The designs of a study, without `added_designs`; the same for the same definition on every machine.

    InputError E-STU-041 if constraints leave too few designs.
    """
    train = _allowed(definition, definition.train, _TRAIN_STREAM)
    test = _allowed(definition, definition.test, _TEST_STREAM)
    return numbered(Design({}, {}), train, test)


def numbered(existing: Design, train: list[Values], test: list[Values]) -> Design:
    """`existing` with more runs after it; existing runs keep names and order, new ones take the next free numbers."""
    first = 1 + max((int(run) for run in existing.runs if run.isdecimal()), default=-1)
    names = [f"{number:04d}" for number in range(first, first + len(train) + len(test))]
    return Design(
        train={**existing.train, **dict(zip(names, train, strict=False))},
        test={**existing.test, **dict(zip(names[len(train) :], test, strict=True))},
    )


def _allowed(definition: StudyDefinition, count: int, stream: int) -> list[Values]:
    """So many designs that fulfil the constraints: the first of larger and larger samples of the whole space."""
    if not definition.constraints:
        return _rows(definition, _points(definition, count, stream))
    for drawn in (count << doubling for doubling in range(MOST_DOUBLINGS)):
        rows = _rows(definition, _points(definition, drawn, stream))
        allowed = [row for row, may in zip(rows, definition.allows(np.array(rows)), strict=True) if may]
        if len(allowed) >= count:
            return allowed[:count]
    raise TOO_TIGHT(count=count, drawn=drawn, allowed=len(allowed))


def _points(definition: StudyDefinition, count: int, stream: int) -> np.ndarray:
    """(count, variables) in [0, 1)."""
    dimensions, seed = len(definition.variables), definition.seed
    if stream == _TEST_STREAM:
        return latin_hypercube(count, dimensions, _random(seed, stream))
    if definition.sampling == "sobol":
        from scipy.stats import qmc

        points = qmc.Sobol(dimensions, rng=_random(seed, stream)).random(1 << max(count - 1, 1).bit_length())
        return points[:count]
    sizes = (count,) if definition.constraints else definition.sizes
    random = _random(seed, stream)
    maximin = definition.sampling == "maximin"
    points = (maximin_hypercube if maximin else latin_hypercube)(sizes[0], dimensions, random)
    for size in sizes[1:]:  # larger sizes never change the points before
        points = np.vstack([points, refine(points, size, _random(seed, stream, size))])
    return points


def maximin_hypercube(count: int, dimensions: int, random: np.random.Generator) -> np.ndarray:
    """A Latin hypercube of points in the middle of their strata that are far apart: (count, dimensions) in [0, 1).

    Exchanges of two coordinates on one axis are kept if they lower the sum of distances^-15 over all pairs (Morris and
    Mitchell, Journal of Statistical Planning and Inference 43 (1995) 381-402, equation 2.1).
    """
    points = (np.floor(latin_hypercube(count, dimensions, random) * count) + 0.5) / count
    if count < 3:
        return points

    def closeness(row: int, point: np.ndarray, other: int) -> float:
        square = np.square(points - point).sum(axis=1)
        square[[row, other]] = np.inf
        return float((square**-7.5).sum())

    for _ in range(EXCHANGES * count):
        axis = random.integers(dimensions)
        one, two = random.choice(count, 2, replace=False)
        now = closeness(one, points[one], two) + closeness(two, points[two], one)
        new_one, new_two = points[one].copy(), points[two].copy()
        new_one[axis], new_two[axis] = new_two[axis], new_one[axis]
        if closeness(one, new_one, two) + closeness(two, new_two, one) < now:
            points[one], points[two] = new_one, new_two
    return points


def _random(*entropy: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(entropy)))


def _rows(definition: StudyDefinition, points: np.ndarray) -> list[Values]:
    return [tuple(v.value(u) for v, u in zip(definition.variables, point, strict=True)) for point in points.tolist()]
