"""Inputs that nobody meant are used or refused, never more; texts stay texts; nothing in the package evaluates any."""

from __future__ import annotations

import ast
import warnings
from pathlib import Path
from random import Random

import pytest

import billow
from billow.base.errors import LONGEST_TEXT, BillowError, InputError
from trust import fuzz, payloads
from trust.mutations import mutate_bytes


@pytest.fixture(scope="module")
def report():
    return fuzz.fuzz(1600, seed=7)


def test_no_input_ends_in_a_traceback(report):
    assert report.tracebacks == []
    assert report.inputs == report.refused + report.accepted >= 1500


def test_no_input_takes_long_or_much(report):
    assert report.slowest_seconds < fuzz.SECONDS
    assert 0 < report.peak_bytes < fuzz.MEMORY


def test_every_kind_is_fed_and_the_generators_reach_both_ends(report):
    assert set(report.by_kind) == set(fuzz.KINDS)
    for kind, (accepted, refused) in report.by_kind.items():
        assert refused > 0 or kind == "environments", kind
        if kind.startswith("damaged"):
            assert accepted == 0, kind
    assert report.by_kind["generated cases"][0] > 0.2 * sum(report.by_kind["generated cases"])


class Silent:
    def send(self, message):
        pass


@pytest.mark.parametrize(
    ("use", "words"),
    [
        (lambda: {}["key"], "KeyError"),
        (lambda: _raise(InputError("E-CASE-001", "", where="w", why="y", remedy="t")), "what is empty"),
        (lambda: _raise(InputError("E-CASE-001", "a", where="b", why="Traceback (most recent", remedy="d")), "insides"),
        (lambda: _raise(InputError("E-CASE-001", "a", where="b", why="<a object at 0x7f>", remedy="d")), "insides"),
        (lambda: _raise(InputError("E-CASE-001", "a", where="b", why="zip() argument 2", remedy="d")), "insides"),
        (lambda: _raise(InputError("E-CASE-001", "a", where="b", why="c", remedy="d")), "case.toml is not named"),
        (lambda: _raise(BillowError("E-CLI-070", "a", where="b", why="c", remedy="d")), "a mistake in Billow"),
        (lambda: warnings.warn("overflow", RuntimeWarning, stacklevel=1), "warning 'overflow'"),
        (lambda: _raise(RecursionError()), "RecursionError"),
        (lambda: _raise(fuzz.TooSlow("x")), "TooSlow"),
    ],
)
def test_the_trials_notice_what_they_are_for(use, words):
    trials = fuzz.Trials(Silent())
    trials.begin("test")
    trials.attempt(use, {"an input": 10**5000}, "case.toml" if "named" in words else "")
    assert words in trials.report.tracebacks[0]


def _raise(error):
    raise error


def test_a_message_holds_no_control_characters_and_has_an_end():
    error = InputError("E-CASE-001", "\x1b[31m" + 10_000 * "x", where="a\nb", why="c", remedy="d")
    assert "\x1b" not in str(error)
    assert error.where == "a\\nb"
    assert len(error.what) < 2 * LONGEST_TEXT
    assert isinstance(error, BillowError)


def test_damage_is_always_damage():
    random = Random(1)
    assert all(mutate_bytes(b"", random) != b"" for _ in range(200))
    assert all(mutate_bytes(bytes(50), random) != bytes(50) for _ in range(200))


@pytest.mark.slow
def test_no_payload_is_executed_or_interpreted():
    succeeded, tried = payloads.escapes()
    assert tried >= 500
    assert succeeded == []


def test_an_attack_that_succeeds_is_noticed(monkeypatch):
    """Fields that do what must never be done."""

    def obey(payload):
        if "touch" in payload:
            Path(payloads.CANARY).touch()

    def evaluate(payload):
        return str(2897 * 2981)

    def print_as_is(payload):
        return payload

    for bad in (obey, evaluate, print_as_is):
        monkeypatch.setattr(payloads, "fields", lambda place, bad=bad: {"bad": bad})
        assert payloads.escapes()[0]


@pytest.mark.slow
def test_no_changed_file_is_loaded():
    goals = list(payloads.security(surrogates=500, runs=100))
    assert [(goal, count) for goal, _, count, _ in goals] == [("SEC-1", 0), ("SEC-1", 0), ("SEC-2", 0)]


FORBIDDEN = {
    *("eval", "exec", "compile", "__import__", "os.system", "os.popen", "pickle", "cPickle", "dill", "cloudpickle"),
    *("shelve", "marshal", "joblib", "torch.load", "yaml.load", "subprocess", "numexpr", "pty", "ctypes", "runpy"),
}


NEEDED = {"base/blas_threads.py": {"ctypes"}, "pictures/film.py": {"subprocess"}}
"""File -> what it may use all the same: two functions of the library that NumPy has loaded, and nobody names another;
ffmpeg, by a list of arguments that holds no path of a user."""


def forbidden(source: str) -> set[str]:
    """What a module uses of `FORBIDDEN`."""
    used = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            used |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            used |= {(node.module or "").split(".")[0], *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Call):
            used.add(ast.unparse(node.func))
            used |= {f"{k.arg}={ast.unparse(k.value)}" for k in node.keywords if k.arg in ("allow_pickle", "shell")}
    return used & (FORBIDDEN | {"allow_pickle=True", "shell=True"})


def test_nothing_in_the_package_unpickles_or_evaluates():
    package = Path(billow.__file__).parent
    found = {str(p.relative_to(package)): forbidden(p.read_text(encoding="utf-8")) for p in package.rglob("*.py")}
    assert {path: used for path, used in found.items() if used} == NEEDED


@pytest.mark.parametrize(
    "source",
    [
        "eval('1')",
        "import pickle",
        "from torch import load as torch_load",
        "import os\nos.system('ls')",
        "import numpy\nnumpy.load('x', allow_pickle=True)",
    ],
)
def test_what_is_forbidden_is_noticed(source):
    assert forbidden(source)
