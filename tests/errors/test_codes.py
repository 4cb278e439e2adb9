"""A code stands once, its texts are complete, every raise fills them in, and the page of the docs says the same."""

from __future__ import annotations

import pickle

import pytest
from declared import ALL, make_errors, placeholders, raised, trees, unfilled, unused, written_out
from remedies import unreal

from billow.base.errors import CODES, Concern, InputError

EXAMPLE = InputError.declare("E-TEST-001", "unknown {name!r}", where="here", why="no {kind}", remedy="try {known}")
CODES.pop("E-TEST-001")


def test_every_code_stands_once_in_the_source():
    found = [code for _, tree in trees() for code in written_out(tree)]
    assert sorted(found) == sorted(CODES)


@pytest.mark.parametrize("code", ALL)
def test_a_code_is_complete_and_its_remedy_names_real_things(code):
    declared = ALL[code]
    assert code.split("-")[1] in make_errors.GROUPS
    assert code.startswith("W-" if declared.kind is Concern else "E-")
    assert declared.what.strip()
    assert declared.remedy.strip()
    assert declared.why or declared.cause, "a why that every raise gives needs a usual cause for the page"
    for text in (declared.what, declared.where, declared.why, declared.remedy, declared.cause):
        assert text.isprintable()
        assert all(name.isidentifier() for name in placeholders(text))
    assert unreal(declared.remedy) == []


def test_every_raise_fills_in_what_its_code_leaves_open():
    made = [found for path, tree in trees() for found in raised(path, tree)]
    assert {code.code for _, code, _ in made} == set(CODES)
    assert [(place, lacking) for place, code, given in made if (lacking := unfilled(code, given))] == []
    assert [(place, vain) for place, code, given in made if (vain := unused(code, given))] == []


@pytest.mark.parametrize(
    ("given", "lacking", "vain"),
    [
        ({"name": False, "kind": False, "known": False}, set(), set()),
        ({"name": False, "kind": False}, {"known"}, set()),
        ({"name": False, "why": True, "remedy": True}, set(), set()),
        ({"name": False, "why": True, "remedy": False}, {"known"}, set()),
        ({"what": True, "kind": False, "known": False, "nmae": False}, set(), {"nmae"}),
    ],
)
def test_a_raise_that_fills_in_too_little_or_too_much_is_noticed(given, lacking, vain):
    assert unfilled(EXAMPLE, given) == lacking
    assert unused(EXAMPLE, given) == vain


def test_a_code_that_is_declared_twice_is_refused(monkeypatch):
    monkeypatch.setitem(CODES, "E-TEST-001", EXAMPLE)
    with pytest.raises(ValueError, match="E-TEST-001 is declared twice"):
        InputError.declare("E-TEST-001", "something else", why="because", remedy="do not")


def test_values_fill_in_the_texts_and_a_raise_may_replace_one():
    error = EXAMPLE(name="x{y}", kind="gas", remedy="leave {it}")
    assert (error.code, error.what, error.where) == ("E-TEST-001", "unknown 'x{y}'", "here")
    assert (error.why, error.remedy) == ("no gas", "leave {it}")
    assert EXAMPLE(name="x", kind="gas", known="y", remedy=None).remedy == "try y"


@pytest.mark.parametrize(
    ("reason", "why"),
    [
        (FileNotFoundError(2, "No such file or directory", "x"), "No such file or directory"),
        (ValueError("too long"), "too long"),
        (KeyError("title"), "a key is missing: 'title'"),
        (RecursionError("maximum recursion depth exceeded"), "it is nested too deeply"),
        (MemoryError(), "MemoryError"),
    ],
)
def test_an_exception_stands_for_its_reason(reason, why):
    assert EXAMPLE(name="x", known="y", why=reason).why == why


def test_an_error_comes_back_whole_from_a_worker_process():
    error = EXAMPLE(name="x", kind="gas", known="y")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is InputError
    assert str(again) == str(error)


def test_the_page_shows_placeholders_as_words():
    assert make_errors.readable("{free_edges:.3g} of {name!r}; {{}}") == "_free edges_ of _name_; {}"


def test_the_page_is_what_the_generator_writes():
    page = make_errors.TARGET.read_text(encoding="utf-8")
    assert page == make_errors.render(), "python docs/make_errors.py"
