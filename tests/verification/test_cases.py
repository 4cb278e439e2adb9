"""Every verification case passes, within its own tolerance."""

import pytest

from billow.apps.verification.cases import CASES, run_cases

LONG = {"T13", "M7"}
"""A minute each."""


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow if n in LONG else ()) for n in CASES])
def test_case(name):
    checks = run_cases([name])
    assert checks
    wrong = [f"{c.title}: {c.measured:.9g}, expected {c.expected:.9g}" for c in checks if not c.passed]
    assert not wrong, "\n".join(wrong)
