"""Curves as uniform tables, in which a kernel finds stress and energy without a search, and springs with hysteresis:
loading f(x), unloading f(m) u(x/m) from the largest x so far, m (docs/theory.md, Curve laws).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.parts.fabric.curve import Curve, TestedCurve

INTERVALS = 256
"""Of a table; a kink of the curve is rounded off over one of them."""

VIRGIN = 1e300
"""Intervals of the unloading curve per x before the first load: only x = 0 lies on that curve."""


@dataclass(frozen=True)
class Branch:
    """A tabulated curve. rows: (INTERVALS, 4): for each interval of x the integral of the stress up to its start
    [J/m^3], the stress there [Pa], the slope in it [Pa], and a filler. end: of the last interval [-]; beyond, the last
    slope continues."""

    rows: np.ndarray
    end: float

    @classmethod
    def sample(cls, stress: Callable[[np.ndarray], np.ndarray], end: float) -> Branch:
        """stress: [Pa] at x >= 0 [-], (n,) to (n,)."""
        value = stress(np.linspace(0.0, end, INTERVALS + 1))
        step = end / INTERVALS
        work = np.concatenate([[0.0], np.cumsum(0.5 * step * (value[1:] + value[:-1]))])
        return cls(np.stack([work[:-1], value[:-1], np.diff(value) / step, np.zeros(INTERVALS)], axis=1), end)

    @property
    def x(self) -> np.ndarray:
        """Ends of the intervals [-], (INTERVALS,)."""
        return np.linspace(0.0, self.end, INTERVALS + 1)[1:]

    @property
    def stress(self) -> np.ndarray:
        """At the ends of the intervals [Pa], (INTERVALS,)."""
        return self.rows[:, 1] + self.rows[:, 2] * self.end / INTERVALS

    @property
    def work(self) -> np.ndarray:
        """Integral of the stress up to the ends of the intervals [J/m^3], (INTERVALS,)."""
        return self.rows[:, 0] + (self.rows[:, 1] + self.stress) * 0.5 * self.end / INTERVALS

    @property
    def slope(self) -> np.ndarray:
        """In the intervals [Pa], (INTERVALS,)."""
        return self.rows[:, 2]


@dataclass(frozen=True)
class Spring:
    """One direction of a fabric. unloading: in stress, or scaled to u on [0, 1]. share: U(1) if scaled, else 0."""

    loading: Branch
    unloading: Branch
    share: float

    @classmethod
    def of(
        cls, tested: TestedCurve, stress: Callable[[Curve, np.ndarray], np.ndarray], end: Callable[[Curve], float],
        switched: float | None = None,
    ) -> Spring:  # fmt: skip
        """Spring of a tested direction. stress(curve, x): nominal stress [Pa] of a curve; end(curve): x at its end.

        It unloads along the unloading curve, scaled to wherever loading has come; with `switched`, to which x both
        tables reach, along that curve as it is but never above loading. Without unloading it unloads as it loads.
        """
        back = tested.unloading
        upper = partial(stress, tested.loading)
        loading = Branch.sample(upper, end(tested.loading) if switched is None else switched)
        if back is None:
            return cls(loading, loading, 0.0)
        if switched is not None:
            return cls(loading, Branch.sample(lambda x: np.minimum(stress(back, x), upper(x)), switched), 0.0)
        last = stress(back, np.array([end(back)]))[0]
        shape = Branch.sample(lambda x: stress(back, x * end(back)) / last, 1.0)
        return cls(loading, shape, float(shape.work[-1]))

    @property
    def steepest(self) -> float:
        """Largest slope [Pa] of any branch, wherever unloading starts."""
        if self.share == 0.0:
            return float(max(self.loading.slope.max(), self.unloading.slope.max()))
        chord = max(float((self.loading.stress / self.loading.x).max()), float(self.loading.slope[-1]))
        return max(float(self.loading.slope.max()), chord * float(self.unloading.slope.max()))

    @property
    def heat(self) -> np.ndarray:
        """Turned to heat [J/m^3] by loading to the ends of the intervals of x and coming back, (INTERVALS,)."""
        if self.share == 0.0:
            return self.loading.work - self.unloading.work
        return self.loading.work - self.share * self.loading.x * self.loading.stress


class SpringTable(NamedTuple):
    """Springs as kernels see them.

    rows: (springs * 2 * INTERVALS, 4), loading and unloading of each spring after one another, for each interval of
    width s the work up to its start [J/m^3], s times the stress there, s times its growth in the interval, a filler.
    scale: intervals of loading per x, (springs,); of unloading it is the same, or INTERVALS for a scaled curve.
    share: (springs,). Kernels remember two numbers per spring, zero at the start: intervals of the unloading
    curve per x, which is INTERVALS over the largest x so far, and this x times the stress of loading there.
    """

    rows: np.ndarray
    scale: np.ndarray
    share: np.ndarray

    @classmethod
    def build(cls, springs: list[Spring]) -> SpringTable:
        branches = [branch for spring in springs for branch in (spring.loading, spring.unloading)]
        width = np.array([branch.end / INTERVALS for branch in branches])
        rows = np.concatenate([b.rows * [1.0, w, w * w, 0.0] for b, w in zip(branches, width, strict=True)])
        return cls(rows, 1.0 / width[::2], np.array([spring.share for spring in springs]))


# Kernels read the rows themselves and hand their numbers to the functions below. A function that takes the tables and
# the history costs 5 to 40 times the whole kernel: numba counts references to arrays in each call it does not inline.


@scalar
def place(first, at):
    """(row, part of its interval) at a number of intervals from row `first`; above 1 beyond the table."""
    i = int(min(at, INTERVALS - 1.0))
    return np.uint64(first + i), at - i


@scalar
def read(work, start, growth, part, scale):
    """(stress [Pa], work [J/m^3]) from a row, at a part of its interval."""
    return (start + growth * part) * scale, work + part * (start + 0.5 * growth * part)
