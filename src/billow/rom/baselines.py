"""What a surrogate has to beat: answers that need no network.

Every baseline is made from training runs and asked like a surrogate: `predict(design)` gives the displacement
[m], (times, nodes, 3) of one design (parameters,), at the trained times.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import RBFInterpolator

from billow.rom.basis import Basis
from billow.rom.snapshots import Snapshots


class MeanTrajectory:
    """The same answer for every design: the mean of all training runs at each time."""

    name = "mean trajectory"

    def __init__(self, snapshots: Snapshots):
        runs, times = len(snapshots.runs), len(snapshots.times)
        by_run = snapshots.matrices.reshape(3, snapshots.nodes, runs, times)
        self._mean = np.ascontiguousarray(by_run.mean(axis=2).transpose(2, 1, 0))

    def predict(self, design: np.ndarray) -> np.ndarray:
        return self._mean


class NearestRun:
    """The training run whose design is nearest, every parameter's range counting as one."""

    name = "nearest run"

    def __init__(self, snapshots: Snapshots, low: np.ndarray, high: np.ndarray):
        self._snapshots, self._low, self._range = snapshots, low, high - low
        self._designs = (snapshots.design - low) / self._range

    def predict(self, design: np.ndarray) -> np.ndarray:
        distance = np.linalg.norm(self._designs - (design - self._low) / self._range, axis=1)
        times = len(self._snapshots.times)
        first = int(distance.argmin()) * times
        return self._snapshots.matrices[:, :, first : first + times].transpose(2, 1, 0)


class RadialBasis:
    """Radial basis functions from the design to the whole trajectory of basis coefficients.

    Thin-plate splines with a linear part on designs in [-1, 1]; with too few runs for a linear part (parameters + 1),
    linear splines with a constant.
    """

    name = "radial basis functions"

    def __init__(self, snapshots: Snapshots, bases: tuple[Basis, ...], low: np.ndarray, high: np.ndarray):
        self._bases, self._low, self._range = bases, low, high - low
        coefficients = np.stack([b.coefficients(m) for b, m in zip(bases, snapshots.matrices, strict=True)])
        trajectories = snapshots.by_run(coefficients)  # (runs, times, 3, modes)
        self._shape = trajectories.shape[1:]
        runs, parameters = snapshots.design.shape
        enough = runs > parameters
        self._interpolant = RBFInterpolator(
            self._scaled(snapshots.design),
            trajectories.reshape(runs, -1),
            kernel="thin_plate_spline" if enough else "linear",
            degree=1 if enough else 0,
        )

    def predict(self, design: np.ndarray) -> np.ndarray:
        coefficients = self._interpolant(self._scaled(design)[None]).reshape(self._shape).astype(np.float32)
        fields = [basis.fields(coefficients[:, c].T) for c, basis in enumerate(self._bases)]
        return np.stack(fields).transpose(2, 1, 0)

    def _scaled(self, design):
        return 2.0 * (design - self._low) / self._range - 1.0
