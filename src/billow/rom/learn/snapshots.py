"""Snapshot matrices: every recorded shape of every run as a column, one matrix per displacement component.

The paper's matrix Y (rom-paper, Methods, offline phase) has one column per (run, time). Components x, y and z are
kept apart, because each gets its own basis. Columns of one run stand together and in time order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError

COMPONENTS = ("x", "y", "z")
"""Index 0, 1, 2 of every array with a component axis."""


@dataclass(frozen=True)
class Snapshots:
    """Snapshots of some runs of one dataset.

    matrices: [m], (components, nodes, runs * times) float32, raw displacement from the start shape
    design: [as in parameters], (runs, parameters) float64
    times: [s], (times,) float64
    runs: names of the runs, in column order
    """

    matrices: np.ndarray
    design: np.ndarray
    times: np.ndarray
    runs: tuple[str, ...]

    @property
    def memory(self) -> int:
        """Size of the matrices: [byte]. 12 * nodes * runs * times; 2,500 nodes, 48 runs, 50 times: 72 MB."""
        return self.matrices.nbytes

    @property
    def nodes(self) -> int:
        return self.matrices.shape[1]

    def by_run(self, coefficients: np.ndarray) -> np.ndarray:
        """(components, modes, runs * times) -> (runs, times, components, modes), the order `Surrogate` answers in."""
        components, modes, _ = coefficients.shape
        split = coefficients.reshape(components, modes, len(self.runs), len(self.times))
        return np.ascontiguousarray(split.transpose(2, 3, 0, 1))


def snapshot_bytes(dataset, runs) -> int:
    """Size of the matrices that `collect` would make of one field: [byte]."""
    return 12 * len(dataset.reference) * len(dataset.times) * len(runs)


class ReadOnce:
    """A dataset that keeps the displacement of every run it has read."""

    def __init__(self, dataset):
        self._dataset, self._kept = dataset, {}

    def __getattr__(self, name):
        return getattr(self._dataset, name)

    def snapshots(self, field: str, runs) -> np.ndarray:
        """As `Dataset.snapshots`."""
        if field != "displacement":
            return self._dataset.snapshots(field, runs)
        for run in runs:
            if run not in self._kept:
                self._kept[run] = self._dataset.snapshots(field, [run])[0]
        return np.stack([self._kept[run] for run in runs])


def collect(dataset, runs, field: str = "displacement", components: tuple[int, ...] = (0, 1, 2)) -> Snapshots:
    """Read the snapshots of `runs` from a dataset, one run at a time, so that memory peaks at the matrices themselves.

    components: which have a matrix, in this order
    Raises InputError E-ROM-009 if a run holds a value that is not finite.
    """
    runs, times = tuple(runs), np.asarray(dataset.times, float)
    if not runs:
        raise InputError(
            "E-ROM-007",
            "there are no runs to learn from",
            where="dataset",
            why="the list of completed runs is empty",
            remedy="finish the study first: billow study STUDY.toml --out FOLDER",
        )
    nodes, count = len(dataset.reference), len(times)
    matrices = np.empty((len(components), nodes, len(runs) * count), np.float32)
    for column, run in enumerate(runs):
        shape = read_run(dataset, run, field)
        matrices[:, :, column * count : (column + 1) * count] = shape.transpose(2, 1, 0)[list(components)]
    return Snapshots(matrices, np.asarray(dataset.design(runs), float), times, runs)


def read_run(dataset, run: str, field: str = "displacement") -> np.ndarray:
    """One run: (times, nodes, 3) float32. InputError E-ROM-009 if it holds a value that is not finite."""
    shape = dataset.snapshots(field, [run])[0]
    if not np.isfinite(shape).all():
        raise InputError(
            "E-ROM-009",
            f"run {run} holds a {field} that is not finite",
            where=f"run {run}, time index {int(np.argmin(np.isfinite(shape).all((1, 2))))}",
            why="a basis made from it would be meaningless",
            remedy=f"delete the folder of run {run} and repeat the study, which runs what is missing",
        )
    return shape
