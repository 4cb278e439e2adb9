"""Reading surface meshes of other programs: STL, OBJ and PLY, in text or binary, each with one idea of what a file may
hold; what is not known is refused, never skipped.

STL: "StL" of 3D Systems (1988), facets with corners of their own, which become one node where all bits agree; each
solid is a part. OBJ: Wavefront, v, f, g and o; groups are parts. PLY: Turk (1994), vertex x y z and face lists.
"""

from __future__ import annotations

import re

import numpy as np

from billow.geometry.vtk_legacy import QUAD, TRIANGLE, Grid

_PLY_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_HEADER = 80
MOST_HEADER = 100_000
"""Bytes of the header of a PLY file."""


def read_stl(content: bytes) -> tuple[Grid, dict[str, int]]:
    """Grid and part numbers by name. ValueError, with a sentence."""
    count = int.from_bytes(content[_HEADER : _HEADER + 4], "little")
    if len(content) == _HEADER + 4 + 50 * count and count:
        record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        corners = np.frombuffer(content, record, count, _HEADER + 4)["corners"].astype(float)
        return _joined(corners, np.zeros(count, np.int64)), {}
    if not content.lstrip()[:5].lower() == b"solid":
        raise ValueError("it is neither a binary STL of the length that it announces nor begins with solid")
    words = content.decode("latin-1").split("\n")
    corners, part, names, facets = [], [], {}, 0
    for number, line in enumerate(words, 1):
        word, *rest = line.split() or [""]
        if word == "solid":
            name = " ".join(rest) or f"solid_{len(names)}"
            names[name] = names.get(name, len(names))
            current = names[name]
        elif word == "vertex":
            corners.append(_numbers(rest, 3, number))
        elif word == "endfacet":
            facets += 1
            part.append(current)
            if len(corners) != 3 * facets:
                raise ValueError(f"line {number}: a facet has other than three corners")
        elif word not in ("", "facet", "outer", "endloop", "endsolid"):
            raise ValueError(f"line {number} begins with {word[:20]!r}, which is not known there")
    if len(corners) != 3 * facets:
        raise ValueError("it is cut short within a facet")
    return _joined(np.array(corners).reshape(-1, 3, 3), np.array(part, np.int64)), names


def read_obj(content: bytes) -> tuple[Grid, dict[str, int]]:
    """Grid and part numbers by name. ValueError, with a sentence."""
    points, cells, part, names, current = [], [], [], {}, 0
    for number, line in enumerate(content.decode("latin-1").replace("\\\n", " ").split("\n"), 1):
        word, *rest = line.split("#")[0].split() or [""]
        if word == "v":
            points.append(_numbers(rest[:3], 3, number))
        elif word == "f":
            if len(rest) not in (3, 4):
                raise ValueError(f"line {number}: a face of {len(rest)} corners; triangles and quads can be read")
            cells.append([_node(text.split("/")[0], len(points), number) for text in rest])
            part.append(current)
        elif word in ("g", "o"):
            name = " ".join(rest) or "default"
            current = names.setdefault(name, len(names))
        elif word in ("l", "p", "curv", "surf", "call"):
            raise ValueError(f"line {number} holds {word!r}; save the faces alone")
    used = {number: name for name, number in names.items()}
    return _grid(np.array(points).reshape(-1, 3), cells, np.array(part, np.int64)), {
        name: number for number, name in used.items() if number in set(part)
    }


