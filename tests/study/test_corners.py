"""What a study finds before the hours are spent: a parameter that changes the mesh, a design that does not build."""

import pytest
from fake_solver import STUDY

from billow.base.errors import InputError
from billow.study.corners import _corners
from billow.study.definition import StudyDefinition
from billow.study.study import Study


def refused(definition, text, folder):
    definition.write_text(text)
    with pytest.raises(InputError) as caught:
        Study.create(definition, folder)
    assert not folder.exists()
    return caught.value


def test_a_parameter_that_changes_the_start_shape_is_named(definition, tmp_path):
    error = refused(definition, STUDY.replace("square.lift", "square.size"), tmp_path / "study")
    assert (error.code, "number 1 (lift)" in error.where) == ("E-STU-040", True)
    assert "'lift' changes the start shape" in error.what
    assert "square.size = 1: " in error.why
    assert "square.size = 2: " in error.why


CASE = '[bag]\nelement_size = "60 mm"\n[run]\nframes = 2\n'
DRIVER = """
title = "Driver bag"
case = "driver.toml"
seed = 1
train = 3
test = 1
reference_length = 0.28
[[parameters]]
name = "temperature"
label = "Temperature"
unit = "K"
low = 600.0
high = 800.0
keys = ["inflator.temperature"]
[[parameters]]
name = "size"
label = "Size"
unit = "UNIT"
low = LOW
high = HIGH
keys = ["KEY"]
"""


def driver(key, low, high, unit="m"):
    changes = {"KEY": key, "LOW": low, "HIGH": high, "UNIT": unit}
    text = DRIVER
    for name, value in changes.items():
        text = text.replace(name, str(value))
    return text


@pytest.mark.parametrize(
    ("key", "low", "high", "what", "told"),
    [
        ("bag.element_size", 0.05, 0.06, "the mesh", "triangles"),
        ("run.end_time", 0.02, 0.04, "the recorded times", "frames to 0.02 s"),
    ],
)
def test_of_a_real_case_too(tmp_path, key, low, high, what, told):
    (tmp_path / "driver.toml").write_text(CASE)
    error = refused(tmp_path / "definition.toml", driver(key, low, high), tmp_path / "study")
    assert (error.code, "number 2 (size)" in error.where) == ("E-STU-040", True), error
    assert f"'size' changes {what}" in error.what
    assert told in error.why


def test_a_design_that_does_not_build_is_found_before_the_first_run(tmp_path):
    """A head that a small clearance lays into the bag: every entry is fine by itself."""
    (tmp_path / "driver.toml").write_text(CASE + '[[obstacles]]\nshape = "super-ellipsoid"\nname = "head"\n')
    error = refused(tmp_path / "definition.toml", driver("obstacles.head.clearance", 0.0, 0.1), tmp_path / "study")
    assert error.code == "E-STU-007"
    assert "head" in error.what


def test_corners_go_from_all_low_to_all_high(tmp_path):
    (tmp_path / "driver.toml").write_text(CASE)
    (tmp_path / "definition.toml").write_text(driver("run.dt_scale", 0.5, 1.0, "-"))
    definition = StudyDefinition.load(tmp_path / "definition.toml")
    assert set(_corners(definition, 256)) == {(t, s) for t in (600.0, 800.0) for s in (0.5, 1.0)}
    assert list(_corners(definition, 2)) == [(600.0, 0.5), (800.0, 1.0)]
    assert Study.create(tmp_path / "definition.toml", tmp_path / "study").runs
