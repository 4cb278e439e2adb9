"""The paper's networks: an interrupted training goes on with the same bits, and nothing is lost of its time."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import SyntheticDataset

from billow.reproductions.rom_paper import recipe
from billow.reproductions.rom_paper.kept import Kept
from billow.reproductions.rom_paper.nested_design import NestedDesign
from billow.reproductions.rom_paper.published import FREE, LOCKED
from billow.results.tensor_file import read_tensors
from billow.rom.learn.network import train_paper
from billow.rom.learn.reduction import DEFAULT_MEMORY


class Stopped(Exception):
    pass


@pytest.fixture(scope="module")
def small():
    return SyntheticDataset(train=10, test=3, times=8, nodes=120)


def prepared(small, folder):
    kept = Kept(folder)
    return kept, NestedDesign(small, small.train, small.test, 6, DEFAULT_MEMORY)


def test_interrupted_training_goes_on_with_the_same_bits(small, tmp_path, monkeypatch):
    monkeypatch.setattr(recipe, "SAVE_EVERY", 0.0)

    def stop(epoch, epochs, loss):
        if epoch == 17:
            raise Stopped

    kept, made = prepared(small, tmp_path / "kept")
    with pytest.raises(Stopped):
        recipe.paper_recipe(made, LOCKED, "z", kept, epochs=40, progress=stop)
    epochs = []
    gone_on = recipe.paper_recipe(made, LOCKED, "z", kept, epochs=40, progress=lambda epoch, *_: epochs.append(epoch))
    assert epochs == list(range(18, 41))
    kept, made = prepared(small, tmp_path / "other")
    straight = recipe.paper_recipe(made, LOCKED, "z", kept, epochs=40)
    assert np.array_equal(gone_on.rmse, straight.rmse)
    again = recipe.paper_recipe(made, LOCKED, "z", kept, epochs=40, progress=stop)  # nothing left to train
    assert np.array_equal(again.rmse, straight.rmse)
    assert again.cpu_seconds == straight.cpu_seconds > 0.0


def test_networks_and_rates_are_those_of_the_case():
    rng = np.random.default_rng(0)
    inputs, targets = rng.random((20, 7)).astype(np.float32), rng.random((20, 3)).astype(np.float32)
    for case, shape in ((LOCKED, [7, 25, 45, 15, 1]), (FREE, [7, 30, 40, 10, 1])):
        weights, _ = train_paper(inputs, targets, epochs=1, hidden=case.hidden, rate=case.rate)
        assert [weights[0].shape[1], *(w.shape[2] for w in weights)] == shape
        assert all(len(w) == 3 for w in weights)  # one network for each output


def test_recipe_of_the_free_case_has_its_networks(small, tmp_path):
    kept, made = prepared(small, tmp_path)
    recipe.paper_recipe(made, FREE, "x", kept, epochs=1)
    (path,) = tmp_path.glob("paper-recipe-*.safetensors")
    assert read_tensors(path, ValueError)[0]["value.0"].shape == (6, 7, 30)


def test_one_component_is_learned_as_well_as_in_company(small, tmp_path):
    kept, made = prepared(small, tmp_path)
    found = recipe.paper_recipe(made, LOCKED, "z", kept, epochs=600)
    truth = np.array(small.snapshots("displacement", list(small.test)))[..., 2]
    still = np.sqrt(np.square(truth).mean(axis=2)).mean()
    # 600 of 15,000 epochs and ten runs: far from good, but wrong signs or scales would be no better than the answer 0.
    assert found.summary.mean < 0.5 * still
    assert found.networks == 6
    assert found.rmse.shape == (3, 8)
