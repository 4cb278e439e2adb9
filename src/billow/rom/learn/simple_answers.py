"""Answers that need no learning, in the coefficients of a basis: what a surrogate has to beat."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import RBFInterpolator

from billow.results.dataset_files import Parameter
from billow.rom.surrogate.design_space import distinct, to_unit
from billow.rom.surrogate.judgement import Comparison

BASELINES = MEAN_TRAJECTORY, NEAREST_RUN, RADIAL_BASIS = "mean trajectory", "nearest run", "radial basis functions"

MEASURE = "nodes are off by [mm]"
"""By which a surrogate is compared with simple answers: root mean square over nodes and times, mean over runs."""

Coefficients = Callable[[np.ndarray], np.ndarray]
"""From a design (parameters,) to a trajectory of basis coefficients: [m], (times, 3, modes)."""


def simple_coefficients(
    designs: np.ndarray, trajectories: np.ndarray, parameters: tuple[Parameter, ...]
) -> dict[str, Coefficients]:
    """The answers `BASELINES`. designs: (runs, parameters); trajectories: [m], (runs, times, 3, modes)."""
    mean, known = trajectories.mean(axis=0), to_unit(designs, parameters)
    return {
        MEAN_TRAJECTORY: lambda design: mean,
        NEAREST_RUN: lambda design: trajectories[nearest(known, to_unit(design, parameters))],
        RADIAL_BASIS: radial_basis(designs, trajectories, parameters),
    }


def nearest(known: np.ndarray, asked: np.ndarray) -> int:
    """Row of `known` (runs, parameters) nearest to `asked` (parameters,)."""
    return int(np.linalg.norm(known - asked, axis=1).argmin())


def radial_basis(designs: np.ndarray, trajectories: np.ndarray, parameters: tuple[Parameter, ...]) -> Coefficients:
    """Thin-plate splines with a linear part on designs in [-1, 1]; linear splines with a constant if the designs are
    too few for that (parameters + 1) or do not span the space. Runs of one design count as one run, their mean.

    Arguments as `simple_coefficients`.
    """
    groups = distinct(designs, parameters)
    points = np.stack([to_unit(designs[group], parameters).mean(axis=0) for group in groups]) * 2.0 - 1.0
    values = np.stack([trajectories[group].mean(axis=0) for group in groups])
    if len(points) == 1:
        return lambda design: values[0]
    spanned = np.linalg.matrix_rank(np.column_stack([np.ones(len(points)), points]), tol=1e-6) == points.shape[1] + 1
    kernel, degree = ("thin_plate_spline", 1) if spanned and len(points) > points.shape[1] else ("linear", 0)
    interpolant = RBFInterpolator(points, values.reshape(len(points), -1), kernel=kernel, degree=degree)
    shape = trajectories.shape[1:]
    return lambda design: interpolant(2.0 * to_unit(design, parameters)[None] - 1.0).reshape(shape).astype(np.float32)


def comparisons(own: float, others: dict[str, float]) -> tuple[Comparison, ...]:
    """own, others: [m], `MEASURE` of a surrogate and of `BASELINES`."""
    return tuple(
        Comparison(MEASURE, name, 1e3 * own, 1e3 * other, ignores_design=name == MEAN_TRAJECTORY)
        for name, other in others.items()
    )
