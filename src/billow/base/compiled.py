"""Compiled kernels: one decorator, two compilations, one set of bits (docs/architecture.md, Compiled code).

No fastmath: it breaks NaN checks and reproducibility. The key of the cache is content: the text of a kernel's file and
of every file of the package that it imports, the types of the arguments, the processor, and the versions of Python,
NumPy, numba and llvmlite. Neither the place of a file nor its date counts.

Variables and files that would make numba compile in another way do not count: `base/surroundings.py`.
"""

from __future__ import annotations

import contextlib
import fcntl
import functools
import hashlib
import os
import platform
import re
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import ClassVar

import llvmlite
import numba
import numpy as np
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, _CacheLocator
from numba.core.runtime import rtsys

from billow.base.cache_folder import cache_folder
from billow.base.compiled_parts import PartCompiler, compiling, forget_part, keep_parts_from_python

config._config_fname = os.devnull  # numba looks for its settings file in the working folder
config.reload_config()
# Neighbours in memory, such as the six numbers of an entry, become vector instructions: 5 % of the triangle pass, the
# same bits. numba leaves it out for the sake of old versions of LLVM.
config.SLP_VECTORIZE = 1

CHUNK = 1024
"""Items summed by one chunk; fixed, because it decides the order of additions and thereby the last bits."""

PARALLEL_FROM = 8192
"""Fewest items for which a parallel launch (10-200 us) pays."""

COMPILING = "compiling (first run only)"
NOT_KEPT = "compiling (in every run: the cache of kernels cannot be written)"

_listeners: list[Callable[[str], None]] = []
_PACKAGE = Path(__file__).parents[1]


@contextlib.contextmanager
def telling(tell: Callable[[str], None]) -> Iterator[None]:
    """Calls `tell` once, with a line for the user, when within it the first kernel has to be compiled, not loaded."""
    _listeners.append(tell)
    try:
        yield
    finally:
        if tell in _listeners:
            _listeners.remove(tell)


def _announce(line: str) -> None:
    while _listeners:
        _listeners.pop()(line)


_NAMED = re.compile(rb"%b((?:[ \t]*\.[ \t]*\w+)*)" % _PACKAGE.name.encode())
"""A dotted name in the package. It begins with a plain text, which `re` finds ten times faster than anything else."""

_WORD = re.compile(rb"\w+")


@functools.cache
def _modules_in(folder: Path) -> dict[bytes, Path]:
    """Files of the modules and packages in a folder, by name."""
    packages = {os.fsencode(path.name): path / "__init__.py" for path in folder.iterdir() if path.is_dir()}
    return packages | {os.fsencode(path.stem): path for path in folder.glob("*.py")}


@functools.cache
def _digest_and_imports(path: Path) -> tuple[bytes, frozenset[Path]]:
    """SHA-256 of a file, and all files of the package that it may import.

    Every dotted name counts, wherever it stands. Where names are imported from a package, as in `from billow.geometry
    import super_ellipsoid`, every word of the file may be one of them. So a file may be listed that is not imported,
    and none is missed; parsing the files would take a fifth of the start of a run.
    """
    text = path.read_bytes() if path.is_file() else b""  # a package need not have an __init__.py
    found: set[Path] = set()
    for match in _NAMED.finditer(text):
        rest = match[1]
        before = text[max(0, match.start() - 32) : match.start()].replace(b"\\", b" ").split()
        imported = before[-1:] in ([b"from"], [b"import"])
        place = _PACKAGE / "__init__.py"
        for part in _WORD.findall(rest):
            if place.name != "__init__.py" or (inner := _modules_in(place.parent).get(part)) is None:
                break  # a name that the module defines
            place = inner
        else:
            if place.name == "__init__.py" and imported:
                words = set(_WORD.findall(text))
                found |= {file for name, file in _modules_in(place.parent).items() if name in words}
        if rest or imported:
            found.add(place)
    return hashlib.sha256(text).digest(), frozenset(found)


