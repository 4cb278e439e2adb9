"""What a study relies on in `billow.Case`: strict keys, and a case that survives a file and a trip to a worker."""

import tomllib

import pytest

from billow.base.errors import InputError
from billow.case.schema import Case
from billow.study.study import Study

STUDY = """
title = "Driver bag"
case = "driver.toml"
seed = 1
train = 3
test = 1
reference_length = 0.28
[[parameters]]
name = "permeability"
label = "Airbag permeability"
unit = "-"
low = 0.02
high = 0.035
keys = ["fabric.permeability"]
"""


@pytest.fixture
def definition(tmp_path):
    (tmp_path / "driver.toml").write_text('title = "Driver"\n')
    path = tmp_path / "definition.toml"
    path.write_text(STUDY)
    return path


def test_every_run_has_a_case_of_its_own_that_keeps_its_identity(definition, tmp_path):
    study = Study.create(definition, tmp_path / "study")
    digests = {run: study.case(run).digest() for run in study.runs}
    assert len(set(digests.values())) == 4
    for run, (permeability,) in study.runs.items():
        case = study.case(run)
        assert case.fabric.permeability == permeability
        (tmp_path / "case.toml").write_text(case.to_toml())
        assert Case.load(tmp_path / "case.toml").digest() == digests[run]
        assert Case.from_dict(tomllib.loads(case.to_toml())).digest() == digests[run]
    assert {run: Study.open(study.folder).case(run).digest() for run in digests} == digests


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("fabric.permeability", "fabric.permeabilty", "permeabilty"),
        ("fabric.permeability", "obstacles.sphere.radius", "sphere"),
        ("low = 0.02", "low = -0.02", "permeability"),
    ],
)
def test_what_the_case_refuses_the_study_tells(definition, tmp_path, old, new, told):
    definition.write_text(STUDY.replace(old, new))
    with pytest.raises(InputError) as caught:
        Study.create(definition, tmp_path / "study")
    assert caught.value.code == "E-STU-007"
    assert told in str(caught.value)
    assert str(definition) in caught.value.where
    assert not (tmp_path / "study").exists()
