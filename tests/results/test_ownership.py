"""A folder that is written to belongs to one process, and nothing that Billow did not make is removed or replaced."""

from __future__ import annotations

import errno
import fcntl
import os
import signal
import subprocess
import sys

import pytest

from billow.base.errors import InputError
from billow.results.atomic import new_folder, new_place
from billow.results.ownership import LOCK, MARK, discard, mark, owned, owned_file
from billow.run.simulate import resume

HOLD = """
import sys, time
from billow.results.ownership import owned
with owned(sys.argv[1]):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that holds `tmp_path`/out."""
    command = [sys.executable, "-c", HOLD, str(tmp_path / "out"), "--held"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    )
    assert process.stdout.readline() == b"held\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def test_a_second_owner_is_refused_and_told_who_the_first_is(holder, tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "out")
    for name in ("out", "link"):  # two paths to one folder
        with pytest.raises(InputError, match="E-RES-023") as caught, owned(tmp_path / name):
            pass
        assert f"process {holder.pid} on {os.uname().nodename} since 2" in caught.value.why
        assert "--held" in caught.value.why


def test_the_lock_of_a_killed_process_blocks_nobody(holder, tmp_path):
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert str(holder.pid) in (tmp_path / "out" / LOCK).read_text()
    with owned(tmp_path / "out"):
        assert str(os.getpid()) in (tmp_path / "out" / LOCK).read_text()


def test_two_owners_in_one_process_are_two(tmp_path):
    with owned(tmp_path / "out"), pytest.raises(InputError, match="E-RES-023"), owned(tmp_path / "out"):
        pass
    file = tmp_path / "a.csv"
    with owned_file(file, b""), pytest.raises(InputError, match="E-RES-023"), owned_file(file, b""):
        pass
    assert os.listdir(tmp_path) == []  # nothing was written, nothing is left


def test_a_folder_of_somebody_else_is_left_alone(tmp_path):
    mine = tmp_path / "mine"
    mine.mkdir()
    with owned(mine):  # an empty one may be used
        pass
    assert os.listdir(mine) == []
    (mine / "thesis.txt").write_text("mine")
    with pytest.raises(InputError, match="E-RES-024"), owned(mine):
        pass
    discard(mine)
    assert os.listdir(mine) == ["thesis.txt"]
    mark(mine)
    (tmp_path / "link").symlink_to(mine)
    discard(tmp_path / "link")
    assert (mine / "thesis.txt").exists()
    discard(mine)
    assert not mine.exists()


def test_a_lock_that_is_a_link_or_a_file_of_yours_is_left_alone(tmp_path):
    (tmp_path / "precious").write_text("mine")
    for make in (
        lambda lock: lock.symlink_to(tmp_path / "precious"),
        lambda lock: lock.symlink_to(tmp_path / "nothing"),
        lambda lock: os.link(tmp_path / "precious", lock),
        lambda lock: lock.mkdir(),
        lambda lock: os.mkfifo(lock),
    ):
        folder = tmp_path / "out"
        folder.mkdir()
        make(folder / LOCK)
        with pytest.raises(InputError, match="E-RES-024"), owned(folder, "study.toml"):
            pass
        assert (tmp_path / "precious").read_text() == "mine"
        assert not (tmp_path / "nothing").exists()
        (folder / LOCK).rmdir() if (folder / LOCK).is_dir() else (folder / LOCK).unlink()
        folder.rmdir()


def test_a_file_of_somebody_else_is_not_replaced(tmp_path):
    path = tmp_path / "out.csv"
    path.write_text("a [-]\n1\n")
    with owned_file(path, b"a [-]"):
        pass
    with pytest.raises(InputError, match="E-RES-024"), owned_file(path, b"b [-]"):
        pass
    path.unlink()
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="E-RES-024"), owned_file(path, b""):
        pass


