"""One thread for NumPy's products of matrices, while something is answered.

OpenBLAS splits a product among its threads, and each waits, spinning, for the slowest: where another program keeps a
core busy, an answer of 0.3 ms takes 100 to 200 ms (p90, two cores with two busy loops), and on idle cores no less than
with one thread. The last bits of a product depend on the number of threads as well.

threadpoolctl does not fit: its limit belongs to the first thread that sets one (3.8), and ends when that thread leaves,
while others still answer.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

_lock = threading.Lock()
_within = 0
_before = 1


@contextlib.contextmanager
def one_blas_thread() -> Iterator[None]:
    """One thread within; as many as before when all that are within have left. Also a decorator: `@one_blas_thread()`.

    For the OpenBLAS that comes with NumPy; another BLAS stays as it is.
    """
    global _within, _before
    blas = _openblas()
    with _lock:
        if blas is not None and _within == 0:
            _before = blas.count()
            if _before > 1:
                blas.use(1)
        _within += 1
    try:
        yield
    finally:
        with _lock:
            _within -= 1
            if blas is not None and _within == 0 and _before > 1:
                blas.use(_before)


class _OpenBlas(NamedTuple):
    count: Callable[[], int]
    use: Callable[[int], None]


@functools.cache
def _openblas() -> _OpenBlas | None:
    """The library that NumPy has loaded; None if it uses another, or one whose functions have other names."""
    package = Path(np.__file__).parent
    for folder in (package.with_name("numpy.libs"), package / ".dylibs"):  # of the wheels for Linux and macOS
        for path in folder.glob("*openblas*"):
            with contextlib.suppress(OSError, AttributeError):
                library = ctypes.CDLL(str(path))
                count, use = (getattr(library, f"scipy_openblas_{verb}_num_threads64_") for verb in ("get", "set"))
                count.argtypes, count.restype = [], ctypes.c_int
                use.argtypes, use.restype = [ctypes.c_int], None
                return _OpenBlas(count, use)
    return None
