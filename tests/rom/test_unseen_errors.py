"""Errors from coefficients alone equal errors of the fields themselves, and a cut reduction is a smaller one."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import SyntheticDataset

from billow.rom.judge.errors import project, snapshot_rmse
from billow.rom.learn.reduction import reduce_runs


@pytest.fixture(scope="module")
def small():
    return SyntheticDataset(train=10, test=3, times=8, nodes=120)


def test_truncation_and_regression_are_those_of_the_fields(small):
    bases = reduce_runs(small, small.train, 6, seed=0).bases
    truth = small.snapshots("displacement", list(small.test))
    seen = project(truth, bases)
    learned = seen.known + np.random.default_rng(0).normal(0.0, 0.01, seen.known.shape).astype(np.float32)
    for count in (1, 4, 6):
        fields = np.stack([learned[:, :, c, :count] @ basis.modes[:count] for c, basis in enumerate(bases)], axis=-1)
        total = np.hypot(seen.truncation(count), seen.regression(learned, count))
        # Both are float32 products of 120 nodes: a part in a million of the largest displacement.
        assert total == pytest.approx(snapshot_rmse(fields, truth), abs=1e-6 * float(np.abs(truth).max()))


def test_a_cut_reduction_is_that_of_fewer_modes(small):
    large, fewer = reduce_runs(small, small.train, 9, seed=0), reduce_runs(small, small.train, 5, seed=0)
    cut = large.cut(5)
    # 80 snapshots, rank 33 and 29 of the randomised basis: both hold the first modes to 1e-5 of the largest.
    assert cut.coefficients == pytest.approx(fewer.coefficients, abs=1e-4 * float(np.abs(fewer.coefficients).max()))
    for name in ("lost_by_time", "lost_by_node"):
        found, expected = getattr(cut, name), getattr(fewer, name)
        assert found == pytest.approx(expected, rel=1e-2, abs=1e-2 * float(expected.max()))
    assert large.lost_by_node.sum() < 0.9 * cut.lost_by_node.sum()  # the cut modes were worth something
