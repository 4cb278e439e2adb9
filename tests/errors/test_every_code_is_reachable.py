"""Every code can be brought about, and its message has four parts, is fit to be read, and helps."""

from __future__ import annotations

import re

import pytest
from declared import ALL
from here import Here, Told
from remedies import unreal
from triggers import TRIGGERS

from billow.base.errors import BillowError, Concern

INSIDES = re.compile(r"Traceback|\bNone\b| object at 0x|<class ")


def test_every_code_has_a_trigger():
    assert set(TRIGGERS) == set(ALL)


@pytest.mark.parametrize("code", sorted(TRIGGERS))
def test_code(code, bench, tmp_path, monkeypatch):
    told = _bring_about(code, Here(tmp_path, bench, monkeypatch))
    assert told.code == code
    if not isinstance(told, Told):
        assert type(told) is ALL[code].kind
    for part in ("what", "where", "why", "remedy"):
        text = getattr(told, part)
        assert text.strip(), part
        assert text.isprintable(), part
        assert not INSIDES.search(text), text
    assert unreal(told.remedy) == []


def _bring_about(code: str, here: Here) -> BillowError | Concern | Told:
    try:
        told = TRIGGERS[code](here)
    except BillowError as error:
        return error
    assert isinstance(told, Concern | Told), f"{code} did not come: {told}"
    return told


@pytest.mark.parametrize(
    ("remedy", "what"),
    [
        ("billow fly bag.toml", "billow fly"),
        ("billow run bag.toml", "out"),
        ("run it: billow run bag.toml --out RUN --fast", "--fast"),
        ("insist with --force", "--force"),
        ("reduce bag.vents.radius", "bag.vents.radius"),
        ("raise obstacles.impactor.stiffness", "obstacles.*.stiffness"),
        ("docs/cases.md describes it", "docs/cases.md"),
    ],
)
def test_a_remedy_that_names_nothing_real_is_noticed(remedy, what):
    assert what in " ".join(unreal(remedy))


@pytest.mark.parametrize(
    "remedy",
    [
        "billow check CASE.toml, or billow check --example > bag.toml",
        "check the path; `billow check --example` prints a case to start from",
        "give the folder that `billow run` wrote",
        "write for example --set fabric.permeability=0.03",
        "raise obstacles.impactor.slope (N/m per cm^2 of fabric)",
        "change bag.vents or run.toml; docs/case.md describes it",
    ],
)
def test_a_remedy_that_names_real_things_passes(remedy):
    assert unreal(remedy) == []
