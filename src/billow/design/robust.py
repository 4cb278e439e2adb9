"""Robustness: what scatter of the parameters about a design does to the responses, by Monte Carlo on the surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.base.blas_threads import one_blas_thread
from billow.base.errors import InputError
from billow.base.toml_file import read_toml
from billow.design.optimum import unit_design
from billow.rom.surrogate.design_space import bounds, to_unit
from billow.study.responses import Limit

SCATTER = InputError.declare(
    "E-DES-040",
    "the scatter cannot be used",
    where="{where}",
    cause="a misspelt parameter, or a deviation in another unit",
    remedy="give the standard deviation of each parameter that scatters, such as inflator_temperature = 15.0",
)
OUT_OF_REACH = InputError.declare(
    "E-DES-041",
    "the scatter leaves the range of the study",
    where="{where}",
    why="{share:.1%} of the scattered designs lie outside, {most:.1%} by {name}, {value:.6g} +- {scatter:.3g} {unit}, "
    "whose range is {low:.6g} to {high:.6g}; surfaces know nothing there",
    cause="a design at the edge of the study, or a scatter as wide as its ranges",
    remedy="choose a design farther inside, a smaller scatter, or a wider study",
)
SAMPLES = 100_000
MOST_OUTSIDE = 0.05
"""Share of scattered designs that may lie outside the ranges; they are moved to the edge, and counted."""
PERCENTILES = (5.0, 50.0, 95.0)
WITHIN = 3.0
"""Deviations of each parameter, within which a run is one of the scatter."""
FEWEST_NEAR = 6
"""Runs of the scatter that show how far the surface is off there (docs/design.md, Measured)."""
SAME = 0.02
"""Part of the range of a parameter that does not scatter by which a run may be away and still be one of the scatter."""


@dataclass(frozen=True, eq=False)
class Chance:
    """Of a response under scatter, and of the limit it may exceed.

    values: (samples,) of the surface; percentiles: (3,) of `PERCENTILES`; limit: what is wanted; probability: that it
    is broken, by the surface alone; with_error: with the surface's own error, as if it were another in every run; low,
    high: if the surface were at either end of its 90 % intervals everywhere; outside: share of scattered designs that
    were moved to the edge of the ranges; near: runs among the scattered designs, which the surface has learned from
    """

    response: str
    unit: str
    values: np.ndarray
    percentiles: np.ndarray
    limit: Limit
    probability: float
    with_error: float
    low: float
    high: float
    outside: float
    near: int

    @property
    def resolved(self) -> bool:
        """Whether runs of the scatter show how far the surface is off there."""
        return self.near >= FEWEST_NEAR

    @property
    def broken(self) -> str:
        """Where the limit is broken, in words; empty without one."""
        ends = (("below", self.limit.above), ("above", self.limit.below))
        return " or ".join(f"{side} {end:g}" for side, end in ends if end is not None)

    @property
    def light(self) -> str:
        """green: surely within 5 %; red: surely not; yellow: it depends on the surface's error."""
        if not self.broken:
            return "grey"
        return "green" if self.high <= 0.05 else "red" if self.low > 0.05 else "yellow"


def read_values(path: str | Path, surfaces) -> dict[str, float]:
    """A TOML file of values by name: a design, or a scatter; numbers, or texts as the surfaces know them. InputError
    E-DES-040."""
    try:
        content = read_toml(Path(path))
        content = content.get("design", content.get("scatter", content))
        if not content:
            raise ValueError("it holds one value for each name, and at least one")
        return {name: surfaces.number(name, value) for name, value in content.items()}
    except (OSError, ValueError) as error:
        raise SCATTER(where=path, why=error) from error


@one_blas_thread()
def robustness(surfaces, design: Mapping[str, float], scatter: Mapping[str, float], seed: int = 0) -> dict[str, Chance]:
    """Every usable response about a design, with the limits of the study.

    scatter: standard deviation of each parameter that scatters, normal and independent, in its unit
    InputError E-DES-040: scatter; -041: it leaves the ranges; E-ROM-001, -002: the design.
    """
    found = {}
    for response, surface in zip(surfaces.responses, surfaces.surfaces, strict=True):
        if surface.verdict.usable:
            found[response.name] = _chance(surfaces, response.name, response.limit, design, scatter, seed)
    return found


