"""The reduced basis against the exact singular value decomposition, and what a basis promises."""

from __future__ import annotations

import numpy as np
import pytest
from exact_pod import exact_pod

from billow.base.errors import InputError, NumericalStop
from billow.rom.learn.dataset import collect, snapshot_bytes
from billow.rom.learn.pod import orthogonality_error, pod


@pytest.fixture(scope="module")
def snapshots(dataset):
    return collect(dataset, dataset.train)


def _projection_error(basis, matrix):
    return np.linalg.norm((matrix - basis.fields(basis.coefficients(matrix))).astype(float))


@pytest.mark.parametrize("component", range(3))
def test_randomized_equals_exact(snapshots, component):
    # rom.md, POD table: 5e-7 above the best projection error
    matrix = snapshots[component]
    fast, exact = pod(matrix, 12), exact_pod(matrix, 12)
    assert _projection_error(fast, matrix) <= _projection_error(exact, matrix) * (1 + 5e-7) + 1e-6
    assert np.allclose(fast.singular_values[:12], exact.singular_values[:12], rtol=1e-4)
    assert np.allclose(fast.modes[:4], exact.modes[:4], atol=1e-4)  # well separated ones, sign included
    assert fast.energy == pytest.approx(exact.energy, rel=1e-12)


def test_flat_spectrum_needs_the_power_iterations(monkeypatch):
    # Wrinkled fabric: singular values that hardly fall. Without power iterations the error is several percent.
    random = np.random.default_rng(3)
    left, right = (np.linalg.qr(random.standard_normal((size, 200)))[0] for size in (400, 600))
    matrix = ((left * np.arange(1, 201) ** -0.5) @ right.T).astype(np.float32)
    best = _projection_error(exact_pod(matrix, 12), matrix)
    assert _projection_error(pod(matrix, 12), matrix) < 1.001 * best
    monkeypatch.setattr("billow.rom.learn.pod.POWER_ITERATIONS", 0)
    assert _projection_error(pod(matrix, 12), matrix) > 1.02 * best


def test_error_falls_with_modes_and_energy_tells_it(snapshots):
    matrix = snapshots[2]
    basis = pod(matrix, 12)
    coefficients = basis.coefficients(matrix)
    errors = [np.linalg.norm((matrix - basis.fields(coefficients[:count])).astype(float)) for count in range(1, 13)]
    assert all(np.diff(errors) < 0)
    assert np.allclose(1.0 - np.square(errors) / basis.energy, basis.energy_fraction, atol=1e-6)
    assert orthogonality_error(basis.modes) < 1e-6


def test_same_seed_same_bits(snapshots):
    one, other = (pod(snapshots[0], 6, seed=4) for _ in range(2))
    assert one.modes.tobytes() == other.modes.tobytes()


def test_component_that_never_moves_is_represented():
    basis = pod(np.zeros((30, 40), np.float32), 3)
    assert np.array_equal(basis.energy_fraction, np.ones(3))
    assert orthogonality_error(basis.modes) < 1e-6


def test_too_many_modes_are_refused(snapshots):
    with pytest.raises(InputError, match="E-ROM-007"):
        pod(snapshots[0], 601)


def test_columns_are_runs_in_order(dataset, snapshots):
    run, time = 3, 7
    field = dataset.snapshots("displacement", [dataset.train[run]])[0, time]
    assert np.array_equal(snapshots[:, :, run * 20 + time], field.T)
    assert snapshots.nbytes == snapshot_bytes(dataset, dataset.train) == 3 * 4 * 800 * 30 * 20


def test_broken_snapshots_are_named(dataset, monkeypatch):
    field = dataset.snapshots("displacement", dataset.train[:1])
    field[0, 5, 10, 2] = np.nan
    monkeypatch.setattr(dataset, "snapshots", lambda *_: field)
    with pytest.raises(InputError, match=r"E-ROM-009(?s:.*)time index 5"):
        collect(dataset, ["0000"])


def test_values_that_overflow_are_told_before_linear_algebra_fails():
    huge = np.full((20, 30), 3e38, np.float32)
    huge[0] *= -1.0
    with pytest.raises(NumericalStop, match=r"E-ROM-013(?s:.*)overflow"):
        pod(huge, 3)
    large = np.random.default_rng(1).standard_normal((20, 30)).astype(np.float32) * np.float32(1e30)
    assert orthogonality_error(pod(large, 3).modes) < 1e-6  # large but harmless
