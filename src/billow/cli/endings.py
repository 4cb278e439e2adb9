"""How a command ends before its time, and what it does when nobody can read any more what it prints."""

from __future__ import annotations

import contextlib
import errno
import os
import shlex
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import typer

from billow.results.atomic import CHECKPOINTS, PARTIAL

CONTINUES = "the same command continues it"
INTERRUPTED = 130  # exit code after Ctrl-C
_READER_GONE = (errno.EPIPE, errno.EIO)
"""A closed pipe, as of `| head`; a terminal that was closed."""


class LastingStream:
    """Standard output or error of a command that goes on when its reader leaves: the rest is dropped.

    problem: why something could not be written though it has a reader, such as a file on a full disk.
    """

    def __init__(self, stream):
        self._stream = stream
        self.problem: OSError | None = None

    def write(self, text: str) -> int:
        with self._dropping():
            return self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        with self._dropping():
            self._stream.flush()

    def __getattr__(self, name: str):
        return getattr(self._stream, name)

    @contextlib.contextmanager
    def _dropping(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            if error.errno not in _READER_GONE:
                self.problem = error
            nowhere = os.open(os.devnull, os.O_WRONLY)
            with contextlib.suppress(OSError):  # what is kept back goes there, now and when Python ends
                os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)


@contextlib.contextmanager
def lasting_streams() -> Iterator[None]:
    """Standard output and error are `LastingStream`s in the block; a process may have been started without them."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (stream and LastingStream(stream) for stream in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def end_as_with_ctrl_c() -> None:
    """Let SIGTERM, SIGHUP and SIGXCPU end a command as Ctrl-C does, so that it can save and clean up.

    A signal that is ignored, as under nohup, stays so.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    for name in ("SIGTERM", "SIGHUP", "SIGXCPU"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)


@contextlib.contextmanager
def interruptible(then: str, out: Path | None = None) -> Iterator[None]:
    """When the block is interrupted, say how to go on, and exit with code 130.

    out: of a run; what can be done depends on whether it has a checkpoint. then: what to do without one.
    """
    try:
        yield
    except KeyboardInterrupt as stop:
        if out is not None:
            partial = out.absolute().parent / (out.absolute().name + PARTIAL)
            if any((partial / name).exists() for name in CHECKPOINTS):
                then = f"continue it: billow resume {shlex.quote(str(out))}"
        print(f"interrupted; {then}", file=sys.stderr)
        raise typer.Exit(INTERRUPTED) from stop
