"""Every verification case passes, within its own tolerance."""

import pytest

from billow.apps.verification.cases import CASES, run_cases

LONG = {
    "S6",
    "S7",
    "S9",
    "S10",
    "R1",
    "P3",
    "V4",
    "T1p",
    "T2p",
    "T3p",
    "T5p",
    "T16",
    "T18",
    "T19",
    "T20",
    "T5m",
    "M1",
    "M2",
    "M3",
    "M6",
}  # a second or more, besides compiling
BY_COMMAND = {"T13", "M7"}  # a minute each: `billow verify T13 M7`


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n in LONG else ()) for n in CASES if n not in BY_COMMAND]
)
def test_case(name):
    checks = run_cases([name])
    assert checks
    wrong = [f"{c.title}: {c.measured:.9g}, expected {c.expected:.9g}" for c in checks if not c.passed]
    assert not wrong, "\n".join(wrong)