def read_ply(content: bytes) -> tuple[Grid, dict[str, int]]:
    """Grid; a PLY has no parts. ValueError, with a sentence."""
    end = re.search(rb"end_header[ \t]*\r?\n", content[:MOST_HEADER])
    if not content.startswith(b"ply") or end is None:
        raise ValueError("it does not begin with the header of a PLY file")
    form, elements = "", []
    for line in content[: end.start()].decode("latin-1").splitlines()[1:]:
        match line.split():
            case ["format", form, _]:
                pass
            case ["element", name, count] if count.isdigit():
                elements.append((name, int(count), []))
            case ["property", "list", a, b, name] if elements and a in _PLY_TYPES and b in _PLY_TYPES:
                elements[-1][2].append((name, _PLY_TYPES[b], _PLY_TYPES[a]))
            case ["property", kind, name] if elements and kind in _PLY_TYPES:
                elements[-1][2].append((name, _PLY_TYPES[kind], None))
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise ValueError(f"its header has {line[:40]!r}, which is not known there")
    if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"its format is {form[:30]!r}")
    reader = _Ply(content[end.end() :], form)
    points, cells = None, []
    for name, count, properties in elements:
        if count > len(reader.data):
            raise ValueError("it announces more elements than it can hold")
        if name == "vertex":
            columns = [reader_name for reader_name, _, _ in properties]
            if any(size for _, _, size in properties) or not {"x", "y", "z"} <= set(columns):
                raise ValueError("its vertices have no x, y and z")
            rows = reader.rows(count, [kind for _, kind, _ in properties])
            points = np.column_stack([rows[columns.index(axis)] for axis in "xyz"]).astype(float)
        else:
            for _ in range(count):
                for key, kind, size in properties:
                    values = reader.take(int(reader.take(1, size)[0]) if size else 1, kind)
                    if name == "face" and key in ("vertex_indices", "vertex_index"):
                        cells.append([int(v) for v in values])
    if points is None:
        raise ValueError("it has no vertices")
    return _grid(points, cells, np.zeros(len(cells), np.int64)), {}


class _Ply:
    """The body of a PLY file, read from front to back."""

    def __init__(self, body: bytes, form: str):
        self.order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(form, "")
        self.data = body if self.order else body.split()
        self.at = 0

    def take(self, count: int, kind: str) -> np.ndarray:
        size = np.dtype(kind).itemsize if self.order else 1
        if not 0 <= count <= (len(self.data) - self.at) // size:
            raise ValueError("it is cut short")
        self.at += count * size
        if self.order:
            return np.frombuffer(self.data, self.order + kind, count, self.at - count * size)
        return np.array(_numbers([w.decode("latin-1") for w in self.data[self.at - count : self.at]], count, 0))

    def rows(self, count: int, kinds: list[str]) -> list[np.ndarray]:
        """Columns of like rows."""
        if self.order:
            record = np.dtype([(str(k), self.order + kind) for k, kind in enumerate(kinds)])
            if count * record.itemsize > len(self.data) - self.at:
                raise ValueError("it is cut short")
            table = np.frombuffer(self.data, record, count, self.at)
            self.at += count * record.itemsize
            return [table[str(k)] for k in range(len(kinds))]
        table = self.take(count * len(kinds), "f8").reshape(count, len(kinds))
        return list(table.T)


def _numbers(words: list[str], count: int, line: int) -> list[float]:
    try:
        if len(words) == count and not any("_" in word for word in words):
            return [float(word) for word in words]
    except ValueError:
        pass
    place = f"line {line}" if line else "its body"
    raise ValueError(f"{place} holds {' '.join(words)[:40]!r} where {count} numbers are expected")


def _node(text: str, count: int, line: int) -> int:
    if not re.fullmatch(r"-?\d{1,9}", text, re.ASCII) or int(text) == 0:
        raise ValueError(f"line {line}: {text[:20]!r} is no number of a vertex")
    return int(text) - 1 if int(text) > 0 else count + int(text)


def _joined(corners: np.ndarray, part: np.ndarray) -> Grid:
    """Triangles (n, 3, 3) whose equal corners are one node, in the order in which they first appear."""
    points, first, node = np.unique(corners.reshape(-1, 3) + 0.0, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    offsets = 3 * np.arange(len(corners) + 1)
    return Grid(points[order], offsets, rank[node.ravel()], np.full(len(corners), TRIANGLE), {"part": part})


def _grid(points: np.ndarray, cells: list[list[int]], part: np.ndarray) -> Grid:
    count = np.array([len(cell) for cell in cells], np.int64)
    if not np.isin(count, (3, 4)).all():
        raise ValueError(f"face {int(np.argmin(np.isin(count, (3, 4))))} is neither a triangle nor a quad")
    offsets = np.concatenate([[0], np.cumsum(count)])
    nodes = np.array([node for cell in cells for node in cell], np.int64)
    return Grid(points, offsets, nodes, np.where(count == 3, TRIANGLE, QUAD), {"part": part})
