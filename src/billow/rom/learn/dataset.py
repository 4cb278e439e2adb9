"""The runs that a surrogate learns from and is judged by, and how their snapshots are read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np

from billow.base.errors import InputError
from billow.results.dataset_files import Parameter
from billow.results.result import Result

TOO_FEW_RUNS = InputError.declare(
    "E-ROM-007",
    "there are too few runs to learn from",
    where="{title}",
    why="{count} training runs are complete",
    cause="the study is not finished, or --modes exceeds the number of snapshots",
    remedy="finish the study: billow study STUDY.toml --out FOLDER",
)
NOT_FINITE = InputError.declare(
    "E-ROM-009",
    "run {run} holds a {field} that is not finite",
    where="run {run}, time index {index}",
    why="a basis made from it would be meaningless",
    cause="a run folder that was written by another program",
    remedy="delete the folder of run {run} and repeat the study, which runs what is missing",
)


@runtime_checkable
class Dataset(Protocol):
    """Runs on one mesh at the same times that differ in their design. `billow.results.dataset.Dataset` is one.

    title; parameters: the axes of the design space; times: [s], (times,) float64
    reference_length: [m], by which accuracies are measured
    reference: [m], (nodes, 3) float32, the start shape; triangles: (triangles, 3) int64
    train, test: completed runs, in the order drawn; trusted: those of `train` with nothing against them
    parts: `MeshParts` of the mesh; obstacles(runs): of each run, what run.json says of them; a dataset may lack both
    missing: other runs of the design -> why; left_out: training runs not in `trusted`, missing ones too -> why
    """

    title: str
    parameters: tuple[Parameter, ...]
    times: np.ndarray
    reference_length: float
    train: tuple[str, ...]
    test: tuple[str, ...]
    missing: dict[str, str]
    reference: np.ndarray
    triangles: np.ndarray
    trusted: tuple[str, ...]
    left_out: dict[str, str]

    def design(self, runs: Sequence[str]) -> np.ndarray:
        """(runs, parameters) float64, in each parameter's unit."""

    def snapshots(self, field: str, runs: Sequence[str]) -> np.ndarray:
        """ "displacement" [m] or "contact_force" [N]: (runs, times, nodes, 3) float32."""

    def computing_seconds(self, runs: Sequence[str]) -> np.ndarray:
        """[s], (runs,): what each simulation took of the processors; 0 where that is not known."""

    def result(self, run: str) -> Result:
        """Everything one run recorded."""


class ReadOnce:
    """A dataset that keeps the displacement of every run it has read."""

    def __init__(self, dataset: Dataset):
        self._dataset, self._kept = dataset, {}

    def __getattr__(self, name):
        return getattr(self._dataset, name)

    def snapshots(self, field: str, runs: Sequence[str]) -> np.ndarray:
        """As `Dataset.snapshots`."""
        if field != "displacement":
            return self._dataset.snapshots(field, runs)
        for run in runs:
            if run not in self._kept:
                self._kept[run] = self._dataset.snapshots(field, [run])[0]
        return np.stack([self._kept[run] for run in runs])


def snapshot_bytes(dataset: Dataset, runs: Sequence[str]) -> int:
    """Size of the matrices that `collect` would make of one field: [byte]; 2,500 nodes, 48 runs, 50 times: 72 MB."""
    return 12 * len(dataset.reference) * len(dataset.times) * len(runs)


def collect(
    dataset: Dataset, runs: Sequence[str], field: str = "displacement", components: tuple[int, ...] = (0, 1, 2)
) -> np.ndarray:
    """The snapshot matrix of each component: [m] or [N], (components, nodes, runs * times) float32.

    The paper's matrix Y (Methods, offline phase); columns of one run stand together in time order. Runs are read one at
    a time, so that memory peaks at the matrices themselves.
    Raises InputError E-ROM-007 without runs, E-ROM-009 if a run holds a value that is not finite.
    """
    if not runs:
        raise TOO_FEW_RUNS(title=dataset.title or "dataset", count=0)
    count = len(dataset.times)
    matrices = np.empty((len(components), len(dataset.reference), len(runs) * count), np.float32)
    for column, run in enumerate(runs):
        shape = read_run(dataset, run, field)
        matrices[:, :, column * count : (column + 1) * count] = shape.transpose(2, 1, 0)[list(components)]
    return matrices


def read_run(dataset: Dataset, run: str, field: str = "displacement") -> np.ndarray:
    """One run: (times, nodes, 3) float32. InputError E-ROM-009 if it holds a value that is not finite."""
    shape = dataset.snapshots(field, [run])[0]
    if not np.isfinite(shape).all():
        raise NOT_FINITE(run=run, field=field, index=np.argmin(np.isfinite(shape).all((1, 2))))
    return shape
