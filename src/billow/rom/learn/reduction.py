"""From runs of a dataset to reduced bases and coefficients: in memory, block by block from disk, or on a cluster."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from billow.rom.learn.dataset import Dataset, collect, snapshot_bytes
from billow.rom.learn.pod import bases_of, join, join_all, pod, sketch
from billow.rom.surrogate.basis import Basis

DEFAULT_MEMORY = 4 * 2**30
"""[byte] Snapshots larger than this are read block by block; 1,400 runs of 50 times and 5,000 nodes fit in."""

BLOCK_SHARE = 4
"""A block is at most this part of the memory: the rest holds the copies that reading and factoring make of it."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """What networks learn from, and what the bases cannot represent.

    bases: of x, y and z; coefficients: [m], (runs, times, components, modes) float32
    design: (runs, parameters) float64; times: [s], (times,); runs: names
    lost_by_time: [m2], (components, times) float64, mean square over runs and nodes of what lies outside the basis
    lost_by_node: [m2], (components, nodes) float64, the same over runs and times
    snapshot_bytes: [byte] all snapshots; read_seconds, pod_seconds: [s] of wall time; pod_cpu_seconds: [s] of this
        process' processors, reading included where snapshots are read block by block
    """

    bases: tuple[Basis, ...]
    coefficients: np.ndarray
    design: np.ndarray
    times: np.ndarray
    runs: tuple[str, ...]
    lost_by_time: np.ndarray
    lost_by_node: np.ndarray
    snapshot_bytes: int
    read_seconds: float
    pod_seconds: float
    pod_cpu_seconds: float

    def cut(self, modes: int) -> Reduction:
        """The same with the first `modes` modes only, as if reduced to that many: coefficients of different modes are
        uncorrelated (right singular vectors of paper equation 2), so what each cut mode leaves outside adds up."""
        squares = np.square(self.coefficients[..., modes:], dtype=float)  # (runs, times, components, cut)
        by_mode = squares.mean(axis=(0, 1))
        fields = [np.square(basis.modes[modes:], dtype=float) for basis in self.bases]
        nodes = self.lost_by_node.shape[1]
        return replace(
            self,
            bases=tuple(replace(basis, modes=basis.modes[:modes]) for basis in self.bases),
            coefficients=np.ascontiguousarray(self.coefficients[..., :modes]),
            lost_by_time=self.lost_by_time + squares.mean(axis=0).sum(axis=2).T / nodes,
            lost_by_node=self.lost_by_node + np.stack([m @ f for m, f in zip(by_mode, fields, strict=True)]),
        )


def reduce_runs(dataset: Dataset, runs, modes: int, seed: int, memory: int = DEFAULT_MEMORY, client=None) -> Reduction:
    """Bases of `runs` of a dataset and the coefficients of every snapshot in them.

    memory: [byte], also of each worker; larger snapshots are read twice, block by block, of at least one run
    client: a Dask client whose workers see the dataset; they then do the work, always block by block. Bits depend on
        `memory`, not on the workers. Errors as `collect` and `pod`.
    """
    runs, times = tuple(runs), np.asarray(dataset.times, float)
    begun, spent, read_seconds = time.perf_counter(), time.process_time(), 0.0
    if client is None and snapshot_bytes(dataset, runs) <= memory:
        matrices = collect(dataset, runs)
        read_seconds, spent = time.perf_counter() - begun, time.process_time()
        bases = tuple(pod(matrix, modes, seed) for matrix in matrices)
        parts = [_project(matrices, bases, len(times))]
    else:
        blocks = blocks_of(runs, memory // (BLOCK_SHARE * snapshot_bytes(dataset, runs[:1])))
        bases, parts = _by_block(dataset, blocks, modes, seed, client)
    coefficients, by_time, by_node = zip(*parts, strict=True)
    return Reduction(
        bases=bases,
        coefficients=np.concatenate(coefficients),
        design=np.asarray(dataset.design(runs), float),
        times=times,
        runs=runs,
        lost_by_time=sum(by_time) / (len(runs) * len(dataset.reference)),
        lost_by_node=sum(by_node) / (len(runs) * len(times)),
        snapshot_bytes=snapshot_bytes(dataset, runs),
        read_seconds=read_seconds,
        pod_seconds=time.perf_counter() - begun - read_seconds,
        pod_cpu_seconds=time.process_time() - spent,
    )


def blocks_of(runs: tuple[str, ...], count: int) -> list[tuple[str, ...]]:
    """Runs in blocks of `count`, at least one."""
    count = max(1, count)
    return [runs[first : first + count] for first in range(0, len(runs), count)]


def _by_block(dataset, blocks, modes, seed, client) -> tuple[tuple[Basis, ...], list]:
    def do(task, *arguments):
        return client.submit(task, *arguments, pure=False) if client else task(*arguments)

    shared = client.scatter(dataset, broadcast=True) if client else dataset
    sketches = (do(_sketch_runs, shared, block, modes, seed) for block in blocks)
    whole = join_all(sketches, lambda one, other: do(join, one, other, modes, seed))
    bases = bases_of(whole.result() if client else whole, modes, seed)
    known = client.scatter(bases, broadcast=True, hash=False) if client else bases
    parts = [do(_project_runs, shared, block, known) for block in blocks]
    return bases, client.gather(parts) if client else parts


def _sketch_runs(dataset, runs, modes, seed):
    return sketch(collect(dataset, runs), modes, seed)


def _project_runs(dataset, runs, bases):
    return _project(collect(dataset, runs), bases, len(dataset.times))


def _project(matrices, bases, times: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coefficients (runs, times, components, modes), and the sums of squares that stay outside the bases: over runs
    and nodes (components, times), over runs and times (components, nodes)."""
    components, nodes, columns = matrices.shape
    coefficients = np.empty((components, len(bases[0].modes), columns), np.float32)
    by_time, by_node = np.zeros((components, times)), np.zeros((components, nodes))
    for component, (basis, matrix) in enumerate(zip(bases, matrices, strict=True)):
        coefficients[component] = basis.coefficients(matrix)
        for first in range(0, columns, times):  # one run at a time: the residual of all would be as large as matrices
            run = slice(first, first + times)
            outside = np.square(matrix[:, run] - basis.fields(coefficients[component][:, run]))
            by_time[component] += outside.sum(axis=0, dtype=float)
            by_node[component] += outside.sum(axis=1, dtype=float)
    by_run = coefficients.reshape(components, -1, columns // times, times).transpose(2, 3, 0, 1)
    return np.ascontiguousarray(by_run), by_time, by_node
