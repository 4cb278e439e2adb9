"""The design space of a surrogate: whether a design lies inside, and how far from the training designs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.results.dataset_files import Parameter

DESIGN_DOES_NOT_FIT = InputError.declare(
    "E-ROM-001",
    "the design does not fit the surrogate",
    where="design",
    cause="a misspelt or missing parameter, or a value that is not a number",
    remedy="give one number for each of: {names}",
)
OUTSIDE_RANGE = InputError.declare(
    "E-ROM-002",
    "{name} = {value:.6g} {unit} is outside the trained range",
    where="design {row}: {label}",
    why="the runs cover {low:g} to {high:g} {unit}; beyond, networks guess",
    cause="a value in another unit",
    remedy="choose a value inside, train on a wider study, or insist with extrapolate=True (--extrapolate)",
)
OUTSIDE_TIMES = InputError.declare(
    "E-ROM-003",
    "time {time:.6g} s is outside the trained range",
    where="times",
    why="the runs were recorded from {start:g} to {end:g} s; beyond, networks guess",
    cause="times in milliseconds, or beyond the end of the runs",
    remedy="choose times inside, train on longer runs, or insist with extrapolate=True (--extrapolate)",
)

TIMES_DO_NOT_FIT = InputError.declare(
    "E-ROM-025",
    "the times cannot be used",
    where="times",
    cause="an empty list, a missing value, or a table instead of a list",
    remedy="give a list of times in seconds, or none for all trained times",
)

SAME_LEVEL = 1e-6
"""By which the number of a level may be off."""
BOUND_TOLERANCE = 1e-9
"""Part of a range by which a value may exceed it: the rounding of a unit conversion is no extrapolation."""


LARGEST = 1e30
"""No value of a parameter is larger: its square would overflow in single precision."""
LEAST_RANGE = 1e-9
"""Part of its larger bound that a range is at least wide: less is lost to rounding."""


def bounds(parameters: tuple[Parameter, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper ends of the parameters' ranges, in their units: (parameters,) float64 each."""
    return tuple(np.array([getattr(p, side) for p in parameters], float) for side in ("low", "high"))


