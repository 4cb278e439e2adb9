"""Compiled kernels: one decorator, two compilations, one set of bits.

`@kernel` turns a function over arrays into a compiled one. It is compiled serially for small work and in parallel
(`numba.prange`) for large work, each only when first needed, and both are cached on disk. Kernels are written so
that both give the same bits for any number of threads: every loop iteration owns what it writes, and sums are
collected per fixed chunk of `CHUNK` items and added in order afterwards. No fastmath: it breaks NaN checks and
reproducibility.

`@scalar` marks plain scalar functions (a stress, a flux, a closest point) that kernels call; they take and return
numbers and tuples, so that another back end can compile the same text.

numba keeps a stale kernel when a function in *another* file that it calls has changed. The cache folder is therefore
keyed by a hash over every source file that holds kernels.
"""

from __future__ import annotations

import hashlib
import os
import types
from pathlib import Path

import numba

CHUNK = 1024
"""Items summed by one chunk; fixed, because it decides the order of additions and thereby the last bits."""

PARALLEL_FROM = 8192
"""Fewest items for which a parallel launch (10-200 us) pays."""


def _source_key() -> str:
    package = Path(__file__).parent
    digest = hashlib.sha256(numba.__version__.encode())
    for folder in ("geometry", "fabric", "gas", "contact", "impactor", "dynamics"):
        for path in sorted((package / folder).glob("*.py")):
            text = path.read_bytes()
            if b"@kernel" in text or b"@scalar" in text:
                digest.update(path.name.encode() + text)
    digest.update(Path(__file__).read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Folder of compiled kernels for exactly these sources (set BILLOW_CACHE to move it)."""
    root = os.environ.get("BILLOW_CACHE") or os.path.join(
        os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "billow"
    )
    return Path(root) / "kernels" / _source_key()


_FOLDER = cache_folder()
try:
    _FOLDER.mkdir(parents=True, exist_ok=True)
    numba.config.CACHE_DIR = str(_FOLDER)
    _CACHE = os.access(_FOLDER, os.W_OK)
except OSError:  # a read-only home: kernels are compiled again in every process
    _CACHE = False
numba.config.DISABLE_INTEL_SVML = 1  # vector math of another library would change last bits between machines

scalar = numba.njit(cache=_CACHE, error_model="numpy", inline="never")


def is_warm() -> bool:
    """True if some kernels for these sources are already compiled on this machine."""
    return _CACHE and any(_FOLDER.rglob("*.nbc"))


def kernel(function):
    """Compile `function(n, ...)`; `n` is the number of items its outer loop runs over.

    `n` chooses between the serial and the parallel compilation. Both share one source, hence one set of results.
    """
    serial = numba.njit(function, cache=_CACHE, error_model="numpy")
    twin = types.FunctionType(
        function.__code__, function.__globals__, function.__name__ + "_parallel", function.__defaults__
    )
    # numba's cache does not tell serial from parallel; the name does.
    twin.__qualname__ = function.__qualname__ + "_parallel"
    twin.__module__ = function.__module__
    parallel = numba.njit(twin, cache=_CACHE, error_model="numpy", parallel=True)

    def launch(n, *arguments):
        if n >= PARALLEL_FROM and numba.get_num_threads() > 1:
            return parallel(n, *arguments)
        return serial(n, *arguments)

    launch.__name__, launch.__doc__, launch.__wrapped__ = function.__name__, function.__doc__, function
    launch.serial, launch.parallel = serial, parallel
    return launch
