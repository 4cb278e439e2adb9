"""The axes of a design space as a study file names them: parameters, factors with levels, and constraints on them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from billow.base.attribute_docstrings import described
from billow.results.dataset_files import Parameter

_DIGITS = 10
"""Significant digits of a design value: fewer than a float holds, so that the last bits of `pow`, which differ
between machines, never reach a design; more than any stratum needs."""


def _one_line(value: str) -> str:
    if not value.isprintable():
        raise ValueError("a line break or a control character does not belong here")
    return value


Text = Annotated[str, Field(min_length=1), AfterValidator(_one_line)]
VariableName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
Unit = Annotated[str, Field(pattern=r"^[^\[\]]+$"), AfterValidator(_one_line)]


class StrictTable(BaseModel):
    """A table of the study file: unknown keys are refused, numbers are finite."""

    model_config = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: Any) -> dict[str, Any]:
        return described(cls, handler(core_schema), handler)


class StudyParameter(StrictTable):
    """One axis of the design space; low and high are in `unit`, which is the unit of the case's entries `keys`."""

    name: VariableName
    """What it is called in design.csv and by `billow predict --set NAME=VALUE`: letters, digits and _."""
    label: Text
    """What it is called in reports."""
    unit: Unit
    """Unit of low and high, that of the case's entries; "-" for none."""
    low: float
    """Smallest value."""
    high: float
    """Largest value."""
    keys: Annotated[tuple[Text, ...], Field(strict=False, min_length=1, max_length=100)]
    """Entries of the case that take the value, such as "fabric.permeability", "obstacles.impactor.degree" or
    "obstacles.impactor.velocity.z"."""
    scale: Literal["linear", "log"] = "linear"
    """Whether designs are spread evenly over the values or over their logarithms."""
    distribution: Literal["uniform", "normal", "triangular"] = "uniform"
    """How values are drawn: evenly, or about `middle`, of the logarithms for scale = "log"."""
    middle: float | None = None
    """Mean of the normal distribution, most frequent value of the triangular one; default: halfway."""
    deviation: Annotated[float, Field(gt=0)] | None = None
    """Standard deviation of the normal distribution, in the unit, or as a factor for scale = "log"; values beyond low
    and high are not drawn. Default: a sixth of the range."""
    step: Annotated[float, Field(gt=0)] | None = None
    """Values are low plus a multiple of it: 1 for whole numbers."""

    def entries(self, value: float) -> dict[str, Any]:
        """Entries of the case for a value."""
        return dict.fromkeys(self.keys, value)

    @property
    def axis(self) -> Parameter:
        """The parameter in the form that a dataset uses."""
        return Parameter(self.name, self.label, self.unit, self.low, self.high)

    def value(self, share: float) -> float:
        """The value below which this share of the values lies, in [0, 1)."""
        logarithmic = self.scale == "log"
        ends = [math.log(end) for end in (self.low, self.high)] if logarithmic else [self.low, self.high]
        if self.distribution == "uniform":
            if self.step is not None and not logarithmic:
                return self.stepped(self.low + self.step * math.floor(share * (self._steps + 1)))
            if logarithmic:
                return self.stepped(self.low * (self.high / self.low) ** share)
            return self.stepped(self.low + share * (self.high - self.low))
        low, high = ends
        middle = 0.5 * (low + high)
        if self.middle is not None:
            middle = math.log(self.middle) if logarithmic else self.middle
        if self.distribution == "triangular":
            value = _triangular(share, low, middle, high)
        else:
            spread = (high - low) / 6.0
            if self.deviation is not None:
                spread = math.log(self.deviation) if logarithmic else self.deviation
            value = _truncated_normal(share, low, middle, high, spread)
        return self.stepped(math.exp(value) if logarithmic else value)

    def stepped(self, value: float) -> float:
        """The nearest value that may be drawn."""
        if self.step is not None:
            value = self.low + self.step * min(max(round((value - self.low) / self.step), 0), self._steps)
        return min(max(float(f"{value:.{_DIGITS}g}"), self.low), self.high)

    @property
    def _steps(self) -> int:
        return math.floor((self.high - self.low) / self.step * (1.0 + 1e-12))


