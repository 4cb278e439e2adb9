"""The reduced-order model: from design parameters to the whole moving shape, with NumPy alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from billow.errors import InputError
from billow.results.dataset_files import Parameter
from billow.rom.basis import Basis
from billow.rom.question import check_design, check_times, design_rows
from billow.rom.regression import Regression
from billow.rom.surrogate_file import read_surrogate, write_surrogate
from billow.rom.training import learn


@dataclass(frozen=True, eq=False, repr=False)
class Surrogate:
    """A trained reduced-order model.

        surrogate = Surrogate.train(dataset)
        surrogate.save("surrogate.safetensors")
        shape = surrogate.reference + surrogate.predict({"permeability": 0.03, ...})     # [m], (times, nodes, 3)

    title: of the dataset; parameters: what a design consists of, with units and trained ranges
    times: [s], (times,) float64, the trained times
    reference: [m], (nodes, 3) float32, the start shape; triangles: (triangles, 3) int64
    bases: the reduced bases of x, y and z; regression: the networks
    training: how it was made: runs, seed, epochs, seconds, versions
    """

    title: str
    parameters: tuple[Parameter, ...]
    times: np.ndarray
    reference: np.ndarray
    triangles: np.ndarray
    bases: tuple[Basis, Basis, Basis]
    regression: Regression
    training: dict

    @classmethod
    def train(cls, dataset, recipe="shared", modes=12, runs=None, seed=0, epochs=None, progress=None) -> Surrogate:
        """Learn the displacement of a dataset's training runs. Test runs are never read.

        recipe: "shared", one ensemble of networks for all coefficients, or "paper", one network for each coefficient
        modes: K, size of each component's basis; runs: names of the runs to learn from, default `dataset.trusted`,
            the training runs with the verdict PASS
        epochs: default 60 (`shared`), 15,000 (`paper`); progress(epoch, epochs, loss) is called after each

        Same data, seed and number of BLAS threads: same bits.
        Raises InputError E-ROM-007 (too few runs or modes), E-ROM-008 (recipe), E-ROM-009 (snapshots not finite),
        E-ROM-010 (a parameter or the time has no range), ResourceError E-ROM-006 (no PyTorch), NumericalStop
        E-ROM-013 and E-ROM-014 (basis or training failed).
        """
        runs = tuple(dataset.trusted if runs is None else runs)
        return cls(**learn(dataset, recipe, modes, runs, seed, epochs, progress))

    @classmethod
    def load(cls, path: str | Path) -> Surrogate:
        """Read a file written by `save`. Errors as `read_surrogate`."""
        return cls(**read_surrogate(path))

    def save(self, path: str | Path) -> Path:
        """Write everything to one file without pickle (safetensors), atomically."""
        return write_surrogate(path, self)

    @property
    def recipe(self) -> str:
        """ "shared" or "paper"."""
        return self.regression.recipe

    @property
    def modes(self) -> int:
        """K, modes of each component."""
        return len(self.bases[0].modes)

    @property
    def nodes(self) -> int:
        return len(self.reference)

    def __repr__(self) -> str:
        learned = f"{len(self.training['runs'])} runs, {self.modes} modes, {self.nodes} nodes"
        return f"Surrogate({self.title!r}, recipe={self.recipe!r}, {learned})"

    def predict(self, design, times=None, *, extrapolate: bool = False) -> np.ndarray:
        """Displacement from the start shape: [m], (times, nodes, 3) float32; (runs, times, nodes, 3) for many designs.

        design: {name: value} or (parameters,) for one, {name: (runs,)} or (runs, parameters) for many, in the
        parameters' own units and order
        times: [s], (times,), default the trained ones; between them the networks interpolate

        The array is a view of (runs, 3, times, nodes) memory: one component of one snapshot is contiguous.
        Raises InputError E-ROM-001 (names, shape or values of the design), E-ROM-002 (a parameter outside its trained
        range), E-ROM-003 (a time outside). `extrapolate=True` lifts the last two; nothing vouches for such an answer.
        """
        rows, times, single = self._question(design, times, extrapolate)
        coefficients = self._coefficients(rows, times).transpose(0, 2, 1, 3)
        fields = np.empty((len(rows), 3, len(times), self.nodes), np.float32)
        np.matmul(coefficients, self._modes, out=fields)  # paper equation 1
        fields = fields.transpose(0, 2, 3, 1)
        return fields[0] if single else fields

    def coefficients(self, design, times=None, *, extrapolate: bool = False) -> np.ndarray:
        """Basis coefficients: [m], (times, 3, modes) float32; (runs, times, 3, modes) for many designs.

        Arguments and errors as `predict`.
        """
        rows, times, single = self._question(design, times, extrapolate)
        coefficients = self._coefficients(rows, times)
        return coefficients[0] if single else coefficients

    def spread(self, design, times=None, *, extrapolate: bool = False) -> np.ndarray:
        """How far the members of the ensemble disagree: [m], (times, 3); (runs, times, 3) for many designs.

        Standard deviation over members, as root mean square over nodes, so that it compares with the RMSE of paper
        equation 5. It ranks designs by error; as an error bar it is too small, and it does not notice extrapolation.
        Arguments and errors as `predict`; InputError E-ROM-011 for the recipe `paper`, which has no ensemble.
        """
        if self.regression.members == 1:
            raise InputError(
                "E-ROM-011",
                "this surrogate has no spread",
                where=f"recipe {self.recipe!r}",
                why="spread is the disagreement of an ensemble, and there is one network per coefficient",
                remedy='train with recipe "shared"',
            )
        rows, times, single = self._question(design, times, extrapolate)
        deviation = self.regression.by_member(rows, times).std(axis=0)
        deviation = deviation.reshape(*deviation.shape[:2], 3, self.modes)
        # The basis is orthonormal: a sum of squares over nodes is a sum of squares over modes.
        spread = np.sqrt(np.square(deviation).sum(axis=3) / self.nodes)
        return spread[0] if single else spread

    @cached_property
    def _modes(self) -> np.ndarray:
        return np.stack([basis.modes for basis in self.bases])  # (3, modes, nodes)

    def _coefficients(self, rows, times):
        return self.regression(rows, times).reshape(len(rows), len(times), 3, self.modes)

    def _question(self, design, times, extrapolate):
        rows, single = design_rows(design, self.parameters)
        if not extrapolate:
            check_design(rows, self.parameters)
        if times is None:
            return rows, self.times, single
        times = np.atleast_1d(np.asarray(times, float))
        if not extrapolate:
            check_times(times, self.times)
        return rows, times, single
