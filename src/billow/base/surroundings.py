"""Settings files of the working folder that libraries read when they are imported: ours do not depend on them."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def away_from(settings_file: str) -> Iterator[None]:
    """Around the import of a library: it does not find this file, which could set it up otherwise or stop it."""
    if not os.path.lexists(settings_file):
        yield
        return
    here = os.open(".", getattr(os, "O_PATH", os.O_RDONLY))  # a path may have become unreachable
    try:
        os.chdir(Path(__file__).parent)
        yield
    finally:
        os.fchdir(here)
        os.close(here)
