"""Simple answers that a surrogate has to beat."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import RBFInterpolator

from billow.results.dataset_files import Parameter
from billow.rom.learn.dataset import Dataset, read_run
from billow.rom.surrogate.basis import Basis
from billow.rom.surrogate.design_space import to_unit

BASELINES = MEAN_TRAJECTORY, NEAREST_RUN, RADIAL_BASIS = "mean trajectory", "nearest run", "radial basis functions"

Predict = Callable[[np.ndarray], np.ndarray]
"""As `Surrogate.predict`: the displacement [m], (times, nodes, 3), of one design (parameters,) at the trained times."""


def baselines(dataset: Dataset, runs: tuple[str, ...], bases: tuple[Basis, ...]) -> dict[str, Predict]:
    """The answers `BASELINES`, made from `runs`, which are read once, one after the other; none holds more than a run.

    - mean trajectory: the same for every design, the mean of all runs at each time
    - nearest run: of the nearest design, every parameter's range counting as one; read on demand
    - radial basis functions: from the design to the trajectory of basis coefficients, `radial_basis`

    bases: the reduced bases of x, y and z. Raises InputError E-ROM-009 if a run holds a value that is not finite.
    """
    total, trajectories = 0.0, []
    for run in runs:
        shape = read_run(dataset, run)
        total = total + shape.astype(float)
        trajectories.append(np.stack([shape[:, :, c] @ basis.modes.T for c, basis in enumerate(bases)], axis=1))
    mean = (total / len(runs)).astype(np.float32)
    designs = dataset.design(runs)
    known = to_unit(designs, dataset.parameters)

    def nearest_run(design):
        distance = np.linalg.norm(known - to_unit(design, dataset.parameters), axis=1)
        return read_run(dataset, runs[int(distance.argmin())])

    return {
        MEAN_TRAJECTORY: lambda design: mean,
        NEAREST_RUN: nearest_run,
        RADIAL_BASIS: radial_basis(np.stack(trajectories), designs, bases, dataset.parameters),
    }


def radial_basis(
    trajectories: np.ndarray, designs: np.ndarray, bases: tuple[Basis, ...], parameters: tuple[Parameter, ...]
) -> Predict:
    """Radial basis functions from the design to the whole trajectory of basis coefficients.

    Thin-plate splines with a linear part on designs in [-1, 1]; with too few runs for a linear part (parameters + 1),
    linear splines with a constant.

    trajectories: [m], (runs, times, 3, modes), coefficients in `bases`; designs: (runs, parameters)
    """
    runs, count = designs.shape
    kernel, degree = ("thin_plate_spline", 1) if runs > count else ("linear", 0)

    def scaled(design):
        return 2.0 * to_unit(design, parameters) - 1.0

    interpolant = RBFInterpolator(scaled(designs), trajectories.reshape(runs, -1), kernel=kernel, degree=degree)

    def predict(design):
        found = interpolant(scaled(design)[None]).reshape(trajectories.shape[1:]).astype(np.float32)
        return np.stack([basis.fields(found[:, c].T) for c, basis in enumerate(bases)]).transpose(2, 1, 0)

    return predict
