"""The catalogue, the source and the page of the docs say the same."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from codes_in_source import codes_in_source
from remedies import unreal

from billow.error_catalogue import CATALOGUE, GROUPS

DOCS = Path(__file__).parents[2] / "docs"


def test_the_catalogue_holds_the_codes_of_the_source_and_no_others():
    assert set(CATALOGUE) == set(codes_in_source())


@pytest.mark.parametrize("code", sorted(CATALOGUE))
def test_a_code_is_raised_as_the_class_the_catalogue_names(code):
    kind = CATALOGUE[code].kind
    assert codes_in_source_once()[code] == {"Warning" if kind is None else kind.__name__}
    assert code.startswith("W-" if kind is None else "E-")


def codes_in_source_once(found={}) -> dict[str, set[str]]:  # noqa: B006 - remembered between the tests
    found.update(found or codes_in_source())
    return found


@pytest.mark.parametrize("code", sorted(CATALOGUE))
def test_an_entry_is_complete_and_its_remedy_names_real_things(code):
    entry = CATALOGUE[code]
    assert code.split("-")[1] in GROUPS
    for text in (entry.meaning, entry.cause, entry.remedy):
        assert text[:1].strip()
        assert "\n" not in text
    assert unreal(entry.remedy) == []


def test_the_page_is_what_the_generator_writes():
    spec = importlib.util.spec_from_file_location("make_errors", DOCS / "make_errors.py")
    make_errors = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(make_errors)
    assert (DOCS / "errors.md").read_text(encoding="utf-8") == make_errors.render(), "python docs/make_errors.py"
