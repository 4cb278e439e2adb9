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


def raised(path: Path, tree: ast.Module) -> Iterator[tuple[str, Code, dict[str, bool]]]:
    """Where a module makes an error: the line, its code, and the names of what is given there.

    Each name says whether its text is written there: another value may be None, which leaves the declared text.
    """
    name = ".".join(("billow", *path.with_suffix("").parts)).removesuffix(".__init__")
    known = {name: value for name, value in vars(sys.modules[name]).items() if isinstance(value, Code)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in known:
            assert not node.args
            assert all(keyword.arg for keyword in node.keywords), "**values hide what is given"
            given = {k.arg: isinstance(k.value, ast.Constant | ast.JoinedStr) for k in node.keywords}
            yield f"{path}:{node.lineno}", known[node.func.id], given


def placeholders(template: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(template) if name is not None}


def unfilled(code: Code, given: dict[str, bool]) -> set[str]:
    """Placeholders and texts that a message would lack."""
    declared = [getattr(code, part) for part in TEXTS if not given.get(part)]
    needed = {name for text in declared for name in placeholders(text)}
    return needed - set(given) | {part for part in TEXTS if part not in given and not getattr(code, part)}


def unused(code: Code, given: dict[str, bool]) -> set[str]:
    """What is given and stands in no text."""
    used = {name for part in TEXTS if not given.get(part) for name in placeholders(getattr(code, part))}
    return set(given) - used - set(TEXTS)
