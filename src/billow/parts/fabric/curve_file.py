"""Curves from files: those that come with Billow, and those of a user: CSV of two columns, strain or angle and stress,
with units in the header if they are not SI, for example

    strain [%], stress [MPa]
    2, 2.2
"""

from __future__ import annotations

import csv
import re
import tomllib
from importlib import resources
from pathlib import Path
from typing import Any

from billow.base.errors import InputError
from billow.base.units import to_si

LARGEST_FILE = 1_000_000  # bytes; a curve has some hundred points
COLUMNS = {"strain": "-", "angle": "deg", "stress": "Pa"}
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
    cause="no line that names the columns, a unit that does not fit, a decimal comma, or a file of another kind",
    remedy='begin with a line such as "{x} [{unit}], stress [MPa]", then one point a line, with a decimal point',
)


def read_curve_file(path: Path, x: str) -> dict[str, list[float]]:
    """Columns by name, {x: [...], "stress": [...]}; x: "strain" [-] or "angle" [deg]; stress in Pa.

    Raises InputError E-FAB-001 if the file cannot be read, E-FAB-002 if it is no such table.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(LARGEST_FILE + 1)  # a device such as /dev/zero never ends
    except (OSError, ValueError) as error:  # ValueError: a path that no file can have
        raise UNREADABLE(path=str(path), why=error) from None
    try:
        return _columns(content, x)
    except (ValueError, csv.Error) as error:
        raise NO_CURVE(name=path.name, path=path, x=x, unit="%" if x == "strain" else "deg", why=error) from None


def _columns(content: bytes, x: str) -> dict[str, list[float]]:
    """Raises ValueError with a sentence for the user."""
    if len(content) > LARGEST_FILE:
        raise ValueError(f"it is longer than {LARGEST_FILE} bytes")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"byte {error.start} is no text in UTF-8") from None
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not lines:
        raise ValueError("it is empty")
    separator = ";" if ";" in lines[0][1] else "\t" if "\t" in lines[0][1] else ","
    rows = list(csv.reader([line for _, line in lines], delimiter=separator))
    units = {}
    for cell in rows[0]:
        head = _HEAD.fullmatch(cell)
        if head is None or head[1].lower() not in (x, "stress") or head[1].lower() in units:
            raise ValueError(f"its first line should name the columns {x} and stress, not {cell.strip()[:40]!r}")
        units[head[1].lower()] = head[2]
    if len(units) != 2:
        raise ValueError(f"its first line should name the columns {x} and stress")
    columns: dict[str, list[float]] = {name: [] for name in units}
    for (number, _), row in zip(lines[1:], rows[1:], strict=True):
        if len(row) != 2:
            raise ValueError(f"line {number} has {len(row)} columns instead of two")
        for (name, unit), cell in zip(units.items(), row, strict=True):
            try:
                columns[name].append(to_si(f"{cell.strip()} {unit or COLUMNS[name]}", COLUMNS[name]))
            except ValueError as error:
                raise ValueError(f"line {number}, {name}: {error}") from None
    return columns


def library_curves(name: str) -> dict[str, Any]:
    """Curves of a fabric of the library, as the `[fabric.curves]` table of a case: direction -> branch -> columns."""
    return tomllib.loads((resources.files(__package__) / "data" / LIBRARY[name]).read_text(encoding="utf-8"))