def has_range(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Whether there is enough between two bounds to learn from, and to divide by: bool, of their shape."""
    largest = np.maximum(np.abs(low), np.abs(high))
    return (largest < LARGEST) & (largest > 1.0 / LARGEST) & (0.5 * high - 0.5 * low > 0.5 * LEAST_RANGE * largest)


def to_unit(designs: np.ndarray, parameters: tuple[Parameter, ...]) -> np.ndarray:
    """Designs with every parameter's range scaled to [0, 1]: (..., parameters)."""
    low, high = bounds(parameters)
    return (designs - low) / (high - low)


def from_unit(unit: np.ndarray, parameters: tuple[Parameter, ...]) -> np.ndarray:
    """The inverse of `to_unit`."""
    low, high = bounds(parameters)
    return low + unit * (high - low)


def levelled(unit: np.ndarray, parameters: tuple[Parameter, ...]) -> np.ndarray:
    """Evenly spread points of [0, 1] with the axes of factors at their levels, which are then equally frequent."""
    made = np.array(unit, float)
    for k, parameter in enumerate(parameters):
        if count := len(parameter.levels):
            made[:, k] = np.minimum(np.floor(made[:, k] * count), count - 1) / (count - 1)
    return made


def design_rows(design, parameters: tuple[Parameter, ...]) -> tuple[np.ndarray, bool]:
    """Designs as (runs, parameters) float64, and whether a single one was given.

    design: {name: value or (runs,)} or (parameters,) or (runs, parameters); a factor's value may be a level's name
    Raises InputError E-ROM-001 for wrong names, shapes, values that are not finite numbers, or between two levels.
    """
    names = [parameter.name for parameter in parameters]
    try:
        if isinstance(design, Mapping):
            unknown = [f"unknown {name}" for name in design if name not in names]
            missing = [f"missing {name}" for name in names if name not in design]
            if unknown or missing:
                raise ValueError(", ".join(unknown + missing))
            columns = (_numbers(design[parameter.name], parameter) for parameter in parameters)
            rows = np.stack(np.broadcast_arrays(*columns), axis=-1)
        else:
            rows = np.asarray(design, float)
        if rows.ndim not in (1, 2) or rows.shape[-1] != len(names):
            raise ValueError(f"values of shape {rows.shape} were given for {len(names)} parameters")
        if not rows.size:
            raise ValueError("no design was given")
        if not np.abs(rows).max() < LARGEST:
            finite = np.isfinite(rows).all()
            raise ValueError(f"a value lies beyond {LARGEST:.0e}" if finite else "a value is not a finite number")
        for k, parameter in enumerate(parameters):
            if parameter.levels and np.abs(rows[..., k] - np.round(rows[..., k])).max() > SAME_LEVEL:
                levels = ", ".join(f"{name} ({k})" for k, name in enumerate(parameter.levels))
                raise ValueError(f"a value of {parameter.name} lies between its levels, {levels}")
    except (TypeError, ValueError) as error:
        raise DESIGN_DOES_NOT_FIT(why=error, names=", ".join(names)) from error
    return np.atleast_2d(rows), rows.ndim == 1


def _numbers(values, parameter: Parameter) -> np.ndarray:
    """Values of a parameter, of a factor by the names of its levels too."""
    if isinstance(values, str) and values in parameter.levels:
        return np.asarray(float(parameter.levels.index(values)))
    return np.asarray(values, float)


def check_design(rows: np.ndarray, parameters: tuple[Parameter, ...]) -> None:
    """InputError E-ROM-002 if a value lies outside the range its parameter was trained on."""
    for p, column, least, most in zip(
        parameters, rows.T, rows.min(axis=0).tolist(), rows.max(axis=0).tolist(), strict=True
    ):
        slack = BOUND_TOLERANCE * (p.high - p.low)
        if p.low - slack <= least and most <= p.high + slack:
            continue
        row = int(np.argmax((column < p.low - slack) | (column > p.high + slack)))
        value = column[row]
        raise OUTSIDE_RANGE(name=p.name, value=value, unit=p.unit, row=row, label=p.label, low=p.low, high=p.high)


def time_row(times) -> np.ndarray:
    """Times as (times,) float64, [s]. InputError E-ROM-025 unless they are at least one finite number in a list."""
    try:
        row = np.atleast_1d(np.asarray(times, float))
    except (TypeError, ValueError) as error:
        raise TIMES_DO_NOT_FIT(why="a time is not a number") from error
    if row.ndim != 1 or not row.size:
        raise TIMES_DO_NOT_FIT(why="no time was given" if not row.size else f"they have {row.ndim} dimensions")
    if not np.abs(row).max() < LARGEST:
        raise TIMES_DO_NOT_FIT(why="a time is not a finite number")
    return row


def check_times(times: np.ndarray, trained: np.ndarray) -> None:
    """InputError E-ROM-003 if a time lies outside the trained ones or is no number. times, trained: [s], (times,)."""
    slack = BOUND_TOLERANCE * (trained[-1] - trained[0])
    outside = ~((times >= trained[0] - slack) & (times <= trained[-1] + slack))
    if outside.any():
        raise OUTSIDE_TIMES(time=times[outside.argmax()], start=trained[0], end=trained[-1])


SAME_DESIGN = 1e-6
"""Distance, with every range scaled to 1, below which two designs count as one: what their results differ by is then
their own noise, and no interpolation can or should pass through both."""


def distinct(designs: np.ndarray, parameters: tuple[Parameter, ...]) -> list[list[int]]:
    """Rows of equal design together, in the order of the first of each. designs: (runs, parameters)."""
    groups: list[list[int]] = []
    unit = to_unit(np.asarray(designs, float), parameters)
    firsts = np.empty_like(unit)
    for row, point in enumerate(unit):
        near = np.flatnonzero(np.linalg.norm(firsts[: len(groups)] - point, axis=1) <= SAME_DESIGN)
        if len(near):
            groups[near[0]].append(row)
        else:
            firsts[len(groups)] = point
            groups.append([row])
    return groups


@dataclass(frozen=True)
class Standing:
    """One design among the trained ones; distances with every parameter's range scaled to [0, 1].

    outside: names of parameters beyond their trained range; nearest: [-], distance to the nearest training design
    usual, largest: [-], mean and largest distance of a training design to its nearest neighbour
    """

    outside: tuple[str, ...]
    nearest: float
    usual: float
    largest: float

    @property
    def isolated(self) -> bool:
        """True if the design is farther from all training designs than any of them is from its neighbour."""
        return self.nearest > self.largest

    def warnings(self) -> list[str]:
        """Sentences for people; none if the design lies among the trained ones."""
        sentences = []
        if self.outside:
            sentences.append(f"{', '.join(self.outside)} outside the trained range: no support in the data")
        if self.isolated:
            sentences.append(
                f"the nearest training design is {self.nearest / self.usual:.1f} times as far away as training designs "
                "are from each other on average, farther than any of them: the answer is less certain than its interval"
            )
        return sentences


def standing(design: np.ndarray, designs: np.ndarray, parameters: tuple[Parameter, ...]) -> Standing:
    """Where `design` (parameters,) stands among `designs` (runs, parameters), at least two distinct ones; runs of one
    design count as one, for they say nothing of how far designs lie from each other."""
    firsts = designs[[group[0] for group in distinct(designs, parameters)]]
    known, asked = to_unit(firsts, parameters), to_unit(design, parameters)
    between = neighbour_distances(known)
    nearest = float(np.linalg.norm(known - asked, axis=1).min())
    beyond = (asked < -BOUND_TOLERANCE) | (asked > 1.0 + BOUND_TOLERANCE)
    outside = tuple(p.name for p, out in zip(parameters, beyond, strict=True) if out)
    return Standing(outside, nearest, float(between.mean()), float(between.max()))


def neighbour_distances(points: np.ndarray) -> np.ndarray:
    """Distance of each point to its nearest neighbour: (points,). points: (points, dimensions), at least two."""
    squares = np.square(points).sum(axis=1)
    distance = squares[:, None] + squares[None] - 2.0 * points @ points.T
    np.fill_diagonal(distance, np.inf)
    return np.sqrt(np.maximum(distance.min(axis=1), 0.0))
