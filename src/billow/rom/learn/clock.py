"""Finding the clocks of designs: those by which the runs look most alike.

One motion for all runs, a cubic spline over common time, is fitted to the strongest coefficients together with the
clocks. Bounces may be off by more than half a period, where least squares would lock onto a wrong one: so the first
part of the runs is fitted first, and the window grows. What is found there for the rates carries on into the next part.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import minimize

from billow.base.blas_threads import one_blas_thread
from billow.results.dataset_files import Parameter
from billow.rom.learn.simple_answers import radial_basis
from billow.rom.surrogate.clock import FARTHEST, LARGEST, Clock
from billow.rom.surrogate.design_space import distinct
from billow.rom.surrogate.polynomial import terms
from billow.rom.surrogate.regression import OutputScaling

PARTS = 8
WINDOWS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Parts of the recorded time that are fitted one after the other."""
STEPS = 50
"""Of the optimiser in each window, at most."""
MODES = 4
"""Of each component, by which clocks are found."""

RATE, REACH = 0.4, 0.25
"""Expected deviation of the logarithm of a rate, and the part of the recorded time over which it changes."""
LINEAR, QUADRATIC, OWN = 0.75, 0.3, 0.01
"""Parts of the variance of a rate that are expected to be linear in the design, quadratic, and of one run only. The
last keeps runs that do not fit from bending the clocks of the others; it is no part of the answer."""
TRUST = 30.0
"""Weight of a run beside these expectations, if all of its departure from the mean were explained."""

FINER = 4
"""Times of the output scaling in each recorded interval."""

FOLDS, ENOUGH_RUNS = 4, 60
"""Runs are held out a fold at a time, until so many have been."""


@one_blas_thread()
def learn_clock(centred: np.ndarray, times: np.ndarray, coefficients: np.ndarray) -> tuple[Clock, OutputScaling]:
    """The clock, and the scaling of coefficients by it; where nothing departs from the mean, all clocks are alike.

    centred: (runs, parameters), every range from -1 to 1; times: [s], (times,); coefficients: [m], (runs, times,
    components, modes)
    """
    strongest = coefficients[..., :MODES].reshape(*coefficients.shape[:2], -1).astype(float)
    departure = np.square(strongest - strongest.mean(axis=0)).sum()
    departure = max(departure, 1e-12 * np.square(strongest).sum()) or 1.0
    last, motion = float(times[-1]), Motion(float(times[-1]) / len(times), FARTHEST * float(times[-1]))
    spent = Clock(np.zeros((1, PARTS)), last).spent(times)
    design = terms(centred, True)[:, 1:]
    linear = centred.shape[1]
    size = np.repeat(
        np.sqrt([LINEAR / linear, QUADRATIC / (design.shape[1] - linear)]), [linear, design.shape[1] - linear]
    )
    centre = design.mean(axis=0)
    own = np.sqrt(OWN) * (np.eye(len(design)) - 1.0 / len(design))
    rows = np.column_stack([(design - centre) * size, own])
    middle = (np.arange(PARTS) + 0.5) / PARTS
    alike = 0.5 + 0.5 * np.exp(-np.abs(middle[:, None] - middle) / REACH)
    root = np.linalg.cholesky(RATE**2 * alike)
    weight = TRUST * len(design) / departure

    def objective(flat: np.ndarray, within: np.ndarray) -> tuple[float, np.ndarray]:
        standard = flat.reshape(-1, PARTS)
        logarithms = rows @ standard @ root.T
        rates = np.exp(np.clip(logarithms, -LARGEST, LARGEST))
        error, slope = motion.fit((rates @ spent)[:, within], strongest[:, within])
        # The motion is the best one for these clocks, so that to first order it does not change with them.
        by_time = -2.0 * weight * (error * slope).sum(axis=2)
        by_logarithm = (by_time @ spent[:, within].T) * rates * (np.abs(logarithms) < LARGEST)
        value = weight * np.square(error).sum() + 0.5 * np.square(standard).sum()
        return value, (rows.T @ by_logarithm @ root + standard).ravel()

    flat = np.zeros(rows.shape[1] * PARTS)
    for window in WINDOWS:
        within = times <= window * last * (1.0 + 1e-9)
        if within.any():
            found = minimize(objective, flat, (within,), "L-BFGS-B", jac=True, options={"maxiter": STEPS})
            flat = found.x
    of_design = size[:, None] * (flat.reshape(-1, PARTS) @ root.T)[: len(size)]
    clock = Clock(np.concatenate([-(centre @ of_design)[None], of_design]), last)
    outputs = motion.scaling(clock(centred, times), coefficients)
    return replace(clock, reach=float(outputs.times[-1])), outputs