def _digest(source: Path) -> str:
    """Hash over the text of a file and of all files of the package that it imports, directly or through others."""
    found, open_ends = set(), [source, Path(__file__)]
    while open_ends:
        path = open_ends.pop()
        if path not in found:
            found.add(path)
            open_ends += _digest_and_imports(path)[1]
    versions = platform.python_version(), np.__version__, numba.__version__, llvmlite.__version__
    digest = hashlib.sha256(" ".join(versions).encode())
    # By its place in the package; a file outside it, by its name.
    named = [(p.relative_to(_PACKAGE).as_posix() if p.is_relative_to(_PACKAGE) else p.name, p) for p in found]
    for name, path in sorted(named):
        digest.update(os.fsencode(f"{name}\n") + _digest_and_imports(path)[0])
    return digest.hexdigest()


@functools.cache
def _module_folder(source: str) -> str | None:
    """Folder for the kernels of one file; None if it cannot be written, or if there is no file (a kernel typed into a
    prompt): kernels are then compiled again in every process."""
    root = cache_folder()
    if root is None or not Path(source).is_file():
        return None
    folder = Path(root, "kernels", f"{Path(source).stem}-{_digest(Path(source))[:16]}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:  # a read-only home
        return None
    return str(folder) if os.access(folder, os.W_OK) else None


class _ByContent(_CacheLocator):
    """Tells numba the folder of a file's kernels; its name is a hash of all that matters, so no stamp is needed."""

    def __init__(self, function, source: str):
        self._py_file = source
        self._line = function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, py_func, py_file):
        return cls(py_func, py_file)

    def get_cache_path(self) -> str:
        return _module_folder(self._py_file)

    def get_source_stamp(self) -> str:
        return ""

    def get_disambiguator(self) -> str:
        return str(self._line)


class _Impl(CompileResultCacheImpl):
    _locator_classes = (_ByContent,)


class _Entries:
    """The compilations of one kernel on disk, each in files of its own: numba's index and data, and their SHA-256.

    What does not match its sum never reaches numba and LLVM, which could end the process: damaged, half-written and
    foreign files are compiled again. Two writers could set numba's index of all compilations of a kernel against each
    other's files; with an index of one entry they write the same twice at worst.
    """

    def __init__(self, folder: str, kernel: str):
        self._folder, self._kernel = folder, kernel

    def _entry(self, key) -> tuple[IndexDataCacheFile, Path]:
        """numba's files, and the file of their sum."""
        name = f"{self._kernel}-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}"
        return IndexDataCacheFile(self._folder, name, ""), Path(self._folder, f"{name}.sha256")

    @staticmethod
    def _sum(path: Path) -> str:
        digest = hashlib.sha256()
        for part in (path.with_suffix(".nbi"), path.with_suffix(".1.nbc")):
            if not part.is_file():
                raise FileNotFoundError(part)
            digest.update(os.fsencode(f"{path.parent.name}/{part.name} ") + part.read_bytes())
        return digest.hexdigest()

    def load(self, key):
        """What was saved under `key` (argument types, processor, bytecode), or None."""
        file, path = self._entry(key)
        try:
            return file.load(key) if path.is_file() and path.read_bytes() == self._sum(path).encode() else None
        except OSError:
            return None

    def save(self, key, data) -> None:
        file, path = self._entry(key)
        file.flush()  # a damaged index could not be added to
        file.save(key, data)
        with file._open_for_write(str(path)) as whole:  # renamed when it is finished
            whole.write(self._sum(path).encode())

    def flush(self) -> None:
        """Nothing: a folder belongs to one text and never grows stale."""


