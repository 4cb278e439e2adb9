"""What learning needs of a dataset is told once, and the datasets of these tests have all of it."""

from __future__ import annotations

import pytest
from free_synthetic import FreeDataset
from synthetic import SyntheticDataset

from billow.rom.learn.dataset import Dataset, ReadOnce


def test_synthetic_datasets_are_datasets(dataset):
    assert isinstance(dataset, Dataset)
    assert isinstance(FreeDataset(train=2, test=1, nodes=60), Dataset)
    assert isinstance(ReadOnce(dataset), Dataset)


@pytest.mark.parametrize("part", ["trusted", "design", "reference", "result"])
def test_a_dataset_without_one_of_its_parts_is_none(part):
    whole = SyntheticDataset(train=2, test=1, times=3, nodes=60)

    class Lacking:
        def __getattr__(self, name):
            if name == part:
                raise AttributeError(name)
            return getattr(whole, name)

    assert not isinstance(Lacking(), Dataset)


def test_every_run_is_read_once():
    whole = SyntheticDataset(train=3, test=1, times=3, nodes=60)
    once = ReadOnce(whole)
    for _ in range(2):
        once.snapshots("displacement", whole.train)
    assert whole.read == list(whole.train)