@one_blas_thread()
def clock_helps(
    designs: np.ndarray, parameters: tuple[Parameter, ...], centred: np.ndarray, times: np.ndarray, known: np.ndarray
) -> bool:
    """True if radial basis functions predict runs held out better from the others at the same common times than from
    the others at the same own times. A clock that imitates what is no matter of time, such as a larger bag, does harm;
    networks agree with this test, and take far longer (docs/rom.md).

    designs: (runs, parameters); known: [m], coefficients (runs, times, components, modes); else as `learn_clock`
    """
    groups, own, by_clock, held = distinct(designs, parameters), 0.0, 0.0, 0
    known = known.astype(float)
    for fold in range(FOLDS):
        if held >= ENOUGH_RUNS:
            break
        out = [row for group in groups[fold::FOLDS] for row in group]
        others = np.setdiff1d(np.arange(len(known)), out)
        clock, _ = learn_clock(centred[others], times, known[others])
        common = clock(centred, times)
        plain = radial_basis(designs[others], known[others], parameters)
        held += len(out)
        for row in out:
            moved = np.stack([_at_common(times, common[k], known[k], common[row]) for k in others])
            answer = radial_basis(designs[others], moved, parameters)(designs[row])
            own += np.sqrt(np.square(plain(designs[row]) - known[row]).sum())
            by_clock += np.sqrt(np.square(answer - known[row]).sum())
    return by_clock < own


def _at_common(times: np.ndarray, common: np.ndarray, values: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Values of a run (times, ...) when its clock shows the common times asked; after its end, the last ones."""
    own = np.interp(asked, np.append(0.0, common), np.append(0.0, times))
    after = np.clip(np.searchsorted(times, own), 1, len(times) - 1)
    part = np.clip((own - times[after - 1]) / (times[after] - times[after - 1]), 0.0, 1.0)
    part = part.reshape(-1, *np.ones(values.ndim - 1, int))
    return values[after - 1] * (1.0 - part) + values[after] * part


class Motion:
    """Cubic splines over common time, fitted to runs."""

    STIFFNESS, HELD = 0.1, 0.01
    """Weights of the change between neighbouring splines, and of their own size, against one sample: where no run is,
    the motion stands still."""

    def __init__(self, spacing: float, end: float):
        """spacing, end: [s], between knots, and of common time."""
        inner = np.arange(0.0, end + spacing, spacing)
        self.end = end
        self.knots = np.concatenate([np.zeros(3), inner, np.full(3, inner[-1])])
        self._times = np.arange(0.0, end + spacing / FINER, spacing / FINER)
        difference = np.diff(np.eye(len(self.knots) - 4), axis=0)
        self._prior = self.STIFFNESS * difference.T @ difference + self.HELD * np.eye(len(self.knots) - 4)

    def fit(self, common: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What the motion does not explain of values (runs, times, n), and its slope there, [1/s], the same shape.
        common: [s], (runs, times)."""
        inside = self._inside(common)
        spline, error = self._spline(inside, values)
        slope = spline.derivative()(inside) * (common.ravel() < self.end)[:, None]
        return error.reshape(values.shape), slope.reshape(values.shape)

    def scaling(self, common: np.ndarray, coefficients: np.ndarray) -> OutputScaling:
        """The motion as the mean, and as the deviation the root mean square of what it does not explain of the
        strongest mode of each component, nearby in common time, as far as the runs get. Arguments as `fit` and
        `learn_clock`."""
        inside, shape = self._inside(common), coefficients.shape[2:]
        spline, error = self._spline(inside, coefficients.reshape(*common.shape, -1))
        basis = BSpline.design_matrix(inside, self.knots, 3)
        squares = np.square(error)
        overall = squares.mean(axis=0)
        near = np.asarray(basis.sum(axis=0)).reshape(-1, 1)
        # Weights of splines are positive and add up to one: a local mean.
        local = (basis.T @ squares + self.HELD * overall) / (near + self.HELD)
        known = self._times[: max(int(np.searchsorted(self._times, common.max())) + 1, 2)]
        times = np.minimum(known, self.end)
        square = BSpline(self.knots, local, 3)(self._inside(times)).reshape(-1, *shape).max(axis=2)
        square = np.maximum(square, 1e-4 * overall.reshape(shape).max(axis=1))
        least = max(1e-9 * np.abs(coefficients).max(), 1e-30)
        deviation = np.repeat(np.maximum(np.sqrt(square), least), shape[1], axis=1)
        mean = spline(self._inside(times))
        return OutputScaling(known, mean.astype(np.float32), deviation.astype(np.float32))

    def _spline(self, inside, values) -> tuple[BSpline, np.ndarray]:
        basis = BSpline.design_matrix(inside, self.knots, 3)
        rows = values.reshape(len(inside), -1)
        weights = np.linalg.solve((basis.T @ basis).toarray() + self._prior, basis.T @ rows)
        return BSpline(self.knots, weights, 3), rows - basis @ weights

    def _inside(self, common):
        return np.minimum(common.ravel(), self.end)
