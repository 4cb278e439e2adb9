"""Piecewise linear curves, and many of them in flat arrays for kernels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar

NO_CURVE = -1
"""Index that stands for the constant 1."""


@dataclass(frozen=True)
class Curve:
    """y against increasing x, piecewise linear, constant outside; (n,) each."""

    x: np.ndarray
    y: np.ndarray


class CurveTable(NamedTuple):
    """Curves one after the other, for kernels. start: (curves + 1,) int64; x, y: (points,)."""

    start: np.ndarray
    x: np.ndarray
    y: np.ndarray

    @classmethod
    def build(cls, curves: Sequence[Curve]) -> CurveTable:
        start = np.concatenate([[0], np.cumsum([len(curve.x) for curve in curves])]).astype(np.int64)
        x, y = (np.concatenate([np.empty(0), *(getattr(curve, axis) for curve in curves)]) for axis in "xy")
        return cls(start, x, y)


@scalar
def interval(x, at):
    """k with x[k] <= at < x[k + 1]; x[0] <= at < x[-1] is required.

    Halved here, because machine code with `np.searchsorted` in it has SciPy's linear algebra loaded with it, 0.15 s.
    """
    k, above = 0, len(x) - 1
    while above - k > 1:
        middle = (k + above) // 2
        if x[middle] <= at:
            k = middle
        else:
            above = middle
    return k


@scalar
def interpolate(x, y, at):
    """Piecewise linear value, constant outside."""
    last = len(x) - 1
    if at <= x[0]:
        return y[0]
    if at >= x[last]:
        return y[last]
    k = interval(x, at)
    return y[k] + (y[k + 1] - y[k]) * (at - x[k]) / (x[k + 1] - x[k])


@scalar
def curve_value(curves, k, at):
    """Value of curve k of a CurveTable; 1 for NO_CURVE."""
    if k == NO_CURVE:
        return 1.0
    first, end = curves.start[k], curves.start[k + 1]
    return interpolate(curves.x[first:end], curves.y[first:end], at)
