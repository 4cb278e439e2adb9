import os

import pytest

from billow.base.errors import InputError
from billow.results import atomic
from billow.results.atomic import publish_folder, write_atomically


class Crash(Exception):
    pass


def crash(*_):
    raise Crash


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_a_crash_at_any_step_leaves_the_old_file(tmp_path, monkeypatch, call):
    path = tmp_path / "a.txt"
    write_atomically(path, "old")
    monkeypatch.setattr(atomic.os, call, crash)
    with pytest.raises(Crash):
        write_atomically(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


@pytest.mark.parametrize("call", ["fsync", "rename"])
def test_a_crash_while_publishing_publishes_nothing(tmp_path, monkeypatch, call):
    partial, final = tmp_path / "run.partial", tmp_path / "run"
    partial.mkdir()
    (partial / "a.txt").write_text("a")
    monkeypatch.setattr(atomic.os, call, crash)
    with pytest.raises(Crash):
        publish_folder(partial, final)
    assert not final.exists()


def test_a_published_folder_is_never_overwritten(tmp_path):
    partial, final = tmp_path / "run.partial", tmp_path / "run"
    for folder, text in ((partial, "second"), (final, "first")):
        folder.mkdir()
        (folder / "a.txt").write_text(text)
    with pytest.raises(InputError, match="E-RES-009"):
        publish_folder(partial, final)
    assert (final / "a.txt").read_text() == "first"
    assert partial.exists()
