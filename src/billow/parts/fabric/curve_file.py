"""Curves from files: those that come with Billow, and those of a user: CSV of two columns, such as strain and stress or
time and mass_flow, with units in the header if they are not SI, for example

    strain [%], stress [MPa]
    2, 2.2

Rules of CSV: docs/input_files.md.
"""

from __future__ import annotations

import re
import tomllib
from importlib import resources
from pathlib import Path
from typing import Any

from billow.base.errors import InputError
from billow.base.table_file import Table, read_table
from billow.base.units import CONVERSIONS

LARGEST_FILE = 1_000_000  # bytes; a curve has some hundred points
COLUMNS = {"strain": "-", "angle": "deg", "stress": "Pa", "time": "s", "mass_flow": "kg/s", "temperature": "K"}
"""Column -> unit its numbers are returned in, and have if the header names none."""

LIBRARY = {"nylon66-470dtex": "nylon66_470dtex.toml"}
"""Name of a fabric in a case -> file in `data`, which says where its numbers come from and what they are worth."""

_HEAD = re.compile(r"\s*(\w+)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")


UNREADABLE = InputError.declare(
    "E-FAB-001",
    "cannot read the curve file {path!r}",
    where="{path!r}",
    cause="a misspelt path, or one that counts from another folder than that of the case file",
    remedy="check the path; it counts from the folder of the case file",
)
NO_CURVE = InputError.declare(
    "E-FAB-002",
    "{name} holds no curve",
    where="{path}",
    cause="no line that names the columns, a unit that does not fit, mixed decimal marks, or a file of another kind",
    remedy='begin with a line such as "{x} [{unit}], {y}", then one point a line, with a decimal point',
)


def read_curve_file(path: Path, x: str, y: str = "stress") -> dict[str, list[float]]:
    """Columns by name, {x: [...], y: [...]}, in the units of `COLUMNS`.

    Raises InputError E-FAB-001 if the file cannot be read, E-FAB-002 if it is no such table.
    """
    try:
        return _columns(read_table(path, LARGEST_FILE), x, y)
    except OSError as error:
        raise UNREADABLE(path=str(path), why=error) from None
    except ValueError as error:
        unit = {"strain": "%", "time": "ms"}.get(x, COLUMNS[x])
        written = "stress [MPa]" if y == "stress" else f"{y} [{COLUMNS[y]}]"
        raise NO_CURVE(name=path.name, path=path, x=x, unit=unit, y=written, why=error) from None


def _columns(table: Table, x: str, y: str) -> dict[str, list[float]]:
    """Raises ValueError with a sentence for the user."""
    factors: dict[str, float] = {}
    for text in table.names:
        head = _HEAD.fullmatch(text)
        name = head[1].lower() if head else ""
        if name not in (x, y) or name in factors:
            raise ValueError(f"line {table.line} should name the columns {x} and {y}, not {text[:40]!r}")
        units = CONVERSIONS[COLUMNS[name]]
        if (head[2] or COLUMNS[name]) not in units:
            raise ValueError(f"line {table.line}: {head[2]!r} is no unit of {name}; expected one of {', '.join(units)}")
        factors[name] = units[head[2] or COLUMNS[name]]
    if len(factors) != 2:
        raise ValueError(f"line {table.line} should name the columns {x} and {y}")
    values, _ = table.numbers()
    return {name: (values[:, k] * factor).tolist() for k, (name, factor) in enumerate(factors.items())}


def library_curves(name: str) -> dict[str, Any]:
    """Curves of a fabric of the library, as the `[fabric.curves]` table of a case: direction -> branch -> columns."""
    return tomllib.loads((resources.files(__package__) / "data" / LIBRARY[name]).read_text(encoding="utf-8"))
