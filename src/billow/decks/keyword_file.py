"""A deck of LS-DYNA as blocks: from the bytes of a file and all it includes to one `Block` for each keyword.

Nothing is interpreted but what decides how to read: the width of columns (`*KEYWORD LONG=Y`, `I10=Y`, a sign behind a
keyword), `*INCLUDE...`, `*PARAMETER...` and `*END`. Blocks keep their bytes; lines are cut when somebody asks.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from billow.base.errors import InputError
from billow.base.input_file import LARGEST_DATA, read_bytes
from billow.decks.block import I10, LONG, SIGNS, STANDARD, Block, Transform
from billow.decks.cards import Cards
from billow.decks.parameters import Parameters

NO_DECK = InputError.declare(
    "E-DCK-001",
    "cannot read the deck {name!r}",
    where="{path}",
    cause="a wrong path, a binary file, or a file of another program",
    remedy="give a keyword file of LS-DYNA: its keywords begin with * in the first column",
)
BAD_INCLUDE = InputError.declare(
    "E-DCK-002",
    "the file {name!r} cannot be included",
    where="{place}",
    cause="a file that was not copied along, or a path of another machine",
    remedy="put the file into the deck's folder, or name its folder with *INCLUDE_PATH",
)

MOST_INCLUDES_DEEP = 16
MOST_FILES = 1000
_KEYWORD = re.compile(rb"^\*", re.MULTILINE)
_NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x1f]")
_TRANSFORM_OFFSETS = ("node", "element", "part", "material", "set", "curve", "define")


class Deck:
    """blocks: of all files, in order. parameters: of the whole deck. files: that were read."""

    def __init__(self, path: str | Path, allow_outside: bool = False):
        """Raises InputError E-DCK-001 (no deck), E-DCK-002 (an include), E-DCK-003 (a parameter)."""
        self.path = Path(path)
        self.blocks: list[Block] = []
        self.parameters = Parameters()
        self.files: list[Path] = []
        self.form = STANDARD
        self._bytes = 0
        self._ended = False
        self._folder = self.path.resolve().parent
        self._folders = [self._folder]
        self._allow_outside = allow_outside
        try:
            data = read_bytes(self.path, LARGEST_DATA)
            require_text(data)
            if not _KEYWORD.search(data):
                raise ValueError("no line begins with *")
        except (OSError, ValueError) as error:
            raise NO_DECK(name=self.path.name, path=str(self.path), why=error) from None
        self._take(self.path.resolve(), data, STANDARD, (), 0)

    @classmethod
    def of_mesh(cls, path: str | Path) -> Deck:
        """A deck without keywords, for a mesh of another format."""
        deck = cls.__new__(cls)
        deck.path, deck.blocks, deck.parameters, deck.files = Path(path), [], Parameters(), [Path(path)]
        return deck

    def all(self, *names: str) -> list[Block]:
        """Blocks of these keywords, with or without options."""
        return [block for block in self.blocks if any(block.is_a(name) for name in names)]

    def _take(self, path: Path, data: bytes, form: str, transforms: tuple[Transform, ...], depth: int) -> None:
        self.files.append(path)
        self._bytes += len(data)
        data = data.removeprefix(b"\xef\xbb\xbf")
        if b"\r" in data:
            data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        starts = [found.start() for found in _KEYWORD.finditer(data)]
        line, counted = 1, 0
        for start, end in zip(starts, [*starts, len(data)][1:], strict=True):
            line, counted = line + data.count(b"\n", counted, start), start
            stop = data.find(b"\n", start, end)
            stop = end if stop < 0 else stop
            head = data[start + 1 : stop].decode("latin-1").upper()
            word, own = _name_and_form(head)
            if word == "END":
                return
            if word == "KEYWORD":
                form = LONG if re.search(r"LONG\s*=\s*Y", head) else form
                form = I10 if re.search(r"I10\s*=\s*Y", head) else form
                continue
            block = Block(word, data[stop + 1 : end], own or form, path.name, line, transforms)
            if word.startswith("PARAMETER"):
                self.parameters.take(block)
            elif word.startswith("INCLUDE"):
                self._include(block, path, form, depth)
            else:
                self.blocks.append(block)

    def _include(self, block: Block, path: Path, form: str, depth: int) -> None:
        lines = [(number, line.decode("latin-1").rstrip()) for number, line in block.lines()]
        names = list(_joined(lines))
        if block.name in ("INCLUDE_PATH", "INCLUDE_PATH_RELATIVE"):
            self._folders += [(path.parent / name).resolve() for _, name in names]
            return
        transforms = block.transforms
        if block.name == "INCLUDE_TRANSFORM":
            names, transforms = names[:1], (self._transform(block), *transforms)
        elif block.name not in ("INCLUDE", "INCLUDE_STAMPED"):
            place, why = block.place, f"*{block.name} is not known"
            raise BAD_INCLUDE(name=block.name, place=place, why=why, remedy="include the file with *INCLUDE")
        for number, name in names:
            place = f"{block.file}:{number}"
            found = self._found(path, name, place)
            if depth + 1 > MOST_INCLUDES_DEEP or len(self.files) >= MOST_FILES:
                why = f"files are included more than {MOST_INCLUDES_DEEP} deep, or more than {MOST_FILES} of them"
                raise BAD_INCLUDE(name=name, place=place, why=why, remedy="remove the include that names its own file")
            try:
                data = read_bytes(found, LARGEST_DATA - self._bytes)
                require_text(data)
            except (OSError, ValueError) as error:
                raise BAD_INCLUDE(name=name, place=place, why=error) from None
            self._take(found, data, form, transforms, depth + 1)

    def _found(self, path: Path, name: str, place: str) -> Path:
        """The file that an include names. Only folders of the deck are looked at unless others are allowed."""
        try:
            tried = [(folder / name).resolve() for folder in (path.parent, *self._folders)]
            hit = next((one for one in tried if one.is_file()), None)
        except (OSError, ValueError, RuntimeError):
            hit = None
        if hit is None:
            raise BAD_INCLUDE(name=name, place=place, why="there is no such file")
        if not self._allow_outside and not hit.is_relative_to(self._folder):
            why = f"it lies outside the deck's folder, {self._folder}"
            raise BAD_INCLUDE(name=name, place=place, why=why, remedy="copy it there, or allow it with --allow-outside")
        return hit

    def _transform(self, block: Block) -> Transform:
        cards = Cards(self.parameters, block)
        cards.text()
        offsets = cards.card("offsets", "IDNOFF IDEOFF IDPOFF IDMOFF IDSOFF IDFOFF IDDOFF")
        rest = cards.card("more", "IDROFF PREFIX SUFFIX") if cards.left else None
        units = cards.card("factors", "FCTMAS FCTTIM FCTLEN FCTTEM INCOUT1") if cards.left else None
        moved = cards.card("moved", "TRANID") if cards.left else None
        if moved is not None and moved["TRANID"].whole:
            why = "*DEFINE_TRANSFORMATION is not read"
            raise BAD_INCLUDE(
                name=moved["TRANID"].text, place=moved["TRANID"].place, why=why, remedy="apply it to the file itself"
            )
        kinds = dict(zip(_TRANSFORM_OFFSETS, (f.whole for f in offsets.values()), strict=True))
        kinds["section"] = rest["IDROFF"].whole if rest else 0
        factors = tuple(units[name].number or 1.0 for name in ("FCTMAS", "FCTTIM", "FCTLEN")) if units else (1.0,) * 3
        return Transform(kinds, factors, block.place)


def require_text(data: bytes) -> None:
    """ValueError, with a sentence, for bytes that are no text."""
    odd = _NO_TEXT.search(data)
    if odd is not None:
        line = data.count(b"\n", 0, odd.start()) + 1
        raise ValueError(f"line {line} holds the control character {odd[0][0]:#04x}; it is no text")


def _name_and_form(head: str) -> tuple[str, str | None]:
    """Keyword and, if a sign behind it says so, its form."""
    word, _, rest = head.strip().partition(" ")
    sign = rest.strip() if rest.strip() in SIGNS else word[-1:]
    return (word.rstrip("+-%"), SIGNS[sign]) if sign in SIGNS else (word, None)


def _joined(lines: list[tuple[int, str]]) -> Iterator[tuple[int, str]]:
    """Names of files, of which one that ends in ` +` goes on in the next line."""
    begun = ""
    for number, line in lines:
        if line.endswith(" +"):
            begun += line[:-2]
        elif begun or line:
            yield number, (begun + line).strip()
            begun = ""
