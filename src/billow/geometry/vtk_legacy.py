"""Reading VTK legacy files (.vtk) without VTK: POLYDATA and UNSTRUCTURED_GRID, ASCII or binary.

Cells in the layout before or since version 5 ("VTK File Formats", docs.vtk.org, version 9). Nothing in a file is
executed, and no array is larger than the file. What is not known is refused, never skipped.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from billow.base.table_file import whole_numbers

TRIANGLE, POLYGON, QUAD = 5, 7, 9
"""VTK's numbers for kinds of cells."""
GHOSTS = "vtkGhostType"
"""VTK's name for the field that marks copies of what belongs to another file."""

_TYPES = {
    "float": "f4", "double": "f8", "char": "i1", "signed_char": "i1", "unsigned_char": "u1", "short": "i2",
    "unsigned_short": "u2", "int": "i4", "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8",
    "vtkidtype": "i4", "vtktypeint32": "i4", "vtktypeint64": "i8",
}  # fmt: skip
_TEXTS = ("string", "utf8_string")
_COMPONENTS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1}
_COMPONENTS |= {"EDGE_FLAGS": 1}
_OTHER_CELLS = ("VERTICES", "LINES", "TRIANGLE_STRIPS")
_AT_ONCE = 1_000_000
"""Bytes of text that are cut into words together."""
_SPACE = re.compile(rb"\s")
_FIRST = re.compile(rb"[ \t]*# *vtk DataFile Version *[\d.]+")


@dataclass
class Grid:
    """points: (nodes, 3) float64. offsets: (cells + 1,) and connectivity: node numbers of all cells, int64. types:
    VTK's number for the kind of each cell, (cells,). cell_fields: name -> (cells,) or (cells, components)."""

    points: np.ndarray | None = None
    offsets: np.ndarray | None = None
    connectivity: np.ndarray | None = None
    types: np.ndarray | None = None
    cell_fields: dict[str, np.ndarray] = field(default_factory=dict)


def read_legacy(content: bytes) -> Grid:
    """The grid in a file. ValueError, with a sentence that says why, for anything else than the above."""
    file, grid = _Words(content), Grid()
    try:
        _read(file, grid)
    except (IndexError, OverflowError):
        raise ValueError(f"{file.where} does not end as it should") from None
    if grid.points is None or grid.offsets is None:
        raise ValueError("it has no points or no cells")
    if grid.types is None:
        corners = np.diff(grid.offsets)
        grid.types = np.select([corners == 3, corners == 4], [TRIANGLE, QUAD], POLYGON)
    return grid


def _read(file: _Words, grid: Grid) -> None:
    count, kind = 0, ""  # of the items that the fields which follow belong to
    while (words := file.line()) is not None:
        word = words[0].upper()
        match word:
            case "DATASET" if words[1].upper() not in ("POLYDATA", "UNSTRUCTURED_GRID"):
                raise ValueError(f"its dataset is {words[1]}; POLYDATA and UNSTRUCTURED_GRID can be read")
            case "DATASET":
                pass
            case "POINTS" if grid.points is not None:
                raise ValueError(f"{file.where} begins a second list of points; one dataset can be read")
            case "POINTS":
                grid.points = file.array(3 * file.count(words[1]), words[2]).astype(float).reshape(-1, 3)
            case "CELLS" | "POLYGONS" if grid.offsets is not None:
                raise ValueError(f"{file.where} begins a second list of cells; one dataset can be read")
            case "CELLS" | "POLYGONS":
                grid.offsets, grid.connectivity = _cells(file, file.count(words[1]), file.count(words[2]))
            case _ if word in _OTHER_CELLS:
                if len(_cells(file, file.count(words[1]), file.count(words[2]))[0]) > 1:
                    raise ValueError(f"it holds {word}; save its polygons alone, strips as triangles")
            case "CELL_TYPES":
                grid.types = whole_numbers(file.array(file.count(words[1]), "int"), "kind of cell")
            case "POINT_DATA" | "CELL_DATA":
                count, kind = file.count(words[1]), word
            case "METADATA":
                file.skip_paragraph()
            case "FIELD":
                for _ in range(file.count(words[2])):
                    name, components, tuples, dtype = file.line_after_metadata()[:4]
                    values = file.array(file.count(components) * file.count(tuples), dtype)
                    _keep(grid, kind, name, values, file.count(tuples))
            case "LOOKUP_TABLE":
                file.array(4 * file.count(words[2]), "unsigned_char" if file.binary else "float")
            case "SCALARS":
                components = file.count(words[3]) if len(words) > 3 else 1
                if (file.line() or [""])[0].upper() != "LOOKUP_TABLE":
                    raise ValueError(f"{file.where} should be the LOOKUP_TABLE of {words[1]}")
                _keep(grid, kind, words[1], file.array(count * components, words[2]), count)
            case "COLOR_SCALARS":
                file.array(count * file.count(words[2]), "unsigned_char" if file.binary else "float")
            case "TEXTURE_COORDINATES":
                file.array(count * file.count(words[2]), words[3])
            case _ if word in _COMPONENTS:
                _keep(grid, kind, words[1], file.array(count * _COMPONENTS[word], words[2]), count)
            case _:
                raise ValueError(f"{file.where} begins with {words[0][:40]!r}, which is not known there")


