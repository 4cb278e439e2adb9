"""Proper orthogonal decomposition of a snapshot matrix.

Paper equations 1 and 2: Y = U S V^T, the reduced basis is the first K columns of U, coefficients are U^T Y. The
snapshots are used raw, as in the paper: displacement is zero in the start shape, so "no motion" is the natural
origin. Subtracting the mean shape first was measured and is no better (membrane bag, 48 runs, 12 modes, unseen runs,
z: 1.231 mm raw, 1.234 mm centred, 1.210 mm with the mean as a 13th mode).

`pod` is the randomized algorithm (Halko, Martinsson, Tropp 2011, algorithms 4.4 and 5.1): passes over the data in
float32, small factorisations in float64. `exact_pod` is the plain SVD that tests hold it against.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError, NumericalStop

OVERSAMPLING = 24
POWER_ITERATIONS = 3
"""Projection error above the best of 12 modes: wrinkled fabric has a flat spectrum, and oversampling 12 with q = 2,
enough for smooth shapes (5e-7), leaves 1e-3 there and 1 % in the last singular value. 24 with q = 3 leaves 1e-5 and
2e-4 for twice the time; without power iterations (q = 0) it is 0.1 to 0.2, useless."""


@dataclass(frozen=True)
class Basis:
    """Reduced basis of one displacement component.

    modes: [-], (modes, nodes) float32, orthonormal rows; the largest entry of each is positive
    singular_values: [m], (values,) float64, falling; at least as many as modes (the extra ones show the decay)
    energy: [m2], squared Frobenius norm of all snapshots
    """

    modes: np.ndarray
    singular_values: np.ndarray
    energy: float

    def coefficients(self, snapshots: np.ndarray) -> np.ndarray:
        """U^T Y of paper equation 2: [m], (nodes, columns) -> (modes, columns) float32."""
        return self.modes @ snapshots

    def fields(self, coefficients: np.ndarray) -> np.ndarray:
        """Paper equation 1: [m], (modes, columns) -> (nodes, columns) float32. Fewer modes than stored are allowed."""
        return self.modes[: len(coefficients)].T @ coefficients

    @property
    def energy_fraction(self) -> np.ndarray:
        """Part of the snapshots' energy that the first 1, 2, ... modes hold: [-], (modes,) float64."""
        if self.energy == 0.0:  # a component that never moved is represented completely
            return np.ones(len(self.modes))
        return np.cumsum(self.singular_values[: len(self.modes)] ** 2) / self.energy


def pod(snapshots: np.ndarray, modes: int, seed: int = 0) -> Basis:
    """Reduced basis by randomized SVD, cut after `modes` modes.

    snapshots: [m], (nodes, columns) float32

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
    with np.errstate(over="ignore", invalid="ignore"):  # told by _finite: what overflows stays so to the end
        columns = _orthonormal(matrix @ start)
        for _ in range(POWER_ITERATIONS):
            rows = _orthonormal(matrix.T @ columns.astype(np.float32))
            columns = _orthonormal(matrix @ rows.astype(np.float32))
        # B = Q^T Y is small and wide. B^T = Q' R gives B the left vectors of R^T; its condition is not squared.
        wide = _finite(matrix.T @ columns.astype(np.float32))
    left, singular, _ = np.linalg.svd(np.linalg.qr(wide.astype(float), mode="r").T, full_matrices=False)
    return columns @ left, singular


def exact_pod(snapshots: np.ndarray, modes: int) -> Basis:
    """The same by the full SVD in float64: the reference, 400 times slower at 10,000 x 20,000."""
    check_count(snapshots.shape, modes)
    left, singular, _ = np.linalg.svd(snapshots.astype(float), full_matrices=False)
    return make_basis(left, singular, sum_of_squares(snapshots), modes)


def orthogonality_error(modes: np.ndarray) -> float:
    """Largest entry of |U^T U - I|: [-]. modes: (modes, nodes)."""
    wide = modes.astype(float)
    return float(np.abs(wide @ wide.T - np.eye(len(modes))).max())


def check_count(shape: tuple[int, int], modes: int) -> None:
    """InputError E-ROM-007 unless a snapshot matrix of (nodes, columns) has that many modes."""
    most = min(shape)
    if not 1 <= modes <= most:
        raise InputError(
            "E-ROM-007",
            f"{modes} modes cannot be made",
            where=f"a snapshot matrix of {shape[0]} nodes by {shape[1]} snapshots",
            why=f"it has between 1 and {most} modes",
            remedy=f"choose modes between 1 and {most}, or add runs",
        )


def make_basis(left: np.ndarray, singular: np.ndarray, energy: float, modes: int) -> Basis:
    """The basis of the first `modes` left singular vectors, (nodes, at least modes) float64.

    NumericalStop E-ROM-013 if they are not orthonormal.
    """
    kept = np.ascontiguousarray(left[:, :modes].T)
    # A singular vector is free to change sign; fixing it makes bases of two machines comparable.
    largest = np.take_along_axis(kept, np.abs(kept).argmax(axis=1)[:, None], axis=1)
    kept = (kept * np.sign(largest)).astype(np.float32)
    error = orthogonality_error(kept)
    if not error < 1e-5:
        raise _not_orthonormal(f"largest deviation {error:.1e}, limit 1e-5")
    return Basis(kept, singular, energy)


def sum_of_squares(snapshots: np.ndarray) -> float:
    """Squared Frobenius norm: [m2]."""
    # Summed in float64, one row at a time: a float32 sum over 10^8 squares would lose the digits the tail needs.
    return float(sum(np.square(row, dtype=float).sum() for row in snapshots))


def _orthonormal(matrix):
    return np.linalg.qr(matrix.astype(float))[0]


def _finite(product):
    if not np.isfinite(product).all():
        raise _not_orthonormal("a product with the snapshots overflowed")
    return product


def _not_orthonormal(how: str) -> NumericalStop:
    return NumericalStop(
        "E-ROM-013",
        f"the reduced basis is not orthonormal ({how})",
        where="proper orthogonal decomposition",
        why="the linear algebra library returned a wrong factorisation, or snapshots overflow float32",
        remedy="check the displacements of the runs for values beyond 1e15 m",
    )
