"""One synthetic dataset and one surrogate of it, trained once."""

from __future__ import annotations

import pytest
from synthetic import SyntheticDataset

from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.surrogate import Surrogate


@pytest.fixture(scope="session")
def dataset() -> SyntheticDataset:
    return SyntheticDataset()


@pytest.fixture(scope="session")
def surrogate(dataset) -> Surrogate:
    return train(dataset, Recipe(modes=8, epochs=60))


@pytest.fixture(scope="session")
def saved(surrogate, tmp_path_factory):
    return surrogate.save(tmp_path_factory.mktemp("saved") / "surrogate.safetensors")