def _triangular(share: float, low: float, middle: float, high: float) -> float:
    before = (middle - low) / (high - low)
    if share < before:
        return low + math.sqrt(share * (high - low) * (middle - low))
    return high - math.sqrt((1.0 - share) * (high - low) * (high - middle))


def _truncated_normal(share: float, low: float, middle: float, high: float, deviation: float) -> float:
    from scipy.special import ndtr, ndtri

    below, above = ndtr((low - middle) / deviation), ndtr((high - middle) / deviation)
    return float(middle + deviation * ndtri(below + share * (above - below)))


class StudyLevel(StrictTable):
    """One level of a factor."""

    name: Text
    """What it is called in reports."""
    entries: Annotated[dict[str, Any], Field(min_length=1, max_length=100)]
    """Entries of the case and their values, such as {"inflator.gas" = {N2 = 1.0}}."""


class StudyFactor(StrictTable):
    """A choice between levels, such as fabrics or gases; design.csv holds the number of the level, from 0."""

    name: VariableName
    """What it is called in design.csv."""
    label: Text
    """What it is called in reports."""
    levels: Annotated[tuple[StudyLevel, ...], Field(strict=False, min_length=2, max_length=20)]
    """The levels."""

    unit: ClassVar[str] = "-"
    scale: ClassVar[str] = "linear"
    low: ClassVar[float] = 0.0

    @property
    def high(self) -> float:
        """Number of the last level."""
        return float(len(self.levels) - 1)

    @property
    def keys(self) -> tuple[str, ...]:
        """Entries of the case that any level sets."""
        return tuple(dict.fromkeys(key for level in self.levels for key in level.entries))

    @property
    def axis(self) -> Parameter:
        """The factor in the form that a dataset uses."""
        names = tuple(level.name for level in self.levels)
        return Parameter(self.name, self.label, "-", 0.0, self.high, names)

    def entries(self, value: float) -> dict[str, Any]:
        """Entries of the case for the number of a level."""
        return dict(self.levels[round(value)].entries)

    def value(self, share: float) -> float:
        """Number of the level below which this share of the designs lies."""
        return float(min(math.floor(share * len(self.levels)), len(self.levels) - 1))

    def stepped(self, value: float) -> float:
        """The nearest level."""
        return float(min(max(round(value), 0), len(self.levels) - 1))


ROUNDING = 1e-14
"""Part of the terms of a constraint by which rounding may move their sum."""


class StudyConstraint(StrictTable):
    """A linear condition on parameters: the sum of factors times values, in the parameters' units."""

    terms: Annotated[dict[str, float], Field(min_length=1)]
    """Factor of each parameter, such as {bag_diameter = 1.0, strap_length = -2.0}."""
    at_least: float | None = None
    """The sum is not below it."""
    at_most: float | None = None
    """The sum is not above it."""

    def holds(self, values: np.ndarray, names: Sequence[str]) -> np.ndarray:
        """(designs,) bool, but for rounding of the sum; values: (designs, parameters)."""
        size = sum(abs(factor * values[:, names.index(name)]) for name, factor in self.terms.items())
        return self.missed(values, names) <= ROUNDING * size

    def missed(self, values: np.ndarray, names: Sequence[str]) -> np.ndarray:
        """(designs,): how far the sum is from where it is wanted, 0 there; values: (designs, parameters)."""
        total = sum(factor * values[:, names.index(name)] for name, factor in self.terms.items())
        low = -np.inf if self.at_least is None else self.at_least
        high = np.inf if self.at_most is None else self.at_most
        return np.maximum(np.maximum(low - total, total - high), 0.0)


Variable = StudyParameter | StudyFactor


def entries_of(variables: Sequence[Variable], values: Sequence[float]) -> dict[str, Any]:
    """Entries of the case for a value of each variable."""
    made: dict[str, Any] = {}
    for variable, value in zip(variables, values, strict=True):
        made |= variable.entries(value)
    return made


def listed_entries(entries: Mapping[str, Any]) -> str:
    """Entries of a case in a sentence."""
    return ", ".join(f"{key} = {value:g}" if isinstance(value, float) else f"{key} = {value}"
                     for key, value in entries.items())  # fmt: skip
