"""The declared codes, and how the source declares and raises them, read from its syntax trees."""

from __future__ import annotations

import ast
import importlib.util
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from string import Formatter

import billow
from billow.base.errors import Code

PACKAGE = Path(billow.__file__).parent
PATTERN = re.compile(r"[EW]-[A-Z]+-\d{3}")
TEXTS = ("what", "where", "why", "remedy")

_spec = importlib.util.spec_from_file_location("make_errors", Path(__file__).parents[2] / "docs" / "make_errors.py")
make_errors = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(make_errors)

ALL = make_errors.codes()
"""Every code of the package, by name; making it imports every module."""


def trees() -> Iterator[tuple[Path, ast.Module]]:
    """Path in the package and syntax tree of every module."""
    for path in sorted(PACKAGE.rglob("*.py")):
        yield path.relative_to(PACKAGE), ast.parse(path.read_text(encoding="utf-8"))


def written_out(tree: ast.Module) -> list[str]:
    """Codes that stand as texts in a module."""
    texts = [n.value for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, str)]
    return [text for text in texts if PATTERN.fullmatch(text)]


def raised(path: Path, tree: ast.Module) -> Iterator[tuple[str, Code, set[str]]]:
    """Where a module makes an error: the line, its code and the names of what is filled in."""
    name = ".".join(("billow", *path.with_suffix("").parts)).removesuffix(".__init__")
    known = {name: value for name, value in vars(sys.modules[name]).items() if isinstance(value, Code)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in known:
            assert not node.args
            assert all(keyword.arg for keyword in node.keywords), "**values hide what is given"
            yield f"{path}:{node.lineno}", known[node.func.id], {keyword.arg for keyword in node.keywords}


def placeholders(template: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(template) if name is not None}


def unfilled(code: Code, given: set[str]) -> set[str]:
    """Placeholders and texts that a message would lack."""
    declared = {part: getattr(code, part) for part in TEXTS if part not in given}
    needed = {name for text in declared.values() for name in placeholders(text)}
    return needed - given | {part for part, text in declared.items() if not text}


def unused(code: Code, given: set[str]) -> set[str]:
    """What is given and stands in no text."""
    used = {name for part in TEXTS if part not in given for name in placeholders(getattr(code, part))}
    return given - used - set(TEXTS)
