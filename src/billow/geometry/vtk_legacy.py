"""Reading VTK legacy files (.vtk) without VTK: POLYDATA and UNSTRUCTURED_GRID, ASCII or binary.

Cells in the layout before or since version 5 ("VTK File Formats", docs.vtk.org, version 9). Nothing in a file is
executed, and no array is larger than the file.
"""

from __future__ import annotations

import numpy as np

TRIANGLE, POLYGON, QUAD = 5, 7, 9
"""VTK's numbers for kinds of cells."""

_TYPES = {
    "float": "f4", "double": "f8", "char": "i1", "unsigned_char": "u1", "short": "i2", "int": "i4",
    "unsigned_int": "u4", "long": "i8", "vtktypeint32": "i4", "vtktypeint64": "i8",
}  # fmt: skip


def read_legacy(content: bytes, field: str | None = None) -> tuple[np.ndarray, ...]:
    """Points (nodes, 3) float64, offsets (cells + 1,) and node numbers of all cells, VTK's number for the kind of each
    cell (cells,), and the values of a cell field (cells,), zeros where there is none of that name.

    ValueError, KeyError, IndexError or TypeError for anything else than the above.
    """
    file, points, cells, types, values = _Words(content), None, None, None, None
    count, of_cells = 0, False
    while (words := file.line()) is not None:
        match words[0].upper():
            case "DATASET" if words[1].upper() not in ("POLYDATA", "UNSTRUCTURED_GRID"):
                raise ValueError(f"its dataset is {words[1]}; POLYDATA and UNSTRUCTURED_GRID can be read")
            case "POINTS":
                points = file.array(3 * int(words[1]), words[2])
            case "CELLS" | "POLYGONS":
                cells = _cells(file, int(words[1]), int(words[2]))
            case "CELL_TYPES":
                types = file.array(int(words[1]), "int").astype(np.int64)
            case "POINT_DATA" | "CELL_DATA" if field is None:
                break
            case "POINT_DATA" | "CELL_DATA":
                count, of_cells = int(words[1]), words[0].upper() == "CELL_DATA"
            case "SCALARS":
                file.line()  # LOOKUP_TABLE name
                found = file.array(count * (int(words[3]) if len(words) > 3 else 1), words[2])
                values = found if of_cells and words[1] == field else values
            case "VECTORS" | "NORMALS":
                file.array(3 * count, words[2])
            case "FIELD":
                for _ in range(int(words[2])):
                    name, components, tuples, kind = file.line()[:4]
                    found = file.array(int(components) * int(tuples), kind)
                    values = found if of_cells and name == field else values
    if points is None or cells is None:
        raise ValueError("it has no points or no cells")
    if types is None:
        corners = np.diff(cells[0])
        types = np.select([corners == 3, corners == 4], [TRIANGLE, QUAD], POLYGON)
    return points.astype(float).reshape(-1, 3), *cells, types, np.zeros(len(types)) if values is None else values


class _Words:
    """The lines and arrays of a file, one after the other."""

    def __init__(self, content: bytes):
        lines = content.split(b"\n", 3)
        if len(lines) < 4 or not lines[0].startswith(b"# vtk DataFile"):
            raise ValueError("it is not a VTK legacy file")
        self.binary = lines[2].strip().upper() == b"BINARY"
        self.content, self.place = content, len(content) - len(lines[3])

    def line(self) -> list[str] | None:
        while self.place < len(self.content):
            end = self.content.find(b"\n", self.place)
            end = len(self.content) if end < 0 else end
            words = self.content[self.place : end].decode("ascii", "replace").split()
            self.place = end + 1
            if words:
                return words
        return None

    def array(self, count: int, kind: str) -> np.ndarray:
        dtype = np.dtype(">" + _TYPES[kind.lower()])
        if not 0 <= count * (dtype.itemsize if self.binary else 1) <= len(self.content) - self.place:
            raise ValueError("it is cut short, or names too many items")
        if self.binary:
            values = np.frombuffer(self.content, dtype, count, self.place)
            self.place += count * dtype.itemsize
            return values
        words = self.content[self.place :].split(None, count)
        self.place = len(self.content) - (len(words.pop()) if len(words) > count else 0)
        if len(words) < count:
            raise ValueError("it is cut short")
        return np.array(words, dtype=bytes).astype(float) if count else np.zeros(0)


def _cells(file: _Words, count: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Offsets and node numbers."""
    begin = file.place
    words = file.line()
    if words and words[0].upper() == "OFFSETS":  # since version 5: count is that of offsets, size that of node numbers
        offsets = file.array(count, words[1])
        return offsets.astype(np.int64), file.array(size, file.line()[1]).astype(np.int64)
    file.place = begin
    rows = file.array(size, "int").astype(np.int64)
    if not 0 <= count <= size:
        raise ValueError("it names more cells than it lists")
    starts = [0]
    for _ in range(count):
        starts.append(starts[-1] + int(rows[starts[-1]]) + 1)
    sizes = np.array(starts[:-1], np.int64)
    return np.array(starts) - np.arange(count + 1), np.delete(rows[: starts[-1]], sizes)
