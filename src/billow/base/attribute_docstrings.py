"""What the text below an attribute says: read from the source when it is asked for.

pydantic can do it when classes are made (`use_attribute_docstrings`); that takes 0.15 s of every start.
"""

from __future__ import annotations

import ast
import functools
import inspect
import itertools
import textwrap
from typing import Any


@functools.cache
def attribute_docstrings(table: type) -> dict[str, str]:
    """Attribute -> the text below it, for a class and its bases; empty without a source."""
    found: dict[str, str] = {}
    for base in reversed(table.__mro__):
        try:
            source = inspect.getsource(base)
        except (OSError, TypeError):  # made at run time, or built in
            continue
        (definition,) = ast.parse(textwrap.dedent(source)).body
        for attribute, below in itertools.pairwise(definition.body):
            if isinstance(attribute, ast.AnnAssign) and isinstance(below, ast.Expr):
                text = getattr(below.value, "value", None)
                if isinstance(text, str):
                    found[attribute.target.id] = inspect.cleandoc(text)
    return found


def described(table: type, schema: dict[str, Any], handler: Any) -> dict[str, Any]:
    """The JSON schema of a table with the texts of its keys, for pydantic's hook `__get_pydantic_json_schema__`."""
    keys = handler.resolve_ref_schema(schema).get("properties", {})
    for key, text in attribute_docstrings(table).items():
        if key in keys:
            keys[key].setdefault("description", text)
    return schema
