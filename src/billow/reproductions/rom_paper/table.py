"""A table of a report, and as a file."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass

Cell = str | float | int | None


@dataclass(frozen=True)
class Table:
    """name: of its file; title; caption: how to read it; columns; rows: texts and numbers, None for nothing."""

    name: str
    title: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def csv(self) -> str:
        """As a file for other programs, every number with six digits."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([_plain(cell) for cell in row] for row in self.rows)
        return text.getvalue()

    def record(self) -> dict:
        """For tables.json."""
        rows = [[_plain(cell) for cell in row] for row in self.rows]
        return {"title": self.title, "caption": self.caption, "columns": list(self.columns), "rows": rows}


def _plain(cell: Cell):
    if cell is None:
        return ""
    return float(f"{cell:.6g}") if isinstance(cell, float) else cell
