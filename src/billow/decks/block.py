"""A keyword of a deck and what follows it, as it stands in its file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

STANDARD, LONG, I10 = "standard", "long", "i10"
"""Widths of columns: 10 and 16, all 20, ids of 10 instead of 8."""
SIGNS = {"+": LONG, "-": STANDARD, "%": I10}
"""Behind a keyword."""


def shown(name: str) -> str:
    """A keyword as it stands in a deck: *NAME of LS-DYNA, /NAME of Radioss."""
    return name if name.startswith("/") else f"*{name}"


@dataclass(frozen=True)
class Transform:
    """What *INCLUDE_TRANSFORM does to an included file: offsets of ids by kind, and factors of units (mass, time,
    length). place: where it stands."""

    offsets: dict[str, int]
    factors: tuple[float, float, float]
    place: str


@dataclass(frozen=True)
class Block:
    """A keyword (upper case, without * and sign) and what follows it. form: how wide its columns are. line: of the
    keyword, from 1. body: all bytes up to the next keyword. transforms: those of the files around it, innermost
    first."""

    name: str
    body: bytes = field(repr=False)
    form: str
    file: str
    line: int
    transforms: tuple[Transform, ...] = ()

    @property
    def place(self) -> str:
        return f"{self.file}:{self.line}"

    @property
    def shown(self) -> str:
        return shown(self.name)

    def lines(self) -> Iterator[tuple[int, bytes]]:
        """Number in the file and text of each line that is no comment; blank lines at the end are left out."""
        held = []
        for number, line in enumerate(self.body.split(b"\n"), self.line + 1):
            if line[:1] == b"$":
                continue
            held.append((number, line))
            if line.strip():
                yield from held
                held = []

    def is_a(self, name: str) -> bool:
        """Whether it is this keyword, with or without options."""
        return self.name == name or self.name.startswith(name + "_")
