import numpy as np
import pytest

from billow.study.definition import StudyDefinition
from billow.study.design import draw


@pytest.fixture
def drawn(definition):
    def with_counts(train=48, test=12, seed=3):
        return draw(StudyDefinition.load(definition).model_copy(update={"train": train, "test": test, "seed": seed}))

    return with_counts


def fractions(values):
    """(runs, parameters) in [0, 1]: the design in the scale each parameter is drawn in."""
    lift, slope = np.array(list(values)).T
    return np.column_stack([lift - 1.0, np.log10(slope / 1e3) / 3.0])


@pytest.mark.parametrize("part", ["train", "test"])
def test_every_stratum_of_every_axis_holds_one_run(drawn, part):
    points = fractions(getattr(drawn(), part).values())
    strata = np.sort(np.floor(points * len(points)).astype(int), axis=0)
    np.testing.assert_array_equal(strata, np.tile(np.arange(len(points))[:, None], 2))


def test_axes_are_drawn_independently(drawn):
    points = fractions(drawn(train=2000).train.values())
    assert abs(np.corrcoef(points.T)[0, 1]) < 4 / np.sqrt(2000)


def test_the_same_definition_gives_the_same_design_for_ever(drawn):
    # Values of the first release. A change here changes every study that is drawn again.
    assert drawn(train=2, test=1, seed=3).runs == {
        "0000": (1.618405253, 15918.85027),
        "0001": (1.291081018, 43771.65458),
        "0002": (1.253253078, 16656.8001),
    }
    assert drawn() == drawn()
    assert drawn(seed=4).train != drawn(seed=3).train


def test_test_runs_are_new_ones_and_do_not_depend_on_training(drawn):
    design = drawn()
    assert list(design.runs) == [f"{number:04d}" for number in range(60)]
    assert not set(design.train) & set(design.test)
    assert not set(design.train.values()) & set(design.test.values())
    assert list(drawn(train=7).test.values()) == list(design.test.values())
    assert list(drawn(train=12).train.values()) != list(design.test.values())
