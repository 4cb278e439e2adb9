"""What surrounds a process and must not decide how kernels are compiled: numba's variables and its settings file."""

from __future__ import annotations

import contextlib
import importlib
import os
from collections.abc import Iterator
from pathlib import Path

MOST_THREADS = 1024
"""Threads that may be asked for; a system may not start more, and numba then ends the process."""


@contextlib.contextmanager
def elsewhere() -> Iterator[None]:
    """Around the import of a library that reads a settings file of the working folder: it does not find it."""
    here = os.open(".", getattr(os, "O_PATH", os.O_RDONLY))  # a path may have become unreachable
    try:
        os.chdir(Path(__file__).parent)
        yield
    finally:
        os.fchdir(here)
        os.close(here)


def own_compiler() -> None:
    """Take away what would make numba compile in another way, and what it cannot read; before it is imported.

    The number of threads stays: results do not depend on it. numba reads its environment again whenever that changes,
    so what we ask of it must stand there, too.
    """
    for name in [name for name in os.environ if name.startswith(("NUMBA_", "LLVMLITE_"))]:
        value = os.environ[name]
        if name != "NUMBA_NUM_THREADS" or not (value.isdecimal() and 0 < int(value[:9]) <= MOST_THREADS):
            del os.environ[name]
    # Vector math of another library would change last bits between machines.
    os.environ["NUMBA_DISABLE_INTEL_SVML"] = "1"
    if os.path.lexists(".numba_config.yaml"):
        with elsewhere():
            importlib.import_module("numba")
