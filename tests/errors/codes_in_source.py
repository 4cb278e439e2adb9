"""Every error code that stands in the package, with the class it is raised as, read from the syntax tree."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import billow

PACKAGE = Path(billow.__file__).parent
CODE = re.compile(r"[EW]-[A-Z]+-\d{3}")
CLASSES = {"BillowError", "InputError", "NumericalStop", "ResourceError", "IntegrityError", "Warning"}


def codes_in_source() -> dict[str, set[str]]:
    """Code -> names of the classes it is raised as; a code that stands in no call has none."""
    found: dict[str, set[str]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        if "error_catalogue" in path.parts:
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        constants = _constants(tree)
        for node in ast.walk(tree):
            code = _code(node, constants)
            if code is not None:
                found.setdefault(code, set())
            if isinstance(node, ast.Call) and node.args and (code := _code(node.args[0], constants)):
                found.setdefault(code, set()).update(_classes(node, tree))
    return found


def _constants(tree: ast.Module) -> dict[str, str]:
    """Codes that have a name in a module."""
    return {
        node.targets[0].id: node.value.value
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and _code(node.value, {})
    }


def _code(node: ast.AST, constants: dict[str, str]) -> str | None:
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and CODE.fullmatch(node.value):
        return node.value
    return constants.get(node.id) if isinstance(node, ast.Name) else None


def _classes(call: ast.Call, tree: ast.Module) -> Iterator[str]:
    """The class a call makes: its own, or that of the function of this module that it hands the code to."""
    name = call.func.id if isinstance(call.func, ast.Name) else getattr(call.func, "attr", "")
    if name in CLASSES:
        yield name
        return
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef) and function.name == name:
            given = {argument.arg for argument in function.args.args}
            for inner in ast.walk(function):
                hands_on = isinstance(inner, ast.Call) and inner.args and isinstance(inner.args[0], ast.Name)
                if hands_on and inner.args[0].id in given:
                    yield from _classes(inner, tree)