def _keep(grid: Grid, kind: str, name: str, values: np.ndarray | None, rows: int) -> None:
    if values is None or not rows or not values.size:
        return
    if name == GHOSTS and values.any():
        raise ValueError("it has ghost points or cells, copies of another file's; save the whole fabric in one")
    if kind == "CELL_DATA":
        grid.cell_fields[name] = values if len(values) == rows else values.reshape(rows, -1)


class _Words:
    """The lines and arrays of a file, one after the other."""

    def __init__(self, content: bytes):
        if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
            raise ValueError("it is UTF-16 text; save it as UTF-8")
        content = content.removeprefix(b"\xef\xbb\xbf")
        if b"\n" not in content[:1000]:
            content = content.replace(b"\r", b"\n")
        lines = content.split(b"\n", 3)
        if len(lines) < 4 or not _FIRST.match(lines[0]):
            raise ValueError("its first line is not that of a VTK legacy file, # vtk DataFile Version ...")
        form = lines[2].strip().upper()
        if form not in (b"ASCII", b"BINARY"):
            raise ValueError(f"line 3 says {form.decode('latin-1')[:40]!r}; expected ASCII or BINARY")
        self.binary = form == b"BINARY"
        self.content, self.place, self.begin = content, len(content) - len(lines[3]), 0

    @property
    def where(self) -> str:
        """The line that was read last, for messages."""
        if self.binary:
            return f"what begins at byte {self.begin}"
        before = self.content[: self.begin].count(b"\n")
        return f"line {before + 1}"

    def line(self) -> list[str] | None:
        """Words of the next line that is not blank."""
        while self.place < len(self.content):
            end = self.content.find(b"\n", self.place)
            end = len(self.content) if end < 0 else end
            self.begin = self.place
            words = self.content[self.place : end].decode("utf-8", "replace").split()
            self.place = end + 1
            if words:
                return words
        return None

    def line_after_metadata(self) -> list[str]:
        words = self.line() or []
        while words and words[0].upper() == "METADATA":
            self.skip_paragraph()
            words = self.line() or []
        if len(words) < 4:
            raise ValueError(f"{self.where} should name a field, with components, rows and type")
        return words

    def skip_paragraph(self) -> None:
        """Go behind the next blank line."""
        while self.place < len(self.content):
            end = self.content.find(b"\n", self.place)
            end = len(self.content) if end < 0 else end
            blank = not self.content[self.place : end].strip()
            self.place = end + 1
            if blank:
                return

    def count(self, text: str) -> int:
        if not re.fullmatch(r"\d{1,12}", text, re.ASCII):
            raise ValueError(f"{self.where} has {text[:40]!r} where a number of items is expected")
        return int(text)

    def array(self, count: int, kind: str) -> np.ndarray | None:
        """The values that follow; None for texts."""
        if kind.lower() in _TEXTS and not self.binary:
            for _ in range(min(count, len(self.content))):
                self.line()
            return None
        if kind.lower() not in _TYPES:
            raise ValueError(f"{self.where} announces values of the type {kind[:40]!r}, which cannot be read")
        dtype = np.dtype(">" + _TYPES[kind.lower()])
        if count * (dtype.itemsize if self.binary else 1) > len(self.content) - self.place:
            raise ValueError(f"it is cut short, or {self.where} announces too many items")
        if self.binary:
            values = np.frombuffer(self.content, dtype, count, self.place)
            self.place += count * dtype.itemsize
            return values
        values, done = np.empty(count), 0
        while done < count:
            end = min(self.place + _AT_ONCE, len(self.content))
            after = _SPACE.search(self.content, end)
            end = len(self.content) if after is None else after.start()
            words = self.content[self.place : end].split(None, count - done)
            self.place = end - (len(words.pop()) if len(words) > count - done else 0)
            if not words and end == len(self.content):
                raise ValueError(f"it is cut short: {self.where} announces {count} values, {done} follow")
            values[done : done + len(words)] = [self._number(word) for word in words]
            done += len(words)
        return values

    def _number(self, word: bytes) -> float:
        try:
            if b"_" not in word:
                return float(word)
        except ValueError:
            pass
        shown = word.decode("utf-8", "replace")[:40]
        raise ValueError(f"among the values that {self.where} announces is {shown!r}, not a number")


def _cells(file: _Words, count: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Offsets and node numbers."""
    place, begin, announced = file.place, file.begin, file.where
    words = file.line()
    if words and words[0].upper() == "OFFSETS":  # since version 5: count is that of offsets, size that of node numbers
        offsets = whole_numbers(file.array(count, words[1]), "offset")
        following = file.line() or [""]
        if following[0].upper() != "CONNECTIVITY":
            raise ValueError(f"{file.where} should begin the CONNECTIVITY of cells")
        return offsets, whole_numbers(file.array(size, following[1]), "node")
    file.place, file.begin = place, begin
    rows = whole_numbers(file.array(size, "int"), "node")
    if count > size:
        raise ValueError(f"{announced} names more cells than it lists")
    starts = [0]
    for cell in range(count):
        here = starts[-1]
        if here >= size or not 0 <= rows[here] < size - here:
            raise ValueError(f"{announced} announces {size} numbers for {count} cells, which does not fit cell {cell}")
        starts.append(here + int(rows[here]) + 1)
    if starts[-1] != size:
        raise ValueError(f"{announced} announces {size} numbers for {count} cells, which take {starts[-1]}")
    return np.array(starts) - np.arange(count + 1), np.delete(rows, np.array(starts[:-1], np.int64))
