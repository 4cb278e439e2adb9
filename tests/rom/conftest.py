"""Synthetic datasets, and models of them that are trained once."""

from __future__ import annotations

import pytest
from free_synthetic import FreeDataset
from synthetic import SyntheticDataset

from billow.rom.coupled.coupled_model import Coupled
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


@pytest.fixture(scope="session")
def free() -> FreeDataset:
    return FreeDataset()


@pytest.fixture(scope="session")
def judged(free) -> Coupled:
    """A coupled model with intervals and verdicts."""
    return Coupled.train(free, train(free, Recipe(modes=3, epochs=30, calibrate=False)))