def test_a_file_system_without_locks_is_named_and_used(tmp_path, monkeypatch, capsys):
    def refuse(*_):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refuse)
    with owned(tmp_path / "out"):
        assert (tmp_path / "out" / LOCK).read_text().startswith(MARK)
    said = capsys.readouterr().err
    assert "W-RES-001" in said
    assert str(tmp_path / "out") in said


def test_a_place_that_cannot_be_used_is_refused_at_the_start(tmp_path, monkeypatch):
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    (tmp_path / "file").write_text("mine")
    (tmp_path / "link").symlink_to(here)
    (tmp_path / "dangling").symlink_to(tmp_path / "nothing")
    for place in (".", "", "..", "/", "/proc", "../here", tmp_path / "link", tmp_path / "dangling", tmp_path / "file"):
        with pytest.raises(InputError, match="E-RES-009"):
            new_place(place)
    with pytest.raises(InputError, match="E-RES-025"):
        new_place("new/..")
    (tmp_path / "disk").mkdir()
    assert new_place("../disk") == tmp_path / "disk"
    monkeypatch.setattr(os.path, "ismount", lambda path: path.name == "disk")
    with pytest.raises(InputError, match=r"E-RES-009(.|\n)*mounted"):
        new_place("../disk")
    with owned("run.partial"), pytest.raises(InputError, match="E-RES-025"):
        new_place("run.partial/inside")


def test_a_link_on_the_way_may_change_its_goal_meanwhile(tmp_path):
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
    (tmp_path / "way").symlink_to(tmp_path / "first")
    with new_folder(f"{tmp_path}/way/out/") as partial:  # also with a slash at its end
        (tmp_path / "way").unlink()
        (tmp_path / "way").symlink_to(tmp_path / "second")
        (partial / "a").write_text("a")
    assert os.listdir(tmp_path / "first" / "out") == ["a"]
    assert os.listdir(tmp_path / "second") == []


def test_a_partial_folder_of_yours_is_left_alone(tmp_path):
    yours = tmp_path / "out.partial"
    yours.mkdir()
    (yours / "thesis.txt").write_text("mine")
    with pytest.raises(InputError, match="E-RES-024"), new_folder(tmp_path / "out"):
        pass
    (yours / "thesis.txt").rename(tmp_path / "thesis.txt")
    yours.rmdir()
    (tmp_path / "empty").mkdir()
    yours.symlink_to(tmp_path / "empty")
    with pytest.raises(InputError, match="E-RES-024"), new_folder(tmp_path / "out"):
        pass
    assert (tmp_path / "thesis.txt").read_text() == "mine"


def test_an_earlier_try_that_was_killed_is_cleared_but_not_a_checkpoint(tmp_path):
    partial = tmp_path / "out.partial"
    for name, code in (("half.csv", None), ("checkpoint_b.safetensors", "E-RES-022"), ("run.json", "E-RES-022")):
        partial.mkdir()
        mark(partial)
        (partial / name).write_text("half")
        if code:
            with pytest.raises(InputError, match=code), new_folder(tmp_path / "out"):
                pass
            assert (partial / name).exists()
            discard(partial)
        else:
            with new_folder(tmp_path / "out"):
                pass
            assert os.listdir(tmp_path / "out") == []
            (tmp_path / "out").rmdir()


def fill_and_fail(place):
    with new_folder(place) as partial:
        (partial / "a").write_text("a")
        raise ZeroDivisionError


def test_nothing_is_left_of_what_failed(tmp_path):
    with pytest.raises(ZeroDivisionError):
        fill_and_fail(tmp_path / "out")
    assert os.listdir(tmp_path) == []


def test_the_root_has_no_name_and_is_refused_all_the_same():
    with pytest.raises(InputError, match="E-RES-024"), owned_file("/", b"sign"):
        pass
    with pytest.raises(InputError, match="E-RES-009"):
        new_place("/")
    with pytest.raises(InputError, match="E-RES-021"):
        resume("/")
