"""A starter deck of Radioss as blocks: one for each line that begins with /, with all it includes.

Blocks keep their bytes; comments, which begin with # or $, are marked as those of LS-DYNA, so that the same cards read
both. `/BEGIN` and `/UNIT` say units, `/PARAMETER` gives names to values, `#include` and `#enddata` do what they say.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from billow.base.errors import InputError
from billow.base.input_file import LARGEST_DATA, read_bytes
from billow.decks.block import STANDARD, Block
from billow.decks.cards import Cards, Field
from billow.decks.keyword_file import BAD_INCLUDE, MOST_FILES, MOST_INCLUDES_DEEP, require_text
from billow.decks.parameters import Parameters, number
from billow.decks.units import Units

NO_STARTER = InputError.declare(
    "E-DCK-160",
    "cannot read the starter deck {name!r}",
    where="{place}",
    cause="an engine file, a binary file, or a deck of Radioss 4 or older, whose columns are others",
    remedy="give the starter file, NAME_0000.rad, of version 5.1 or later: it begins with #RADIOSS STARTER and /BEGIN",
)
UNITS_UNKNOWN = InputError.declare(
    "E-DCK-161",
    "the unit {text!r} of a {kind} is not known",
    where="{place}",
    cause="a code beyond kg, g, Mg, m, mm, cm, s, ms and the like",
    remedy="write a code or a number of kilograms, metres or seconds; or say all units: --units",
)

OLDEST = 51
"""Version of the input from which on columns are 10 and 20 wide."""
PREFIXES = {
    "y": -24, "z": -21, "a": -18, "f": -15, "p": -12, "n": -9, "mu": -6, "m": -3, "c": -2, "d": -1, "": 0, "da": 1,
    "h": 2, "k": 3, "M": 6, "G": 9, "T": 12, "P": 15, "E": 18, "Z": 21, "Y": 24,
}  # fmt: skip
"""Power of ten of a prefix of a unit, as /BEGIN has it."""
BASES = {"mass": ("g", -3), "length": ("m", 0), "time": ("s", 0)}
_HEAD = re.compile(rb"^(?:/(?=[A-Za-z])|#include\b|#enddata\b)", re.MULTILINE | re.IGNORECASE)
_COMMENT = re.compile(rb"^#", re.MULTILINE)


def is_starter(path: Path) -> bool:
    """Whether a file is a starter deck of Radioss, by its first lines."""
    try:
        with open(path, "rb") as file:
            head = file.read(4096)
    except OSError:
        return False
    return re.search(rb"^(#RADIOSS STARTER|/BEGIN\b)", head, re.MULTILINE | re.IGNORECASE) is not None


def words(block: Block) -> tuple[str, ...]:
    """The words of a keyword: /MAT/LAW19/3 is MAT, LAW19, 3."""
    return tuple(block.name.strip("/").split("/"))


def kind_of(block: Block) -> str:
    """The second word of a keyword, empty if it has none."""
    return (*words(block), "")[1]


class StarterDeck:
    """blocks: of all files, in order. parameters: of the whole deck. units: of /BEGIN, and work_units, those of results
    and of engine files."""

    def __init__(self, path: Path, allow_outside: bool = False):
        """Raises InputError E-DCK-160 (no deck), -161 (units), -002 (an include), -003 (a parameter)."""
        self.path, self.blocks, self.parameters, self.files = path, [], Parameters(), []
        self._folder, self._allow_outside, self._bytes, self._ended = path.resolve().parent, allow_outside, 0, False
        try:
            data = read_bytes(path, LARGEST_DATA)
            require_text(data)
        except (OSError, ValueError) as error:
            raise NO_STARTER(name=path.name, place=str(path), why=error) from None
        self._take(path.resolve(), data, 0)
        begin = next(iter(self.find("BEGIN")), None)
        if begin is None:
            raise NO_STARTER(name=path.name, place=str(path), why="it has no /BEGIN")
        self.units, self.work_units = self._begin(begin)
        self.local = dict(self._local_units())

    def all(self, *names: str) -> list[Block]:
        """Blocks of these keywords of LS-DYNA: none."""
        return []

    def find(self, *wanted: str) -> list[Block]:
        """Blocks whose keyword begins with these words."""
        return [block for block in self.blocks if words(block)[: len(wanted)] == wanted]

    def units_of(self, block: Block) -> Units:
        """Of an option whose keyword ends with the number of a /UNIT, else of the deck."""
        parts = [word for word in words(block)[1:] if word.isdecimal()]
        return self.local.get(int(parts[1]), self.units) if len(parts) > 1 else self.units

    def _take(self, path: Path, data: bytes, depth: int) -> None:
        self.files.append(path)
        self._bytes += len(data)
        data = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        starts = [found.start() for found in _HEAD.finditer(data)]
        line, counted = 1, 0
        for start, end in zip(starts, [*starts, len(data)][1:], strict=True):
            line, counted = line + data.count(b"\n", counted, start), start
            stop = data.find(b"\n", start, end)
            stop = end if stop < 0 else stop
            head = data[start:stop].decode("latin-1").strip()
            place = f"{path.name}:{line}"
            if head[0] == "#":
                if head.lower().startswith("#enddata"):
                    return
                self._include(path, head[8:].strip(), place, depth)
                if self._ended:
                    return
                continue
            body = _COMMENT.sub(b"$", data[stop + 1 : end])
            block = Block(head.upper().rstrip("/"), body, STANDARD, path.name, line)
            if block.name == "/END":
                self._ended = True
                return
            if words(block)[0] == "PARAMETER":
                self._parameter(block)
            else:
                self.blocks.append(block)

    def _include(self, path: Path, name: str, place: str, depth: int) -> None:
        remedy = "put the file into the deck's folder"
        try:
            found = (path.parent / name).resolve()
            known = found.is_file()
        except (OSError, ValueError, RuntimeError):
            known = False
        if not known:
            raise BAD_INCLUDE(name=name[:200], place=place, why="there is no such file", remedy=remedy)
        if not self._allow_outside and not found.is_relative_to(self._folder):
            why = f"it lies outside the deck's folder, {self._folder}"
            raise BAD_INCLUDE(name=name, place=place, why=why, remedy="copy it there, or allow it with --allow-outside")
        if depth + 1 > MOST_INCLUDES_DEEP or len(self.files) >= MOST_FILES:
            why = f"files are included more than {MOST_INCLUDES_DEEP} deep, or more than {MOST_FILES} of them"
            raise BAD_INCLUDE(name=name, place=place, why=why, remedy="remove the include that names its own file")
        try:
            data = read_bytes(found, LARGEST_DATA - self._bytes)
            require_text(data)
        except (OSError, ValueError) as error:
            raise BAD_INCLUDE(name=name, place=place, why=error, remedy=remedy) from None
        self._take(found, data, depth + 1)

    def _parameter(self, block: Block) -> None:
        """/PARAMETER/GLOBAL/REAL and the like: a title, then name and value, or name and expression."""
        kind = words(block)[2] if len(words(block)) > 2 else ""
        cards = Cards(self.parameters, block)
        if not cards.left:
            return
        cards.text()
        while cards.left:
            place = cards.place
            line = cards.raw("parameter").decode("latin-1")
            name, rest = line[:10].strip(), line[10:].strip()
            if kind in ("REAL", "INTEGER"):
                self.parameters.define("I" if kind == "INTEGER" else "R", name, rest, place)
            elif kind in ("REAL_EXPR", "INT_EXPR"):
                while cards.left:
                    rest += cards.raw("expression").decode("latin-1").strip()
                value = self.parameters.evaluated(rest, name, place)
                self.parameters.define("I" if kind == "INT_EXPR" else "R", name, value, place)
            else:
                return  # texts stand in no field that is read

    def _begin(self, block: Block) -> tuple[Units, Units]:
        cards = Cards(self.parameters, block)
        cards.text()
        version = cards.card("version", "Invers Irun")["Invers"]
        if version.whole < OLDEST:
            why = f"Invers is {version.text or 'blank'}"
            raise NO_STARTER(name=self.path.name, place=version.place, why=why)
        rows = []
        for name in ("Input", "Work"):
            names = " ".join(f"{name}_{kind}_unit" for kind in BASES)
            rows.append(list(cards.optional(name, names, widths=(20, 20, 20)).values()))
        given, work = rows
        work = [w if not w.is_blank else g for g, w in zip(given, work, strict=True)]
        given = [g if not g.is_blank else w for g, w in zip(given, work, strict=True)]
        return _units(given), _units(work)

    def _local_units(self) -> Iterator[tuple[int, Units]]:
        for block in self.find("UNIT"):
            if not kind_of(block).isdecimal():
                continue
            cards = Cards(self.parameters, block)
            if cards.left > 1:
                cards.text()
            fields = cards.card("units", "mass_unit length_unit time_unit", widths=(20, 20, 20))
            yield int(kind_of(block)), _units(list(fields.values()))


def _units(fields: list[Field]) -> Units:
    """Raises InputError E-DCK-161."""
    texts = [
        one.text or {"mass": "kg", "length": "m", "time": "s"}[kind] for one, kind in zip(fields, BASES, strict=True)
    ]
    factors = [_factor(text, kind, one) for text, kind, one in zip(texts, BASES, fields, strict=True)]
    return Units("-".join(texts), *factors)


def _factor(text: str, kind: str, one: Field) -> float:
    base, power = BASES[kind]
    if text.endswith(base) and text[: -len(base)] in PREFIXES:
        return float(f"1e{PREFIXES[text[: -len(base)]] + power}")
    try:
        value = number(text)
    except ValueError:
        value = 0.0
    if not 1e-30 < value < 1e30:
        raise UNITS_UNKNOWN(text=text[:40], kind=kind, place=one.place, why="it is no code and no number")
    return value
