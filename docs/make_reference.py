"""Write docs/case.md from the schema of the case, so that the reference cannot drift from the code.

`make docs` runs it; a test compares its output with the file.
"""

from __future__ import annotations

import inspect
import types
import typing
from pathlib import Path

from billow.case import schema, schema_obstacle
from billow.case.quantity import Strict, unit_of
from billow.demo import CASE
from billow.units import CONVERSIONS

TARGET = Path(__file__).with_name("case.md")

INTRODUCTION = f"""# The case file

A case is one TOML file. Unknown keys are refused. A number is in the unit of the table; a text such as `"0.3 mm"` is
converted. Values outside the plausible range are refused, because they are nearly always a slip of units. Every key
has a default except where none makes sense; the run's `case.toml` holds all of them.

An example (`billow check --example`):

```toml
{CASE.strip()}
```

Curves against time are tables of equally long lists, piecewise linear:
`mass_flow = {{ time = [0, "8 ms", "50 ms"], value = [0, 2.0, 0] }}`.

Accepted units: {"; ".join(f"{unit}: {', '.join(texts)}" for unit, texts in CONVERSIONS.items() if unit != "-")}.
"""


def render() -> str:
    """The whole page."""
    parts = [INTRODUCTION, *_section("", schema.Case)]
    return "\n".join(parts).rstrip() + "\n"


def _section(key: str, model: type[Strict]) -> list[str]:
    """Heading, text and table of one table of the case, then those inside it."""
    title = (
        f"[[{key}]]"
        if model in (schema_obstacle.Plate, schema_obstacle.SuperEllipsoid)
        else f"[{key}]"
        if key
        else "Top level"
    )
    rows, inner = [], []
    for name, field in model.model_fields.items():
        nested = _models(field.annotation)
        path = f"{key}.{name}" if key else name
        if nested and not any(m.__name__.startswith("Curve") for m in nested):
            for choice in nested:
                inner += _section(path, choice)
            continue
        rows.append(f"| `{name}` | {_kind(field)} | {_default(field)} | {field.description or ''} |")
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
    if typing.get_origin(annotation) in (typing.Annotated, typing.Union, types.UnionType, tuple):
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
            text = f"{len(typing.get_args(field.annotation))} numbers, {text}"
        return text + (" or curve" if curve else "")
    if curve:
        name = _models(field.annotation)[0].__name__
        return f"curve, {name.removeprefix('Curve[').removesuffix(']')}"
    if typing.get_origin(field.annotation) is typing.Literal:
        return " or ".join(f"`{option}`" for option in typing.get_args(field.annotation))
    return (
        getattr(field.annotation, "__name__", "table")
        .replace("str", "text")
        .replace("bool", "true or false")
        .replace("int", "whole number")
    )


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
