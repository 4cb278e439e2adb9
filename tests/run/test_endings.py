"""A command that is asked to end saves what it has, says how to go on, and outlives whoever reads what it prints."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys

import pytest
import typer

from billow.cli.endings import LastingStream, end_as_with_ctrl_c, interruptible
from billow.cli.main import main
from billow.results.atomic import CHECKPOINTS
from billow.run.interrupts import Interrupts, RunInterrupted
from billow.run.simulate import simulate
from billow.study.execute import _undisturbed

ENDING = ("SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU")


@pytest.fixture
def kept_handlers():
    before = {number: signal.getsignal(number) for number in (getattr(signal, name) for name in ENDING)}
    yield before
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("name", ENDING)
def test_a_run_saves_itself_before_it_ends(small_case, tmp_path, name):
    def end(progress):
        if progress.time > 0.0:
            signal.raise_signal(getattr(signal, name))

    with pytest.raises(RunInterrupted):
        simulate(small_case, tmp_path / "run", progress=end)
    assert (tmp_path / "run.partial" / CHECKPOINTS[0]).exists()


def test_an_ignored_signal_stays_ignored(tmp_path, kept_handlers):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as under nohup
    end_as_with_ctrl_c()
    with Interrupts(tmp_path) as interrupts, _undisturbed():
        signal.raise_signal(signal.SIGHUP)
    assert not interrupts.stop
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN


@pytest.mark.parametrize("name", ENDING[1:])
def test_other_signals_end_a_command_as_ctrl_c_does(kept_handlers, name):
    signal.signal(getattr(signal, name), signal.SIG_DFL)
    end_as_with_ctrl_c()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(getattr(signal, name))


def test_what_can_be_done_next_is_what_is_told(tmp_path, capsys):
    run, partial = tmp_path / "run", tmp_path / "run.partial"
    partial.mkdir()
    for then in ("the same command begins again", f"continue it: billow resume {run}"):
        with pytest.raises(typer.Exit) as ended, interruptible("the same command begins again", run):
            raise KeyboardInterrupt
        assert ended.value.exit_code == 130
        assert capsys.readouterr().err == f"interrupted; {then}\n"
        (partial / CHECKPOINTS[1]).touch()


def interrupted_start() -> None:
    ask = "import signal; print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))"
    with _undisturbed():
        signal.raise_signal(signal.SIGINT)
        assert subprocess.run([sys.executable, "-c", ask], capture_output=True, check=True).stdout == b"True\n"


def test_ctrl_c_waits_while_workers_start_and_they_never_see_it():
    with pytest.raises(KeyboardInterrupt):
        interrupted_start()
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_output_that_nobody_reads_is_dropped(tmp_path):
    read, write = os.pipe()
    stream = LastingStream(io.TextIOWrapper(open(write, "wb")))  # noqa: SIM115
    os.close(read)
    for _ in range(3):
        print("x" * 100_000, file=stream, flush=True)
    assert stream.problem is None
    stream.close()


def test_output_that_a_full_disk_refuses_is_an_error(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["billow", "--version"])
    monkeypatch.setattr(sys, "stdout", open("/dev/full", "w"))  # noqa: SIM115
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 4
    assert "E-CLI-005" in capsys.readouterr().err


def test_a_listener_that_left_does_not_stop_a_run(small_case, tmp_path):
    def leave(progress):
        raise BrokenPipeError

    assert simulate(small_case.vary({"run.end_time": 1e-3}), tmp_path / "run", progress=leave).status == "completed"