class _KernelCache(FunctionCache):
    """numba's cache of one kernel, compiled by one process while others wait for it.

    Dask workers and test processes start together and need the same kernels. The lock ends with the process that holds
    it, however it dies. What a kernel calls is a part of it, so no process waits for one while it holds another;
    threads of one process take turns by numba's own lock, which comes first.
    """

    _impl_class = _Impl
    _held: ClassVar[set[Path]] = set()
    """Locks of this process."""

    def __init__(self, function):
        super().__init__(function)
        self._cache_file = _Entries(self._cache_path, self._impl.filename_base)
        self._lock_path = Path(self._cache_path) / f"{self._impl.filename_base}.lock"
        self._scope = contextlib.ExitStack()

    @contextlib.contextmanager
    def whole(self, is_part: bool) -> Iterator[None]:
        """Around a compilation: the lock that a miss takes is given back, and parts are neither loaded nor kept."""
        with contextlib.ExitStack() as scope:
            before = self._scope, self._enabled
            self._scope, self._enabled = scope, not is_part
            try:
                yield
            finally:
                self._scope, self._enabled = before

    def load_overload(self, sig, target_context):
        """What is saved. If nothing is, take the lock and look again: another process may have compiled it."""
        if not self._enabled:
            return None
        # Machine code needs numba's memory management, and none of the types and functions that its own method makes
        # known to the compiler first: they take 0.15 s.
        rtsys.initialize(target_context)
        found = self._load_overload(sig, target_context)
        if found is None and self._lock_path not in self._held:
            with contextlib.suppress(OSError):  # a file system without locks: the same work is done twice
                fcntl.flock(self._scope.enter_context(self._lock_path.open("ab")), fcntl.LOCK_EX)
            self._held.add(self._lock_path)
            self._scope.callback(self._held.discard, self._lock_path)
            found = self._load_overload(sig, target_context)
        if found is None:
            _announce(COMPILING)
        return found

    def save_overload(self, sig, data) -> None:
        """A folder that is full or gone costs the next process a compilation, and this one nothing."""
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)


def _compile(function, **options):
    # Without an entry for callers in C, which there are none of: 5 % of compiling.
    compiled = numba.njit(
        function, error_model="numpy", no_cfunc_wrapper=True, pipeline_class=PartCompiler, **options
    )  # fmt: skip
    if config.DISABLE_JIT:
        return compiled
    load_or_compile = compiled.compile
    keep_parts_from_python(compiled)
    cache = None
    if _module_folder(function.__code__.co_filename) is not None:
        cache = compiled._cache = _KernelCache(function)

    def compile_once(signature):
        with compiling() as is_part:
            if not is_part:
                forget_part(compiled, signature)
            if cache is not None:
                with cache.whole(is_part):
                    return load_or_compile(signature)
            if not is_part:
                _announce(NOT_KEPT)
            return load_or_compile(signature)

    compiled.compile = compile_once
    return compiled


def scalar(function):
    """Compile a function that kernels call, of numbers or of a whole block of them: a call counts the references of its
    arrays."""
    return _compile(function, inline="never")


def spliced(function):
    """Compile a function that stands in the machine code of its callers, however long it is, so that loops which call
    it become vector instructions."""
    return _compile(function, inline="never", forceinline=True)


def inlined(function):
    """Compile a function that stands as its text where it is called, for the few that take arrays in innermost loops
    and are so short that counting the references of the arrays would show. Each text is compiled anew wherever it
    stands, which takes two to three times as long as `spliced`."""
    return _compile(function, inline="always")


def team(n: int) -> int:
    """Threads that a kernel is launched with for n items."""
    return numba.get_num_threads() if n >= PARALLEL_FROM else 1


class Kernel:
    """A function of n items, compiled twice; either is made ready when it is first called, for a run needs few of all
    that there are."""

    def __init__(self, function):
        functools.update_wrapper(self, function)

    @functools.cached_property
    def serial(self):
        return _compile(self.__wrapped__)

    @functools.cached_property
    def parallel(self):
        function = self.__wrapped__
        twin = types.FunctionType(
            function.__code__, function.__globals__, function.__name__ + "_parallel", function.__defaults__
        )
        # numba's cache does not tell serial from parallel; the name does.
        twin.__qualname__ = function.__qualname__ + "_parallel"
        twin.__module__ = function.__module__
        return _compile(twin, parallel=True)

    def __call__(self, n, *arguments):
        return (self.parallel if team(n) > 1 else self.serial)(n, *arguments)


def kernel(function) -> Kernel:
    """Compile `function(n, ...)`; `n` is the number of items its outer loop runs over.

    `n` chooses between the serial and the parallel compilation. Both share one source, hence one set of results.
    """
    return Kernel(function)
