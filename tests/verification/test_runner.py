"""What `billow verify` relies on: ids, JSON keys, and a verdict that can be negative."""

import json

import pytest

from billow.apps.verification import cases
from billow.apps.verification.check import Measurement
from billow.base.errors import InputError, NumericalStop

REQUIRED = (
    {f"T{k}" for k in range(1, 7)} | {"S1", "S3", "S4", "S6", "S7"} | {f"C{k}" for k in range(1, 5)} | {"R1", "P3"}
)
KEYS = {"id", "title", "measured", "expected", "tolerance", "passed", "seconds"}


def test_all_required_cases_are_there():
    assert set(cases.CASES) >= REQUIRED


def test_json_has_exactly_the_promised_keys():
    seen = []
    checks = cases.run_cases(["T4", "C3"], progress=seen.append)
    assert seen == checks
    assert [c.id for c in checks] == sorted((c.id for c in checks), key=list(cases.CASES).index)
    for record in json.loads(json.dumps([c.record() for c in checks], allow_nan=False)):
        assert set(record) == KEYS
        assert record["passed"] is True
        assert record["seconds"] >= 0.0


@pytest.mark.parametrize(
    ("title", "measured", "expected", "tolerance", "passed"),
    [
        ("pressure [Pa]", 1010.0, 1000.0, 0.011, True),
        ("pressure [Pa]", 1012.0, 1000.0, 0.011, False),
        ("pressure [Pa]", -1000.0, 1000.0, 0.011, False),
        ("cosine [-]", -0.995, -1.0, 0.01, True),
        ("residual [absolute]", 0.009, 0.0, 0.01, True),
        ("residual [absolute]", -0.011, 0.0, 0.01, False),
        ("volume [absolute]", 0.23, 0.2, 0.02, False),
        ("pressure [Pa]", float("nan"), 1000.0, 0.01, False),
    ],
)
def test_verdict(title, measured, expected, tolerance, passed):
    assert Measurement(title, measured, expected, tolerance).passed is passed


def test_a_case_that_stops_fails_and_the_rest_still_runs(monkeypatch):
    def stops():
        yield Measurement("before [-]", 1.0, 1.0, 0.1)
        raise NumericalStop("E-NUM-001", "not a finite number", where="here", why="test", remedy="none")

    monkeypatch.setitem(cases.CASES, "T1", stops)
    before, stopped, *rest = cases.run_cases(["T1", "T6"])
    assert before.passed
    assert (stopped.id, stopped.passed, stopped.record()["measured"]) == ("T1", False, None)
    assert "not a finite number" in stopped.title
    assert {c.id for c in rest} == {"T6"}


def test_unknown_id_is_refused_with_the_known_ones():
    with pytest.raises(InputError) as caught:
        cases.run_cases(["T1", "T99"])
    assert caught.value.code == "E-CLI-030"
    assert "T99" in str(caught.value)
    assert "S6" in caught.value.remedy
