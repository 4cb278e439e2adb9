"""Regularised regression for a flow: data are a linear image of it plus noise, and differentiation amplifies noise.

Prior: the flow is a Wiener process (a random walk between knots) of unknown strength with a free level; noise is white
and Gaussian of unknown strength. Both strengths come from the data, by restricted maximum likelihood (Patterson and
Thompson 1971; Wahba 1985 for splines). The estimate is the posterior mode subject to flow >= 0. The band is that of the
posterior: such bands include the squared bias of smoothing as well as the variance (Wahba 1983; Nychka 1988), on
average over the curve, not at each of its kinks. A Wiener process is used rather than its integral (the usual cubic
spline), because inflators start abruptly: the smoother prior cut off peaks and left them outside its band.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve, solve_triangular
from scipy.optimize import nnls

_STRENGTHS = np.logspace(-14.0, 4.0, 361)


@dataclass(frozen=True)
class Fit:
    """flow (knots,): non-negative estimate; covariance (knots, knots): of the posterior without that constraint; noise:
    standard deviation of a datum of weight one; smoothing: ratio of noise to prior variance; freedom: effective number
    of parameters."""

    flow: np.ndarray
    covariance: np.ndarray
    noise: float
    smoothing: float
    freedom: float

    @property
    def deviation(self) -> np.ndarray:
        """Posterior standard deviation at the knots, (knots,)."""
        return np.sqrt(np.diag(self.covariance))


def fit(design: np.ndarray, data: np.ndarray, knots: np.ndarray, smoothing: float | None = None) -> Fit:
    """Flow at the knots [s] from data = design @ flow + noise.

    design: (n, knots), data: (n,), divided by the relative standard deviation of each datum; smoothing: used if given,
    else found.
    """
    step = np.diff(knots)
    slopes = np.diff(np.eye(len(knots)), axis=0) / np.sqrt(step)[:, None]
    if smoothing is None:
        smoothing = _likeliest(design, data, step)
    normal = design.T @ design
    factor = np.linalg.cholesky(normal + smoothing * slopes.T @ slopes)
    towards = solve_triangular(factor, design.T @ data, lower=True)
    free = solve_triangular(factor, towards, lower=True, trans="T")
    misfit = np.sum((data - design @ free) ** 2) + smoothing * np.sum((slopes @ free) ** 2)
    variance = misfit / (len(data) - 1)
    inverse = cho_solve((factor, True), np.eye(len(knots)))
    flow, _ = nnls(factor.T, towards, maxiter=30 * len(knots))
    return Fit(flow, variance * inverse, float(np.sqrt(variance)), smoothing, float(np.sum(normal * inverse)))


def _likeliest(design: np.ndarray, data: np.ndarray, step: np.ndarray) -> float:
    """Ratio of noise variance to the prior's (per second) with the greatest restricted likelihood.

    In the coordinates (level, steps / sqrt(dt)) the prior is white; without what the level explains, the singular
    values s of the design give -2 log L = (n - 1) log(sum(z^2 l / (s^2 + l)) + rest) + sum log(1 + s^2 / l).
    """
    level = design.sum(axis=1)
    level /= np.linalg.norm(level)
    walk = np.cumsum(design[:, ::-1], axis=1)[:, -2::-1] * np.sqrt(step)  # flow after each step
    walk = walk - np.outer(level, level @ walk)
    seen = data - level * (level @ data)
    left, values, _ = np.linalg.svd(walk, full_matrices=False)
    projected = left.T @ seen
    rest = np.sum((seen - left @ projected) ** 2)
    ratio = values[0] ** 2 * _STRENGTHS[:, None]
    explained = np.sum(projected**2 * ratio / (values**2 + ratio), axis=1)
    # Data without noise would give log(0).
    power = np.maximum(explained + rest, 1e-28 * np.sum(data**2))
    criterion = (len(data) - 1) * np.log(power) + np.sum(np.log1p(values**2 / ratio), axis=1)
    return float(ratio[np.argmin(criterion), 0])