def exceed(surfaces, name: str, limit: float, around: Mapping[str, float], scatter: Mapping[str, float], seed: int = 0):
    """The `Chance` that a response is above a limit, in its unit. Errors as `robustness`, E-DES-010."""
    with one_blas_thread():
        return _chance(surfaces, name, Limit(below=limit), around, scatter, seed)


def scattered(surfaces, design: Mapping[str, float], scatter: Mapping[str, float], count: int, seed: int):
    """Designs in [0, 1], (count, parameters), and the share that had to be moved to the edge of the ranges."""
    names = [parameter.name for parameter in surfaces.parameters]
    unknown = [name for name in scatter if name not in names]
    if unknown or not all(np.isfinite(s) and s >= 0.0 for s in scatter.values()) or not any(scatter.values()):
        why = (
            f"there is no parameter {unknown[0]!r}" if unknown else "deviations are numbers, none below zero, one above"
        )
        raise SCATTER(where="scatter", why=why)
    low, high = bounds(surfaces.parameters)
    deviation = np.array([scatter.get(name, 0.0) for name in names]) / (high - low)
    for parameter, wide in zip(surfaces.parameters, deviation, strict=True):
        if parameter.levels and wide:
            raise SCATTER(where="scatter", why=f"{parameter.name} is a choice, which does not scatter")
    points = unit_design(surfaces, design) + deviation * np.random.default_rng(seed).standard_normal(
        (count, len(names))
    )
    is_outside = (points < 0.0) | (points > 1.0)
    outside = float(is_outside.any(axis=1).mean())
    if outside > MOST_OUTSIDE:
        k = int(is_outside.mean(axis=0).argmax())
        p = surfaces.parameters[k]
        raise OUT_OF_REACH(
            where="scatter", share=outside, most=float(is_outside[:, k].mean()), name=p.name, value=design[p.name],
            scatter=scatter.get(p.name, 0.0), unit=p.unit, low=p.low, high=p.high,
        )  # fmt: skip
    return np.clip(points, 0.0, 1.0), outside


def _chance(surfaces, name: str, limit: Limit, design, scatter, seed: int) -> Chance:
    from scipy.special import ndtr

    from billow.design.surface import SCALES

    surface = surfaces.usable(name)
    points, outside = scattered(surfaces, design, scatter, SAMPLES, seed)
    near = _near(surfaces, design, scatter)
    mean, deviation = surface.distribution(points)
    values = SCALES[surface.scale].back(mean)
    told = dict.fromkeys(("probability", "with_error", "low", "high"), float("nan"))
    if limit.below is not None or limit.above is not None:
        over = mean - (np.inf if limit.below is None else surface.scaled(limit.below))
        under = (-np.inf if limit.above is None else surface.scaled(limit.above)) - mean
        half, error = 1.6448536269514722 * deviation, np.maximum(deviation, 1e-300)
        ends = [float(((over + by > 0.0) | (under - by > 0.0)).mean()) for by in (0.0, -half, half)]
        told = {
            "probability": ends[0],
            "with_error": float((ndtr(over / error) + ndtr(under / error)).mean()),
            "low": min(ends),
            "high": max(ends),
        }
    percentiles = np.percentile(values, PERCENTILES)
    return Chance(name, surfaces.unit(name), values, percentiles, limit, outside=outside, near=near, **told)


def _near(surfaces, design: Mapping[str, float], scatter: Mapping[str, float]) -> int:
    """Runs within `WITHIN` deviations of a design in every parameter, or `SAME` where that is more."""
    low, high = bounds(surfaces.parameters)
    deviation = np.array([scatter.get(parameter.name, 0.0) for parameter in surfaces.parameters]) / (high - low)
    away = np.abs(to_unit(surfaces.designs, surfaces.parameters) - unit_design(surfaces, design))
    return int((away <= np.maximum(WITHIN * deviation, SAME)).all(axis=1).sum())
