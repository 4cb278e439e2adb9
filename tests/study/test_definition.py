import fake_solver
import pytest

from billow.base.errors import InputError
from billow.study.definition import StudyDefinition

WRONG = [
    ("train = 4", "train = 1", "E-STU-004", "train", "greater than or equal to 2"),
    ("test = 2", "test = 0", "E-STU-004", "test", "greater than or equal to 1"),
    ("train = 4", 'train = "4"', "E-STU-004", "train", "whole number"),
    ("train = 4", "train = 4.0", "E-STU-004", "train", "whole number"),
    ("train = 4", "trian = 4", "E-STU-005", "train", "missing"),
    ("seed = 3", "seed = 3\nsede = 4", "E-STU-003", "sede", "did you mean 'seed'?"),
    ("reference_length = 0.28", "reference_length = nan", "E-STU-004", "reference_length", "finite"),
    ("low = 1.0", "low = 2.0", "E-STU-004", "number 1 (lift)", "not below high"),
    ("low = 1e3", "low = 0.0", "E-STU-004", "number 2 (slope)", "logarithm"),
    ("low = 1e3", "lower = 1e3", "E-STU-005", "[[parameters]] number 2 (slope), low", "missing"),
    ('name = "slope"', 'name = "lift"', "E-STU-004", "number 2 (lift)", "two parameters are called"),
    ('name = "slope"', 'name = "a [b]"', "E-STU-004", "number 2", "pattern"),
    ('["plate.slope"]', '["square.lift"]', "E-STU-004", "number 2 (slope)", "varied twice"),
    ('["plate.slope"]', "[]", "E-STU-004", "number 2 (slope), keys", "at least 1"),
    ('scale = "log"', 'scale = "cubic"', "E-STU-004", "scale", "'linear' or 'log'"),
    ("square.toml", "round.toml", "E-STU-006", "case", "looked for at"),
    ("train = 4", "train = ", "E-STU-002", "definition.toml", "line 5"),
]


@pytest.mark.parametrize(("right", "wrong", "code", "place", "told"), WRONG)
def test_each_mistake_is_told_where_it_is(definition, right, wrong, code, place, told):
    assert right in fake_solver.STUDY
    definition.write_text(fake_solver.STUDY.replace(right, wrong, 1))
    with pytest.raises(InputError) as caught:
        StudyDefinition.load(definition)
    error = caught.value
    assert error.code == code
    assert str(definition) in error.where
    assert place in error.where
    assert told in str(error)


def test_a_missing_file_and_the_way_back_to_toml(definition, tmp_path):
    with pytest.raises(InputError, match="E-STU-001"):
        StudyDefinition.load(tmp_path / "none.toml")
    loaded = StudyDefinition.load(definition)
    definition.write_text(loaded.to_toml())
    assert StudyDefinition.load(definition) == loaded


@pytest.mark.parametrize(("measure", "told"), [("nij", "neck"), ("VC", "chest"), ("rib", "rib"), ("hic", "'hic15'")])
def test_measures_without_a_model_behind_them_are_refused_with_the_reason(definition, measure, told):
    table = f'\n[[responses]]\nname = "injury"\nmeasure = "{measure}"\nof = "head"\n'
    definition.write_text(fake_solver.STUDY + table)
    with pytest.raises(InputError) as caught:
        StudyDefinition.load(definition)
    assert caught.value.code == "E-STU-004"
    assert "number 1 (injury), measure" in caught.value.where
    assert told in caught.value.why
