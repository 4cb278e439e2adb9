"""Cards and their fields: columns of 10 or 20 characters, or commas; and tables of many like lines, column by column.

A blank line is a card of zeros. A line with a comma is free format, whatever its neighbours are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from billow.base.errors import InputError
from billow.decks.block import I10, LONG, Block
from billow.decks.parameters import Parameters, number

BAD_FIELD = InputError.declare(
    "E-DCK-004",
    "{field} = {text!r} cannot be used",
    where="{place}",
    cause="columns that are shifted, or a card too few above",
    remedy="correct the field; columns are 10 characters wide, 20 with LONG=Y or for reals of Radioss, or commas",
)
MISSING_CARD = InputError.declare(
    "E-DCK-005",
    "{keyword} ends before its card {card}",
    where="{place}",
    why="{count} cards follow the keyword",
    cause="a card that is optional elsewhere, a title line too few, or a deck that was cut short",
    remedy="complete the keyword; a blank line is a card of zeros",
)


@dataclass(frozen=True)
class Field:
    """One field of a card: what the deck says and where. part: of the card within its keyword, for repeated cards."""

    keyword: str
    name: str
    text: str
    place: str
    part: str = ""

    @property
    def shown(self) -> str:
        """As reports name it."""
        return f"{self.keyword}.{self.name}{self.part}"

    @property
    def is_blank(self) -> bool:
        return not self.text

    @property
    def number(self) -> float:
        """0 if it is blank. Raises InputError E-DCK-004."""
        try:
            return number(self.text)
        except ValueError as error:
            raise self.bad(error) from None

    @property
    def whole(self) -> int:
        """An id or a count; 0 if it is blank. Raises InputError E-DCK-004."""
        value = self.number
        if value != round(value) or abs(value) > 2**53:
            raise self.bad("a whole number is expected")
        return int(value)

    def bad(self, why: object, remedy: str | None = None) -> InputError:
        """The error that says why it cannot be used."""
        return BAD_FIELD(field=self.shown, text=self.text[:40], place=self.place, why=str(why), remedy=remedy)


@dataclass
class Cards:
    """The cards of a block, read one after the other. read: every field so far, for the report."""

    parameters: Parameters
    block: Block
    read: list[Field] = field(default_factory=list)

    def __post_init__(self):
        self._lines = list(self.block.lines())
        self._next = 0

    @property
    def left(self) -> int:
        """How many cards follow."""
        return len(self._lines) - self._next

    @property
    def place(self) -> str:
        """Of the next card, or of the last if none is left."""
        number = self._lines[min(self._next, len(self._lines) - 1)][0] if self._lines else self.block.line
        return f"{self.block.file}:{number}"

    @property
    def next_is_blank(self) -> bool:
        return self.left > 0 and not self._lines[self._next][1].strip()

    def starts_with(self, sign: bytes) -> bool:
        return self.left > 0 and self._lines[self._next][1].startswith(sign)

    def text(self) -> str:
        """A line that is a title or a name, never cut."""
        line = self.raw("title")
        return line.decode("latin-1").strip()

    def titled(self) -> str:
        """The title behind the id of a line that _ID adds; it is as long as it likes."""
        text = self.raw("id").decode("latin-1")
        if "," in text:
            return text.partition(",")[2].strip()
        return text[column_widths(self.block.form, (10,))[0] :].strip()

    def card(self, card: str, names: str, part: str = "", widths: tuple[int, ...] | None = None) -> dict[str, Field]:
        """Fields by name; names: of the columns, . for one that is not used. Raises InputError E-DCK-005."""
        place = self.place
        line = self.raw(card)
        columns = names.split()
        found = {}
        texts = split(self.parameters, self.block.form, line, place, widths or (10,) * len(columns))
        for name, text in zip(columns, texts + [""] * len(columns), strict=False):
            if name != ".":
                found[name] = Field(self.block.name, name, text, place, part)
        self.read += found.values()
        return found

    def optional(
        self, card: str, names: str, part: str = "", widths: tuple[int, ...] | None = None
    ) -> dict[str, Field]:
        """The card, or one of blanks if there is none."""
        if self.left:
            return self.card(card, names, part, widths)
        return {name: Field(self.block.name, name, "", self.place, part) for name in names.split() if name != "."}

    def unsign(self) -> None:
        """Leave out the sign, + or &, in the first column of the next card."""
        number, line = self._lines[self._next]
        self._lines[self._next] = number, b" " + line[1:]

    def raw(self, card: str) -> bytes:
        """The next line as it is. Raises InputError E-DCK-005."""
        if not self.left:
            raise MISSING_CARD(keyword=self.block.shown, card=card, place=self.place, count=len(self._lines))
        self._next += 1
        return self._lines[self._next - 1][1]


def split(parameters: Parameters, form: str, line: bytes, place: str, widths: tuple[int, ...]) -> list[str]:
    """Texts of the fields of a line, parameters filled in."""
    text = line.decode("latin-1")
    if "," in text:
        fields = [cell.strip() for cell in text.split(",")]
    else:
        ends = np.cumsum(column_widths(form, widths)).tolist()
        fields = [text[a:b].strip() for a, b in zip([0, *ends], ends, strict=False)]
    return [parameters.filled(f, place) if f[:1] == "&" or f[:2] == "-&" else f for f in fields]


def column_widths(form: str, widths: tuple[int, ...]) -> list[int]:
    """Widths as this form has them: LONG makes all 20, I10 makes 8 into 10."""
    if form == LONG:
        return [20] * len(widths)
    return [10 if form == I10 and width == 8 else width for width in widths]


@dataclass(frozen=True)
class Table:
    """Columns of many like lines, by name: float64 or int64, (rows,). line: number in the file of each row. texts: of
    the columns asked for, bytes."""

    block: Block
    columns: dict[str, np.ndarray]
    line: np.ndarray
    texts: dict[str, np.ndarray] = field(default_factory=dict)

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.line)

    def place(self, row: int) -> str:
        return f"{self.block.file}:{self.line[row]}"


Spec = tuple[tuple[str, int, str], ...]
"""Name, width and kind (i or f) of each column."""


def table(
    parameters: Parameters, block: Block, spec: Spec, every: int = 1, first: int = 0, keep: tuple[str, ...] = ()
) -> Table:
    """Each line a row, blank ones left out; of elements with `every` lines each, the line `first`. keep: columns whose
    texts are kept. Raises InputError E-DCK-004."""
    lines, rows = _rows(block, every, first)
    widths = tuple(width for _, width, _ in spec)
    free = any(b"," in row or b"&" in row for row in rows)
    if free:
        grid = [
            split(parameters, block.form, row, f"{block.file}:{at}", widths)
            for at, row in zip(lines, rows, strict=True)
        ]
        cells = {name: [row[k] if k < len(row) else "" for row in grid] for k, (name, _, _) in enumerate(spec)}
        raw = {name: np.array([text.encode("latin-1") for text in column], "S") for name, column in cells.items()}
    else:
        raw = dict(_columns(rows, [name for name, _, _ in spec], column_widths(block.form, widths)))
    columns = {name: _numbers(raw[name], kind, name, block, lines) for name, _, kind in spec}
    return Table(block, columns, lines, {name: raw[name] for name in keep})


def _rows(block: Block, every: int, first: int) -> tuple[np.ndarray, list[bytes]]:
    """Line numbers and lines that are neither blank nor comments."""
    body = block.body
    lines = body.split(b"\n")
    plain = b"$" not in body
    kept = [k for k, line in enumerate(lines) if line and not line.isspace() and (plain or line[:1] != b"$")]
    kept = kept[first::every]
    return np.array(kept, np.int64) + block.line + 1, [lines[k] for k in kept]


def _columns(rows: list[bytes], names: list[str], widths: list[int]) -> Iterator[tuple[str, np.ndarray]]:
    """Each column as bytes of a fixed width; what lies beyond the last is left out."""
    total = sum(widths)
    whole = b"".join([row.ljust(total)[:total] for row in rows])
    grid = np.frombuffer(whole, "u1").reshape(len(rows), total)
    begin = 0
    for name, width in zip(names, widths, strict=True):
        yield name, np.ascontiguousarray(grid[:, begin : begin + width]).view(f"S{width}").ravel()
        begin += width


def _numbers(texts: np.ndarray, kind: str, name: str, block: Block, lines: np.ndarray) -> np.ndarray:
    """float64 or int64 of texts, 0 where they are blank."""
    dtype = np.int64 if kind == "i" else np.float64
    if not len(texts):
        return np.empty(0, dtype)
    texts = np.strings.strip(texts)
    filled = np.where(texts == b"", b"0", texts)
    # NumPy takes more than a deck may hold: nan, inf, 1_000.
    odd = np.strings.find(filled, b"_") >= 0
    try:
        if odd.any():
            raise ValueError
        values = filled.astype(dtype)
        if np.isfinite(values).all():
            return values
    except (ValueError, OverflowError):
        pass
    out = np.empty(len(texts))
    for k, text in enumerate(filled.tolist()):
        try:
            out[k] = number(text.decode("latin-1"))
            if kind == "i" and (out[k] != round(out[k]) or abs(out[k]) > 2**53):
                raise ValueError("a whole number is expected")
        except ValueError as error:
            shown = text.decode("latin-1")[:40]
            place = f"{block.file}:{lines[k]}"
            raise BAD_FIELD(field=f"{block.name}.{name}", text=shown, place=place, why=error) from None
    return out.astype(dtype)
