"""A table of a report, and as a file."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

Cell = str | float | int | None


@dataclass(frozen=True)
class Table:
    """name: of its file; title; caption: how to read it; rows: column -> text or number, None for nothing, at least one
    row, all with the same columns."""

    name: str
    title: str
    caption: str
    rows: Sequence[dict[str, Cell]]

    @property
    def columns(self) -> tuple[str, ...]:
        return tuple(self.rows[0])

    def csv(self) -> str:
        """As a file for other programs, every number with six digits."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerows([self.columns, *self._plain()])
        return text.getvalue()

    def record(self) -> dict:
        """For tables.json."""
        return {"title": self.title, "caption": self.caption, "columns": list(self.columns), "rows": self._plain()}

    def _plain(self) -> list[list]:
        return [["" if cell is None else _six_digits(cell) for cell in row.values()] for row in self.rows]


def _six_digits(cell: Cell):
    return float(f"{cell:.6g}") if isinstance(cell, float) else cell
