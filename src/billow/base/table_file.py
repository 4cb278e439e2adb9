"""Tables in CSV files, all read by the same rules (docs/input_files.md): blank lines and lines that begin with # do not
count, the first other line names the columns and shows the separator, and numbers are never guessed.
"""

from __future__ import annotations

import csv
import io
import re
from array import array
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from billow.base.errors import shown
from billow.base.input_file import LARGEST_TABLE, read_text

_QUOTED = re.compile(r'"[^"]*"')
_DIGITS = re.compile(r"[0-9.,eE+\-]*")
MOST_COLUMNS = 10_000


class Table:
    """A table: names of its columns, and its rows, read when asked for. ValueError, with a sentence that names the
    line, wherever it does not keep the rules."""

    def __init__(self, text: str):
        self._text = text
        head = next(self._lines(), None)
        if head is None:
            raise ValueError("it is empty")
        number, _, first = head
        plain = _QUOTED.sub("", first)
        self._above = number
        self.separator = ","
        if found := re.fullmatch(r"sep=([;,\t])\s*", first):  # what spreadsheets write to say so
            self.separator = found[1]
        else:
            self._above -= 1
            self.separator = ";" if ";" in plain else "\t" if "\t" in plain else ","
        rows = self._rows()
        self.line, names = next(rows, (number, []))
        self._start = next((place for line, place, _ in self._lines() if line == self.line), len(text))
        while names and not names[-1]:
            names.pop()
        twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
        if twice is not None:
            raise ValueError(f"line {self.line} names two columns {shown(twice)}")
        if not names or len(names) > MOST_COLUMNS:
            raise ValueError(f"line {self.line} names {len(names)} columns; expected 1 to {MOST_COLUMNS}")
        self.names = tuple(names)

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Number of the line, from 1, and the cells of each row below the names, without spaces around them."""
        width = len(self.names)
        for line, cells in self._rows():
            if line <= self.line:
                continue
            while len(cells) > width and not cells[-1]:
                cells.pop()
            if len(cells) != width:
                has = f"{len(cells)} value{'' if len(cells) == 1 else 's'}"
                raise ValueError(f"line {line} has {has}, the header in line {self.line} names {width}")
            yield line, cells

    def columns(self, names: Sequence[str]) -> list[int]:
        """Where these columns are. ValueError if one is missing."""
        missing = [name for name in names if name not in self.names]
        if missing:
            listed = ", ".join(self.names[:20])
            raise ValueError(f"its columns are {listed}; {', '.join(missing)} missing")
        return [self.names.index(name) for name in names]

    def numbers(self, names: Sequence[str] | None = None, finite: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Values (rows, columns) float64 of some columns, by default all, and the number of each row's line (rows,).

        finite: whether nan and inf are refused. With ; or a tab as separator, a comma is a decimal comma; one file has
        one decimal mark.
        """
        chosen = self.columns(self.names if names is None else names)
        plain = self._plain_numbers()
        if plain is not None:
            return plain[:, chosen], np.arange(len(plain)) + self.line + 1
        values, lines, marks = array("d"), array("q"), {}
        for line, cells in self.rows():
            cells = [cells[k] for k in chosen]
            joined = "".join(cells)
            for mark in (".", ","):
                if mark in joined:
                    marks.setdefault(mark, line)
            if len(marks) > 1:
                comma, point = marks[","], marks["."]
                raise ValueError(
                    f"line {point} has a decimal point, line {comma} a decimal comma or a comma between thousands; "
                    "write all numbers alike, without separators of thousands"
                )
            try:
                if not _DIGITS.fullmatch(joined):  # Python's own reading knows more than tables should
                    raise ValueError
                values.extend([float(cell.replace(",", ".")) for cell in cells])
            except ValueError:
                values.extend(self._number(text, line, k, finite) for text, k in zip(cells, chosen, strict=True))
            lines.append(line)
        found = np.array(values).reshape(-1, len(chosen))
        if finite and not np.isfinite(found).all():  # 1e999 is one
            row, column = np.argwhere(~np.isfinite(found))[0]
            self._refuse(lines[row], chosen[column], "is not a finite number")
        return found, np.array(lines)

    def _plain_numbers(self) -> np.ndarray | None:
        """All values, (rows, columns), if every line below the names holds numbers and separators alone; else None."""
        begin = self._text.find("\n", self._start) + 1
        body = self._text[begin:].rstrip("\n") if begin else ""
        comma = "" if self.separator == "," else ","
        if not body or "\n\n" in body or (comma and "." in body and comma in body):
            return None
        if not re.fullmatch(rf"[0-9.eE+\-\n{self.separator}{comma}]*+", body):
            return None
        body = body.replace(",", ".") if comma else body
        try:
            found = np.loadtxt(io.StringIO(body), delimiter=self.separator, ndmin=2)
        except ValueError:
            return None  # read line by line, to say which is wrong
        sound = found.shape == (body.count("\n") + 1, len(self.names)) and np.isfinite(found).all()
        return found if sound else None

    def _number(self, text: str, line: int, column: int, finite: bool) -> float:
        if _DIGITS.fullmatch(text) or (not finite and re.fullmatch(r"[+-]?(nan|inf)", text)):
            try:
                return float(text.replace(",", "."))
            except ValueError:
                pass
        if not text:
            self._refuse(line, column, "is missing")
        known = re.fullmatch(r"[+-]?(nan|inf|infinity)", text, re.IGNORECASE)
        self._refuse(line, column, f"is {shown(text)}, not a {'finite ' if known else ''}number")

    def _refuse(self, line: int, column: int, why: str) -> None:
        raise ValueError(f"line {line}: the value of {shown(self.names[column])} {why}")

    def _lines(self) -> Iterator[tuple[int, int, str]]:
        """Lines that count: number, where it begins, text."""
        start, number = 0, 0
        while start < len(self._text):
            end = self._text.find("\n", start)
            end = len(self._text) if end < 0 else end
            line, number = self._text[start:end], number + 1
            if line.strip(" \t") and not line.startswith("#"):
                yield number, start, line
            start = end + 1

    def _rows(self) -> Iterator[tuple[int, list[str]]]:
        number = 0

        def texts() -> Iterator[str]:
            nonlocal number
            for number, _, text in self._lines():
                if number > self._above:
                    yield text

        cells = csv.reader(texts(), delimiter=self.separator, strict=True)
        try:
            for row in cells:
                row = [cell.strip() for cell in row]
                if any(row):  # spreadsheets write rows of separators alone
                    yield number, row
        except csv.Error:
            raise ValueError(f"line {number}: a quotation mark stands where none can, or a cell is too long") from None


def read_table(path: str | Path, largest: int = LARGEST_TABLE) -> Table:
    """The table in a CSV file. OSError if it cannot be read; ValueError if it is no table, or has no rows."""
    table = Table(read_text(path, largest))
    if next(table.rows(), None) is None:
        raise ValueError("it names its columns and has no rows below them")
    return table


def whole_numbers(values: np.ndarray, what: str) -> np.ndarray:
    """Values as int64. ValueError if one is not a whole number, or beyond 2^53, where doubles no longer tell them
    apart."""
    if values.dtype.kind in "iu" and (values.dtype.itemsize < 8 or not values.size or values.max() < 2**53):
        return values.astype(np.int64)
    values = values.astype(float)
    with np.errstate(invalid="ignore"):
        wrong = ~(np.abs(values) < 2.0**53) | (values % 1.0 != 0.0)
    if wrong.any():
        raise ValueError(f"{what} {values[wrong].flat[0]:g} is not a whole number")
    return values.astype(np.int64)
