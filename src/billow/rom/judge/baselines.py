"""What a surrogate has to beat: answers that need no network.

Every baseline is made from training runs and asked like a surrogate: `predict(design)` gives the displacement
[m], (times, nodes, 3) of one design (parameters,), at the trained times. `baselines` makes them all, and none of them
holds more than one run.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import RBFInterpolator

from billow.rom.learn.basis import Basis
from billow.rom.learn.snapshots import read_run


def baselines(dataset, runs: tuple[str, ...], bases: tuple[Basis, ...]) -> tuple:
    """`MeanTrajectory`, `NearestRun` and `RadialBasis` of some runs, which are read once, one after the other.

    bases: the reduced bases of x, y and z. Raises InputError E-ROM-009 if a run holds a value that is not finite.
    """
    total, trajectories = 0.0, []
    for run in runs:
        shape = read_run(dataset, run)
        total = total + shape.astype(float)
        trajectories.append(np.stack([shape[:, :, c] @ basis.modes.T for c, basis in enumerate(bases)], axis=1))
    low, high = (np.array([getattr(p, side) for p in dataset.parameters], float) for side in ("low", "high"))
    return (
        MeanTrajectory((total / len(runs)).astype(np.float32)),
        NearestRun(dataset, runs, low, high),
        RadialBasis(np.stack(trajectories), dataset.design(runs), bases, low, high),
    )


class MeanTrajectory:
    """The same answer for every design: the mean of all training runs at each time, [m], (times, nodes, 3)."""

    name = "mean trajectory"

    def __init__(self, mean: np.ndarray):
        self._mean = mean

    def predict(self, design: np.ndarray) -> np.ndarray:
        return self._mean


class NearestRun:
    """The training run whose design is nearest, every parameter's range counting as one; read when it is asked for.

    low, high: (parameters,), the ranges
    """

    name = "nearest run"

    def __init__(self, dataset, runs: tuple[str, ...], low: np.ndarray, high: np.ndarray):
        self._dataset, self._runs, self._low, self._range = dataset, runs, low, high - low
        self._designs = (dataset.design(runs) - low) / self._range

    def predict(self, design: np.ndarray) -> np.ndarray:
        distance = np.linalg.norm(self._designs - (design - self._low) / self._range, axis=1)
        return read_run(self._dataset, self._runs[int(distance.argmin())])


class RadialBasis:
    """Radial basis functions from the design to the whole trajectory of basis coefficients.

    Thin-plate splines with a linear part on designs in [-1, 1]; with too few runs for a linear part (parameters + 1),
    linear splines with a constant.

    trajectories: [m], (runs, times, 3, modes), coefficients in `bases`; designs: (runs, parameters)
    """

    name = "radial basis functions"

    def __init__(
        self,
        trajectories: np.ndarray,
        designs: np.ndarray,
        bases: tuple[Basis, ...],
        low: np.ndarray,
        high: np.ndarray,
    ):
        self._bases, self._low, self._range = bases, low, high - low
        self._shape = trajectories.shape[1:]
        runs, parameters = designs.shape
        enough = runs > parameters
        self._interpolant = RBFInterpolator(
            self._scaled(designs),
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
