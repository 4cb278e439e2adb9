"""Responses that no run would hold are refused before the first run is made."""

import pytest

from billow.base.errors import InputError
from billow.study.study import Study

CASE = """
[bag]
element_size = "80 mm"
[run]
end_time = "20 ms"
frames = 4
histories_per_frame = 5
[[obstacles]]
shape = "plate"
[[obstacles]]
shape = "super-ellipsoid"
name = "head"
locked = LOCKED
"""
STUDY = """
title = "Driver bag"
case = "driver.toml"
seed = 1
train = 2
test = 1
reference_length = 0.28
[[parameters]]
name = "temperature"
label = "Temperature"
unit = "K"
low = 600.0
high = 800.0
keys = ["inflator.temperature"]
[[responses]]
name = "answer"
"""
ROWS = "histories_per_frame = 5"


def created(folder, response, locked=True, rows=ROWS):
    case = CASE.replace("LOCKED", str(locked).lower()).replace(ROWS, rows)
    (folder / "driver.toml").write_text(case)
    (folder / "definition.toml").write_text(STUDY + response)
    return Study.create(folder / "definition.toml", folder / "study")


@pytest.mark.parametrize(
    ("response", "locked", "why"),
    [
        ('measure = "penetration"\nof = "haed"', True, "did you mean 'head'?"),
        ('measure = "hic15"\nof = "head"', True, "head is locked"),
        ('measure = "height"\nof = "fronnt"', True, "did you mean 'front'?"),
        ('measure = "peak"\nquantity = "volumen"', True, "did you mean 'volume'?"),
        ('measure = "peak"\nof = "haed"\nquantity = "force"', True, "no column 'haed_force'"),
        ('measure = "peak"\nof = "head"\nquantity = "acceleration"', True, "no column 'head_acceleration'"),
        ('measure = "peak"\nof = "head"\nquantity = "force.w"', True, "force has no axis 'w'"),
        ('measure = "peak"\nof = "head"\nquantity = "force.xy"', True, "force has no axis 'xy'"),
        ('measure = "energy_share"\nquantity = "volume"', True, "'volume' is no energy"),
        ('measure = "peak"\nquantity = "volume.x"', True, "volume has no axis 'x'"),
        ('measure = "vented_mass"\nof = "head"', True, "no column 'head_vented'"),
        ('measure = "final"\nof = "heads"\nquantity = "gauge_pressure"', True, "no column 'heads_gauge_pressure'"),
    ],
)
def test_of_what_no_run_records(tmp_path, response, locked, why):
    with pytest.raises(InputError) as caught:
        created(tmp_path, response, locked)
    assert caught.value.code == "E-STU-042"
    assert "[[responses]] number 1 (answer)" in caught.value.where
    assert why in caught.value.why
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize(
    ("response", "code"),
    [
        ('measure = "peak"\nquantity = "gauge_pressure"\nunit = "kN"', "E-DES-002"),
        ('measure = "hic15"\nof = "head"\nunit = "g"', "E-DES-002"),
        ('measure = "time_to"\nquantity = "volume"\nlevel = 40.0\nunit = "kPa"', "E-DES-002"),
        ('measure = "hic15"\nof = "head"', "E-INJ-003"),
        ('measure = "peak"\nof = "head"\nquantity = "acceleration"\nfilter = "CFC180"', "E-INJ-003"),
    ],
)
def test_of_another_unit_or_from_too_few_rows(tmp_path, response, code):
    with pytest.raises(InputError) as caught:
        created(tmp_path, response, locked=False)
    assert (caught.value.code, "number 1 (answer)" in caught.value.where) == (code, True)


@pytest.mark.parametrize(
    "response",
    [
        'measure = "peak"\nquantity = "gauge_pressure"\nunit = "kPa"',
        'measure = "peak"\nof = "bag"\nquantity = "absolute_pressure"',
        'measure = "peak"\nof = "head"\nquantity = "acceleration.z"\nfilter = "CFC180"\nunit = "g"',
        'measure = "final"\nof = "head"\nquantity = "quaternion.w"',
        'measure = "integral"\nof = "head"\nquantity = "force"',
        'measure = "time_to"\nquantity = "volume"\nlevel = 40.0\nunit = "l"',
        'measure = "hic15"\nof = "head"',
        'measure = "energy_share"\nquantity = "strain"',
        'measure = "fill_time"',
        'measure = "vented_mass"',
        'measure = "width"\nof = "front"\nunit = "mm"',
    ],
)
def test_what_runs_will_hold_is_accepted(tmp_path, response):
    assert created(tmp_path, response, locked=False, rows="histories_per_frame = 200").definition.responses


def test_asked_again_when_a_study_gets_more_responses(tmp_path):
    made = created(tmp_path, 'measure = "fill_time"')
    with pytest.raises(InputError) as caught:
        created(tmp_path, 'measure = "penetration"\nof = "hed"')
    assert caught.value.code == "E-STU-042"
    assert Study.open(made.folder).definition.responses == made.definition.responses
