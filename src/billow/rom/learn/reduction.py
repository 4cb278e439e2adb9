"""From runs of a dataset to reduced bases and coefficients: in memory, block by block from disk, or on a cluster."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from billow.rom.learn.basis import Basis, pod
from billow.rom.learn.snapshots import Snapshots, collect, snapshot_bytes
from billow.rom.learn.streaming import bases_of, join, join_all, sketch

DEFAULT_MEMORY = 4 * 2**30
"""[byte] Snapshots larger than this are read block by block; 1,400 runs of 50 times and 5,000 nodes fit in."""

BLOCK_SHARE = 4
"""A block is at most this part of the memory: beside it stand the copies that reading and factoring make of it."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """What networks learn from, and what the bases cannot say.

    bases: of x, y and z; coefficients: [m], (runs, times, components, modes) float32
    design: (runs, parameters) float64; times: [s], (times,); runs: names
    lost_by_time: [m2], (components, times) float64, mean square over runs and nodes of what lies outside the basis
    lost_by_node: [m2], (components, nodes) float64, the same over runs and times
    snapshot_bytes: [byte] all snapshots; read_seconds, pod_seconds: [s] of wall time
    pod_cpu_seconds: [s] of this process' processors; where snapshots are read block by block, reading included
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
        """The same with the first `modes` modes only, as if no more had been asked for.

        Over the snapshots a basis was made from, coefficients of different modes are uncorrelated (they are the right
        singular vectors of paper equation 2), so what each cut mode leaves outside adds up.
        """
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


def reduce_runs(dataset, runs, modes: int, seed: int, memory: int = DEFAULT_MEMORY, client=None) -> Reduction:
    """Bases of `runs` of a dataset and the coefficients of every snapshot in them.

    memory: [byte]; with larger snapshots the runs are read twice, block by block, and memory stays below it (below it
    for each worker on a cluster), as long as one run with its copies fits. client: a Dask client whose workers see the
    dataset; they then do the work, always block by block. Bits depend on `memory`, not on the workers.

    Errors as `snapshots.collect` and `basis.pod`.
    """
    runs = tuple(runs)
    if client is None and snapshot_bytes(dataset, runs) <= memory:
        return _in_memory(dataset, runs, modes, seed)
    blocks = _blocks(runs, max(1, memory // (BLOCK_SHARE * snapshot_bytes(dataset, runs[:1]))))
    return _by_block(dataset, blocks, modes, seed, client)


def _in_memory(dataset, runs, modes, seed) -> Reduction:
    clock = [time.perf_counter()]
    snapshots = collect(dataset, runs)
    clock.append(time.perf_counter())
    spent = time.process_time()
    bases = tuple(pod(matrix, modes, seed) for matrix in snapshots.matrices)
    parts = [_project(snapshots, bases)]
    spent = time.process_time() - spent
    clock.append(time.perf_counter())
    return _together(dataset, parts, bases, clock[1] - clock[0], clock[2] - clock[1], spent)


def _by_block(dataset, blocks, modes, seed, client) -> Reduction:
    begun, spent = time.perf_counter(), time.process_time()
    pair = partial(join, modes=modes, seed=seed)
    if client is None:
        whole = join_all((_sketch_runs(dataset, block, modes, seed) for block in blocks), pair)
        bases = bases_of(whole, modes, seed)
        parts = [_project_runs(dataset, block, bases) for block in blocks]
    else:
        shared = client.scatter(dataset, broadcast=True)
        sketches = [client.submit(_sketch_runs, shared, block, modes, seed, pure=False) for block in blocks]
        whole = join_all(sketches, lambda one, other: client.submit(pair, one, other, pure=False)).result()
        bases = bases_of(whole, modes, seed)
        known = client.scatter(bases, broadcast=True, hash=False)
        parts = client.gather([client.submit(_project_runs, shared, block, known, pure=False) for block in blocks])
    # Reading and factoring alternate, so the time of both counts as the basis'.
    return _together(dataset, parts, bases, 0.0, time.perf_counter() - begun, time.process_time() - spent)


@dataclass(frozen=True, eq=False)
class _Part:
    """Some runs in the bases. coefficients: (runs, times, components, modes); the sums of squares that stay outside:
    by_time (components, times), by_node (components, nodes)."""

    runs: tuple[str, ...]
    coefficients: np.ndarray
    by_time: np.ndarray
    by_node: np.ndarray
    snapshot_bytes: int


def _blocks(runs, count) -> list[tuple[str, ...]]:
    return [runs[first : first + count] for first in range(0, len(runs), count)]


def _sketch_runs(dataset, runs, modes, seed):
    return sketch(collect(dataset, runs).matrices, modes, seed)


def _project_runs(dataset, runs, bases) -> _Part:
    return _project(collect(dataset, runs), bases)


def _project(snapshots: Snapshots, bases: tuple[Basis, ...]) -> _Part:
    count, times = len(snapshots.runs), len(snapshots.times)
    coefficients = np.empty((len(bases), len(bases[0].modes), count * times), np.float32)
    by_time, by_node = np.zeros((len(bases), times)), np.zeros((len(bases), snapshots.nodes))
    for component, basis in enumerate(bases):
        matrix = snapshots.matrices[component]
        coefficients[component] = basis.coefficients(matrix)
        for run in range(count):  # one run at a time: the residual of all would be as large as the snapshots
            columns = slice(run * times, (run + 1) * times)
            outside = np.square(matrix[:, columns] - basis.fields(coefficients[component][:, columns]))
            by_time[component] += outside.sum(axis=0, dtype=float)
            by_node[component] += outside.sum(axis=1, dtype=float)
    return _Part(snapshots.runs, snapshots.by_run(coefficients), by_time, by_node, snapshots.memory)


def _together(dataset, parts, bases, read_seconds, pod_seconds, pod_cpu_seconds) -> Reduction:
    runs = tuple(run for part in parts for run in part.runs)
    times = np.asarray(dataset.times, float)
    by_time, by_node = sum(part.by_time for part in parts), sum(part.by_node for part in parts)
    return Reduction(
        bases=bases,
        coefficients=np.concatenate([part.coefficients for part in parts]),
        design=np.asarray(dataset.design(runs), float),
        times=times,
        runs=runs,
        lost_by_time=by_time / (len(runs) * by_node.shape[1]),
        lost_by_node=by_node / (len(runs) * len(times)),
        snapshot_bytes=sum(part.snapshot_bytes for part in parts),
        read_seconds=read_seconds,
        pod_seconds=pod_seconds,
        pod_cpu_seconds=pod_cpu_seconds,
    )
