"""`--until` on studies that are run: it is judged by runs held out, and what is added is run and learned from."""

from functools import partial

import fake_solver
import pytest

from billow.design.adaptive import BATCH, Aim, grow
from billow.results.dataset import Dataset
from billow.rom.learn import train as training
from billow.rom.learn.train import Recipe
from billow.study.study import Study

RESPONSE = '\n[[responses]]\nname = "away"\nmeasure = "distance"\npoint = [0.0, 0.0, 0.03]\nunit = "mm"\n'
"""30 mm above a corner that rises by 20 to 40 mm: with a bend where it gets there."""


def grown(definition, folder, text, aim):
    definition.write_text(text)
    study = Study.create(definition, folder)
    study.run(workers=1, runner=fake_solver.simulate)
    growth = grow(folder, Aim.read(aim), workers=1, runner=fake_solver.simulate)
    made = Dataset.open(folder)
    assert made.trusted == made.train
    assert growth.reached
    assert growth.why == ""
    assert [stage.runs for stage in growth.stages] == list(range(len(study.train), len(made.train) + 1, BATCH))
    return growth.stages


def test_until_the_moving_bag_is_known(definition, tmp_path, monkeypatch):
    """Four runs are too few to judge; twelve are not, and the motion is a straight line in the design."""
    few = partial(training.train, recipe=Recipe(modes=2, epochs=30))  # the square has four nodes
    monkeypatch.setattr(training, "train", few)
    stages = grown(definition, tmp_path / "study", fake_solver.STUDY, "rmse < 1 mm")
    assert [stage.error for stage in stages] == [float("inf"), pytest.approx(0.5, abs=0.49)]
    assert (tmp_path / "study" / "surrogate.safetensors").is_file()


def test_until_a_response_is_known(definition, tmp_path):
    text = fake_solver.STUDY.replace("train = 4", "train = 12") + RESPONSE
    stages = grown(definition, tmp_path / "study", text, "away < 0.2 mm")
    assert len(stages) > 1
    assert stages[-1].error < 0.2 < stages[0].error
