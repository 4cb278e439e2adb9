"""What a kernel calls is compiled as a part of it: typed and lowered by itself, but optimised and made machine code
only where it ends up.

numba would give each function that a kernel calls machine code of its own, with an entry for callers in Python, and
optimise it anew in every function on the way up to the kernel. That is a third of compiling, for code that nobody runs.
A part that is called from Python after all is compiled once more, as a whole.
"""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import register_pass
from numba.core.sigutils import normalize_signature
from numba.core.typed_passes import NativeLowering

_depth = 0
"""Compilations that have begun and not ended, one within another."""


@contextlib.contextmanager
def compiling() -> Iterator[bool]:
    """Around a compilation: no other thread compiles, and no garbage is sought, which finds next to none and takes a
    tenth of the time. Gives whether it is a part of what is being compiled already."""
    global _depth
    with global_compiler_lock:
        collects = gc.isenabled()
        gc.disable()
        _depth += 1
        try:
            yield _depth > 1
        finally:
            _depth -= 1
            if collects:
                gc.enable()


class Part(JITCodeLibrary):
    """Code that is only linked into other code."""

    def _optimize_final_module(self):
        """Nothing: this is done where it is linked in."""

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):
    """Serial functions that others call become parts of those."""

    _name = "native_lowering_with_parts"

    def run_pass(self, state):
        if _depth <= 1:
            return super().run_pass(state)
        state.flags.no_compile = state.flags.no_cpython_wrapper = True
        state.library = Part(state.targetctx.codegen(), state.func_id.func_qualname)
        done = super().run_pass(state)
        key = object()  # by which numba finds it; there is no function to call
        state.targetctx.insert_user_function(key, state.cr.fndesc, [state.library])
        state["cr"] = state.cr._replace(cfunc=key)
        return done


class PartCompiler(Compiler):
    """numba's own, but for the lowering of serial functions."""

    def define_pipelines(self):
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [(_Lowering if name is NativeLowering else name, why) for name, why in pipeline.passes]
            pipeline.finalize()
        return pipelines


def keep_parts_from_python(compiled) -> None:
    """Lets callers in Python find only what is whole, among the compilations of a dispatcher of numba."""
    add_whole = compiled.add_overload

    def add(found):
        if isinstance(found.library, Part):
            compiled.overloads[tuple(found.signature.args)] = found
        else:
            add_whole(found)

    compiled.add_overload = add


def forget_part(compiled, signature) -> None:
    """Forget a compilation that is a part, so that a whole one takes its place."""
    arguments, _ = normalize_signature(signature)
    found = compiled.overloads.get(tuple(arguments))
    if found is not None and isinstance(found.library, Part):
        del compiled.overloads[tuple(arguments)]
