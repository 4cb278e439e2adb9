"""Numbers read off curves, in the units that a response asks for."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.design.measures import measure, unit_of
from billow.results.histories import History
from billow.study.responses import StudyResponse

TIMES = np.linspace(0.0, 0.04, 401)
VOLUME = 0.05 * TIMES / 0.04
"""[m^3] A bag that fills to 50 l."""


def run_that_fills():
    histories = History({"time [s]": TIMES, "volume [m^3]": VOLUME, "strain [J]": 100.0 * TIMES,
                         "enthalpy_in [J]": 1000.0 * TIMES})  # fmt: skip
    return SimpleNamespace(histories=histories, folder=Path("run"))


def read(folder=Path(), **table):
    response = StudyResponse.model_validate({"name": "x"} | table)
    assert not list(response.contradictions())
    return measure(run_that_fills(), response, folder), unit_of(run_that_fills(), response)


def test_a_level_is_in_the_unit_of_its_curve():
    assert read(measure="time_to", quantity="volume", unit="l", level=30.0) == (pytest.approx(0.024), "s")
    assert read(measure="time_to", quantity="volume", level=0.03) == (pytest.approx(0.024), "s")


@pytest.mark.parametrize("unit", ["litres", "kPa", "L"])
def test_a_level_in_a_unit_that_the_curve_does_not_have_is_refused(unit):
    """It counted as SI, so that the level was never reached, or at once."""
    with pytest.raises(InputError) as caught:
        read(measure="time_to", quantity="volume", unit=unit, level=30.0)
    assert caught.value.code == "E-DES-002"
    assert "m^3, l, cm^3" in caught.value.why


def test_a_rating_against_a_reference_in_another_unit_is_that_in_si(tmp_path):
    found = {}
    for unit, factor in (("m^3", 1.0), ("l", 1e3)):
        rows = "\n".join(f"{t:.6f},{v:.9g}" for t, v in zip(TIMES, factor * 1.1 * VOLUME, strict=True))
        (tmp_path / "test.csv").write_text("time,volume\n" + rows + "\n")
        found[unit], told = read(tmp_path, measure="rating", quantity="volume", unit=unit, reference="test.csv")
        assert told == "-"
    assert found["l"] == pytest.approx(found["m^3"], abs=1e-6)
    assert 0.3 < found["l"] < 1.0


def test_only_an_energy_has_a_share_of_the_energy_blown_in():
    assert read(measure="energy_share", quantity="strain") == (pytest.approx(0.1), "-")
    with pytest.raises(InputError) as caught:
        read(measure="energy_share", quantity="volume")
    assert caught.value.code == "E-DES-001"


def turning(axis):
    values = {"quaternion_w [-]": 0.8, "quaternion_x [-]": 0.6, "quaternion_y [-]": 0.0, "quaternion_z [-]": 0.0,
              "force_x [N]": 3.0, "force_y [N]": 4.0, "force_z [N]": 5.0}  # fmt: skip
    curves = {f"head_{name}": np.full(401, value) for name, value in values.items()}
    run = SimpleNamespace(histories=History({"time [s]": TIMES} | curves), folder=Path("run"))
    response = {"name": "x", "measure": "final", "of": "head", "quantity": axis}
    return measure(run, StudyResponse.model_validate(response), Path())


def test_an_axis_is_that_of_its_name():
    """x of a quaternion was its real part, w none at all, and xy of a force its x."""
    assert [turning(f"quaternion.{axis}") for axis in "wxyz"] == [0.8, 0.6, 0.0, 0.0]
    assert [turning(f"force.{axis}") for axis in "xyz"] == [3.0, 4.0, 5.0]
    for wrong in ("force.xy", "force.w", "quaternion.wx"):
        with pytest.raises(InputError, match="has no axis"):
            turning(wrong)


def test_limits_between_which_nothing_lies_are_refused():
    table = {"name": "x", "measure": "peak", "quantity": "volume", "limit": {"below": 3.0, "above": 4.0}}
    (found,) = StudyResponse.model_validate(table).contradictions()
    assert "nothing lies between" in found
