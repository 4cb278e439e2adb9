"""What surrounds the command and must not decide what it answers: environment variables, terminal, settings files.

The libraries below listen to some hundred variables. Some change last bits, some name files to load, and many end the
process when they hold what was not meant. The command takes them away before it loads the libraries.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import logging
import os
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

FOREIGN = (
    *("ATEN_", "C10_", "FSSPEC_", "GOMP_", "GOTO_", "H5PY_", "HDF5_", "KMP_", "MKL_", "NPY_", "OMP_", "OPENBLAS_"),
    *("ORT_", "PILLOW_", "PYDANTIC_", "PYTORCH_", "SCIPY_", "TORCH", "TYPER_", "_TYPER_", "_BILLOW_"),
    *("MPLBACKEND", "MATPLOTLIBRC", "UNICODE_VERSION"),
)
"""How the names of variables begin that our libraries listen to; numba's are looked after by `billow` itself."""

KEPT = ("HDF5_USE_FILE_LOCKING", "OMP_WAIT_POLICY", "GOMP_SPINCOUNT")
"""Of these, what a file system may need and no result depends on, and what `billow` itself has set."""

SETTINGS_FILES = {".numba_config.yaml": "numba", "matplotlibrc": "matplotlib"}
"""File of the working folder -> the library that reads it when it is imported, and may not be able to."""

MOST_DIGITS = 4300
"""Python's own limit of digits of a whole number in a text."""


def show_any_letter() -> None:
    """A terminal that cannot show a letter shows another in its place."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # not if it is closed
            stream.reconfigure(errors="replace")


def take_away(prefixes: tuple[str, ...]) -> None:
    """Remove the environment variables whose names begin so."""
    for name in list(os.environ):
        if name.startswith(prefixes) and name not in KEPT:
            del os.environ[name]


def settle() -> None:
    """Take away what surrounds this process. To be called before its libraries are imported."""
    take_away(FOREIGN)
    # OpenBLAS threads spin while they wait: beside other work they cost more than they gain (a POD of 0.2 s took 17 s),
    # and the last bits of a POD depend on their number.
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    if not os.environ.get("HOME"):
        os.environ.pop("HOME", None)
    if not os.path.isabs(os.path.expanduser("~")):
        os.environ["HOME"] = os.devnull  # libraries would make a folder of the name "~"
    sys.set_int_max_str_digits(MOST_DIGITS)
    warnings.resetwarnings()  # PYTHONWARNINGS=error makes errors of them
    for kind in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning, EncodingWarning):
        warnings.simplefilter("ignore", kind)
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    for name, library in SETTINGS_FILES.items():
        if os.path.lexists(name):
            with contextlib.suppress(ImportError), _elsewhere():
                importlib.import_module(library)


@contextlib.contextmanager
def _elsewhere() -> Iterator[None]:
    here = os.open(".", getattr(os, "O_PATH", os.O_RDONLY))  # a path may have become unreachable
    try:
        os.chdir(Path(__file__).parent)
        yield
    finally:
        os.fchdir(here)
        os.close(here)
