"""Proper orthogonal decomposition of snapshot matrices (paper equations 1 and 2), in one piece or block by block
(docs/theory.md, Reduced basis)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from billow.base.errors import NumericalStop
from billow.rom.learn.dataset import TOO_FEW_RUNS
from billow.rom.surrogate.basis import Basis

NOT_ORTHONORMAL = NumericalStop.declare(
    "E-ROM-013",
    "the reduced basis is not orthonormal ({measured})",
    where="proper orthogonal decomposition",
    why="the linear algebra library returned a wrong factorisation, or snapshots overflow float32",
    remedy="check the displacements of the runs for values beyond 1e15 m",
)

OVERSAMPLING = 24
POWER_ITERATIONS = 3
"""For wrinkled fabric, whose spectrum is flat."""


def pod(snapshots: np.ndarray, modes: int, seed: int = 0) -> Basis:
    """Reduced basis by randomized SVD, cut after `modes` modes. snapshots: [m], (nodes, columns) float32.

    Same seed, same bits (for the same number of BLAS threads).
    Raises InputError E-ROM-007 if there are not that many modes, NumericalStop E-ROM-013 if snapshots overflow float32.
    """
    check_count(snapshots.shape, modes)
    left, singular = factor(snapshots, min(modes + OVERSAMPLING, *snapshots.shape), seed)
    return make_basis(left, singular, sum_of_squares(snapshots), modes)


def factor(matrix: np.ndarray, rank: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """The first left singular vectors, (rows, rank) float64, and their singular values, (rank,) float64, falling.

    matrix: (rows, columns) float32. Every product with the data is followed by a float64 QR, so that small modes are
    not drowned in float32 rounding. NumericalStop E-ROM-013 if a product overflows.
    """
    start = np.random.default_rng(seed).standard_normal((matrix.shape[1], rank), dtype=np.float32)
    with np.errstate(over="ignore", invalid="ignore"):  # an overflow stays one to the end and is raised below
        columns = _orthonormal(matrix @ start)
        for _ in range(POWER_ITERATIONS):
            rows = _orthonormal(matrix.T @ columns.astype(np.float32))
            columns = _orthonormal(matrix @ rows.astype(np.float32))
        # B = Q^T Y is small and wide. B^T = Q' R gives B the left vectors of R^T; its condition is not squared.
        wide = matrix.T @ columns.astype(np.float32)
    if not np.isfinite(wide).all():
        raise NOT_ORTHONORMAL(measured="a product with the snapshots overflowed")
    left, singular, _ = np.linalg.svd(np.linalg.qr(wide.astype(float), mode="r").T, full_matrices=False)
    return columns @ left, singular


def orthogonality_error(modes: np.ndarray) -> float:
    """Largest entry of |U^T U - I|: [-]. modes: (modes, nodes)."""
    wide = modes.astype(float)
    return float(np.abs(wide @ wide.T - np.eye(len(modes))).max())


def check_count(shape: tuple[int, int], modes: int) -> None:
    """InputError E-ROM-007 unless a snapshot matrix of (nodes, columns) has that many modes."""
    most = min(shape)
    if not 1 <= modes <= most:
        raise TOO_FEW_RUNS(
            what=f"{modes} modes cannot be made",
            where=f"a snapshot matrix of {shape[0]} nodes by {shape[1]} snapshots",
            why=f"it has between 1 and {most} modes",
            remedy=f"choose modes between 1 and {most}, or add runs",
        )


def make_basis(left: np.ndarray, singular: np.ndarray, energy: float, modes: int) -> Basis:
    """The basis of the first `modes` left singular vectors, (nodes, at least modes) float64; NumericalStop E-ROM-013 if
    they are not orthonormal."""
    kept = np.ascontiguousarray(left[:, :modes].T)
    # A singular vector is free to change sign; fixing it makes bases of two machines comparable.
    largest = np.take_along_axis(kept, np.abs(kept).argmax(axis=1)[:, None], axis=1)
    kept = (kept * np.sign(largest)).astype(np.float32)
    error = orthogonality_error(kept)
    if not error < 1e-5:
        raise NOT_ORTHONORMAL(measured=f"largest deviation {error:.1e}, limit 1e-5")
    return Basis(kept, singular, energy)


def sum_of_squares(snapshots: np.ndarray) -> float:
    """Squared Frobenius norm: [m2]."""
    # Summed in float64, one row at a time: a float32 sum over 10^8 squares would lose the digits the tail needs.
    return float(sum(np.square(row, dtype=float).sum() for row in snapshots))


def _orthonormal(matrix):
    return np.linalg.qr(matrix.astype(float))[0]


@dataclass(frozen=True)
class Sketch:
    """What is kept of some snapshots of all components: scaled [m], (components, nodes, rank) float32, is U S; energy
    [m2], (components,); columns, the number of snapshots."""

    scaled: np.ndarray
    energy: np.ndarray
    columns: int


def sketch(block: np.ndarray, modes: int, seed: int) -> Sketch:
    """The sketch of a block of snapshots. block: [m], (components, nodes, columns) float32."""
    energy = np.array([sum_of_squares(component) for component in block])
    return Sketch(_cut(block, modes, seed), energy, block.shape[2])


def join(one: Sketch, other: Sketch, modes: int, seed: int) -> Sketch:
    """The sketch of two groups of snapshots together."""
    both = np.concatenate([one.scaled, other.scaled], axis=2)
    return Sketch(_cut(both, modes, seed), one.energy + other.energy, one.columns + other.columns)


def bases_of(whole: Sketch, modes: int, seed: int) -> tuple[Basis, ...]:
    """The reduced basis of each component. Errors as `pod`."""
    nodes = whole.scaled.shape[1]
    check_count((nodes, whole.columns), modes)
    made = []
    for scaled, energy in zip(whole.scaled, whole.energy, strict=True):
        left, singular = factor(scaled, min(modes + OVERSAMPLING, *scaled.shape), seed)
        made.append(make_basis(left, singular, float(energy), modes))
    return tuple(made)


def join_all(parts: Iterable, pair: Callable):
    """Join parts as a binary tree, in order, with never more than log2(parts) + 2 of them in memory."""
    waiting = []  # (number of parts in it, joined), falling powers of two
    for part in parts:
        size = 1
        while waiting and waiting[-1][0] == size:
            size, part = 2 * size, pair(waiting.pop()[1], part)
        waiting.append((size, part))
    whole = waiting.pop()[1]
    while waiting:
        whole = pair(waiting.pop()[1], whole)
    return whole


def _cut(matrices: np.ndarray, modes: int, seed: int) -> np.ndarray:
    """(components, nodes, columns) -> U S, (components, nodes, rank)."""
    rank = modes + 2 * OVERSAMPLING  # joining cuts again and again, so it needs more than one factorisation does
    if matrices.shape[2] <= rank:
        return matrices
    scaled = np.empty((*matrices.shape[:2], min(rank, matrices.shape[1])), np.float32)
    for component, matrix in enumerate(matrices):
        left, singular = factor(matrix, scaled.shape[2], seed)
        scaled[component] = left * singular
    return scaled
