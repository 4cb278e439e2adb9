"""Tables as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path


def csv_text(rows: Iterable[Iterable]) -> str:
    """Rows as the text of a CSV file; Python floats with as many digits as it takes to read back the same bits."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def read_csv(path: str | Path, columns: Sequence[str] | None = None) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a CSV file, without blank lines and spaces around cells.

    columns: what the header must be, if that is known. OSError if it cannot be read, ValueError if it is no such table.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            header, *rows = [[cell.strip() for cell in row] for row in csv.reader(file, strict=True) if row]
    except csv.Error as error:
        raise ValueError(str(error)) from error
    if columns is not None and header != list(columns):
        raise ValueError(f"its columns are {', '.join(header)}; expected {', '.join(columns)}")
    return header, rows
