"""Compiled kernels: one decorator, two compilations, one set of bits.

`@kernel` turns a function over arrays into a compiled one. It is compiled serially for small work and in parallel
(`numba.prange`) for large work, each only when first needed, and both are cached on disk. Kernels are written so
that both give the same bits for any number of threads: every loop iteration owns what it writes, and sums are
collected per fixed chunk of `CHUNK` items and added in order afterwards. No fastmath: it breaks NaN checks and
reproducibility.

`@scalar` marks plain scalar functions (a stress, a flux, a closest point) that kernels call; they take and return
numbers and tuples, so that another back end can compile the same text.

numba keeps a stale kernel when a function in *another* file that it calls has changed. The cache folder of a file is
therefore keyed by a hash over that file and every file of the package it imports.
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
import types
from pathlib import Path

import numba

CHUNK = 1024
"""Items summed by one chunk; fixed, because it decides the order of additions and thereby the last bits."""

PARALLEL_FROM = 8192
"""Fewest items for which a parallel launch (10-200 us) pays."""

_PACKAGE = Path(__file__).parents[1]
_IMPORT = re.compile(rb"^\s*(?:from|import) billow\.([\w.]+)", re.MULTILINE)


def cache_folder() -> Path:
    """Folder of all compiled kernels (set BILLOW_CACHE to move it)."""
    root = os.environ.get("BILLOW_CACHE") or os.path.join(
        os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "billow"
    )
    return Path(root) / "kernels"


def _sources(path: Path, found: set[Path]) -> set[Path]:
    """The file and everything of the package it imports, directly or through others."""
    if path not in found and path.is_file():
        found.add(path)
        for name in _IMPORT.findall(path.read_bytes()):
            _sources(_PACKAGE.joinpath(*name.decode().split(".")).with_suffix(".py"), found)
    return found


@functools.cache
def _module_folder(source: str) -> str | None:
    """Folder for the kernels of one file, keyed by its text and all it imports; None if it cannot be written, or if
    there is no file (a kernel typed into a prompt)."""
    if not Path(source).is_file():
        return None
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(_sources(Path(source), {Path(__file__)})):
        digest.update(path.name.encode() + path.read_bytes())
    folder = cache_folder() / f"{Path(source).stem}-{digest.hexdigest()[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:  # a read-only home: kernels are compiled again in every process
        return None
    return str(folder) if os.access(folder, os.W_OK) else None


def _compile(function, **options):
    folder = _module_folder(function.__code__.co_filename)
    numba.config.CACHE_DIR = folder or ""
    return numba.njit(function, cache=folder is not None, error_model="numpy", **options)


numba.config.DISABLE_INTEL_SVML = 1  # vector math of another library would change last bits between machines


def scalar(function):
    """Compile a plain function of numbers that kernels call."""
    return _compile(function, inline="never")


def kernel(function):
    """Compile `function(n, ...)`; `n` is the number of items its outer loop runs over.

    `n` chooses between the serial and the parallel compilation. Both share one source, hence one set of results.
    """
    serial = _compile(function)
    twin = types.FunctionType(
        function.__code__, function.__globals__, function.__name__ + "_parallel", function.__defaults__
    )
    # numba's cache does not tell serial from parallel; the name does.
    twin.__qualname__ = function.__qualname__ + "_parallel"
    twin.__module__ = function.__module__
    parallel = _compile(twin, parallel=True)

    def launch(n, *arguments):
        if n >= PARALLEL_FROM and numba.get_num_threads() > 1:
            return parallel(n, *arguments)
        return serial(n, *arguments)

    launch.__name__, launch.__doc__, launch.__wrapped__ = function.__name__, function.__doc__, function
    launch.serial, launch.parallel = serial, parallel
    return launch
