"""Write docs/case.md from the schema of the case, so that the reference cannot drift from the code.

`make docs` runs it; a test compares its output with the file.
"""

from __future__ import annotations

import inspect
import types
import typing
from pathlib import Path

from billow.base.attribute_docstrings import attribute_docstrings
from billow.base.units import CONVERSIONS
from billow.case import schema
from billow.case.quantity import Documented, Strict, unit_of
from billow.cli.example import EXAMPLE

TARGET = Path(__file__).with_name("case.md")

INTRODUCTION = f"""# The case file

A case is one TOML file. Unknown keys are refused. A number is in the unit of the table; a text such as `"0.3 mm"` is
converted. Values outside the plausible range are refused, because they are nearly always a slip of units. Every key
has a default except where none makes sense; the run's `case.toml` holds all of them.

An example (`billow check --example`):

```toml
{EXAMPLE.strip()}
```

`billow schema case` prints the JSON schema of a case, for editors (docs/study.md).

Curves against time are tables of equally long lists, piecewise linear:
`mass_flow = {{ time = [0, "8 ms", "50 ms"], value = [0, 2.0, 0] }}`.

Accepted units: {"; ".join(f"{unit}: {', '.join(texts)}" for unit, texts in CONVERSIONS.items() if unit != "-")}.
"""


def render() -> str:
    """The whole page."""
    parts = [INTRODUCTION, *_section("", schema.Case, set())]
    return "\n".join(parts).rstrip() + "\n"


def _section(key: str, model: type[Strict], told: set, several: bool = False) -> list[str]:
    """Heading, text and table of one table of the case, then those inside it that were not told yet."""
    if (key, model) in told:
        return []
    told.add((key, model))
    title = "Top level" if not key else f"[[{key}]]" if several else f"[{key}]"
    rows, inner = [], []
    for name, field in sorted(
        model.model_fields.items(), key=lambda item: item[0] != model.chooser
    ):  # it chooses the rest
        nested = _models(field.annotation)
        path = f"{key}.{name}" if key else name
        if typing.get_origin(field.annotation) is dict:
            path += ".NAME"  # tables under names of the user's
        if nested and not any(m.__name__.startswith("Curve") for m in nested):
            for choice in nested:
                inner += _section(path, choice, told, typing.get_origin(field.annotation) is tuple)
            continue
        description = " ".join(attribute_docstrings(model).get(name, "").split())
        rows.append(f"| `{name}` | {_kind(field)} | {_default(field)} | {description} |")
    heading = [
        f"## `{title}` {model.__name__}" if key else f"## {title}",
        "",
        inspect.cleandoc(model.__doc__ or ""),
        "",
    ]
    table = ["| key | unit, range | default | meaning |", "|---|---|---|---|", *rows, ""] if rows else []
    return heading + table + inner


def _models(annotation) -> list[type[Strict]]:
    if isinstance(annotation, type) and issubclass(annotation, Strict):
        return [annotation]
    if typing.get_origin(annotation) in (typing.Annotated, typing.Union, types.UnionType, tuple, dict):
        return [model for part in typing.get_args(annotation) for model in _models(part)]
    return []


def _quantities(annotation) -> list:
    found = [unit_of(types.SimpleNamespace(metadata=getattr(annotation, "__metadata__", ())))]
    for part in typing.get_args(annotation):
        found += _quantities(part)
    return [f for f in found if f is not None]


def _kind(field) -> str:
    documented = [unit_of(field), *_quantities(field.annotation)]
    documented = [d for d in documented if d is not None]
    curve = any(m.__name__.startswith("Curve") for m in _models(field.annotation))
    if documented:
        d = documented[0]
        text = f"{d.unit}, {d.low:g} to {d.high:g}"
        if typing.get_origin(field.annotation) is tuple:
            numbers = typing.get_args(field.annotation)
            text = f"{'list of' if Ellipsis in numbers else len(numbers)} numbers, {text}"
        words = [f" or `{option}`" for option in _words(field.annotation)]
        return text + "".join(words) + (" or curve" if curve else "")
    if curve:
        name = _models(field.annotation)[0].__name__
        return f"curve, {name.removeprefix('Curve[').removesuffix(']')}"
    if words := _words(field.annotation):
        choice = " or ".join(f"`{option}`" for option in words)
        return f"list of {choice}" if typing.get_origin(field.annotation) is tuple else choice
    if typing.get_origin(field.annotation) is tuple:
        return f"list of {_plain(typing.get_args(field.annotation)[0])}s"
    limits = next((f", {m.low} to {m.high}" for m in field.metadata if isinstance(m, Documented)), "")
    return _plain(field.annotation) + limits


def _plain(annotation) -> str:
    while typing.get_origin(annotation) is typing.Annotated:
        annotation = typing.get_args(annotation)[0]
    name = getattr(annotation, "__name__", "table")
    return name.replace("str", "text").replace("bool", "true or false").replace("int", "whole number")


def _words(annotation) -> list[str]:
    """Options of every literal in a type."""
    if typing.get_origin(annotation) is typing.Literal:
        return list(typing.get_args(annotation))
    return [word for part in typing.get_args(annotation) for word in _words(part)]


def _default(field) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    if hasattr(value, "model_dump"):
        value = ", ".join(f"{k} = {list(v)}" for k, v in value.model_dump().items())
    if isinstance(value, float):
        value = f"{value:g}"
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


if __name__ == "__main__":
    TARGET.write_text(render(), encoding="utf-8")
