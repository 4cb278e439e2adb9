"""Points and triangles of one VTK file, without VTK: legacy .vtk, and XML .vtu and .vtp.

Formats as in "VTK File Formats" (docs.vtk.org, version 9): legacy as in `billow.geometry.vtk_legacy`; XML with ascii,
binary or appended arrays, uncompressed or zlib. Quadrilaterals are cut into two triangles; other cells are refused.
"""

from __future__ import annotations

import base64
import binascii
import itertools
import zlib
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from billow.geometry.vtk_legacy import QUAD, TRIANGLE, read_legacy

SUFFIXES = (".vtk", ".vtu", ".vtp")
_XML_TYPES = {f"{kind}{bits}": f"{kind[0].lower()}{bits // 8}" for kind in ("Int", "UInt") for bits in (8, 32, 64)}
_XML_TYPES |= {"Float32": "f4", "Float64": "f8"}


def read_vtk(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points (nodes, 3) float64, in the file's unit, and triangles (triangles, 3) int64, of one file.

    ValueError, with a sentence that says why, for anything else than the above.
    """
    content = path.read_bytes()
    try:
        points, offsets, nodes, types = read_legacy(content)[:4] if path.suffix == ".vtk" else _xml(content)
    except (IndexError, KeyError, AttributeError, TypeError, zlib.error, binascii.Error) as error:
        raise ValueError(f"it is cut short or not the VTK file that its name says ({error})") from error
    offsets, nodes = np.asarray(offsets, np.int64), np.asarray(nodes, np.int64)
    first, corners = offsets[:-1], np.diff(offsets)  # of each cell: where its nodes begin, and how many it has
    if not np.isin(corners, (3, 4)).all() or not (types is None or np.isin(types, (TRIANGLE, QUAD)).all()):
        raise ValueError("it has cells that are neither triangles nor quadrilaterals")
    quads = np.flatnonzero(corners == 4)
    whole = nodes[first[:, None] + np.arange(3)]
    halves = nodes[first[quads, None] + np.array([0, 2, 3])]
    order = np.argsort(np.concatenate([2 * np.arange(len(first)), 2 * quads + 1]), kind="stable")
    return points, np.concatenate([whole, halves])[order]


def _xml(content: bytes):
    # Raw appended data are no XML; what stands before them is closed by hand.
    start = content.find(b"<AppendedData")
    appended, encoding = b"", "base64"
    if start >= 0:
        head, body = content[start:].split(b"_", 1)
        encoding = "raw" if b"raw" in head else "base64"
        appended, content = body, content[:start] + b"</VTKFile>"
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise ValueError("it declares entities, which no VTK file does")
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise ValueError(f"it is no XML ({error})") from error
    compressor = root.get("compressor")
    if compressor not in (None, "vtkZLibDataCompressor"):
        raise ValueError(f"it is packed with {compressor}; zlib or none can be read")
    order = "<" if root.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
    header = np.dtype(order + _XML_TYPES[root.get("header_type", "UInt32")])
    reader = _Arrays(order, header, compressor is not None, appended, encoding)
    pieces = root.findall(".//Piece")
    if len(pieces) != 1:
        raise ValueError(f"it has {len(pieces)} pieces; one can be read")
    (piece,) = pieces
    points = reader.read(piece.find("Points/DataArray"))
    cells = piece.find("Cells") if piece.find("Cells") is not None else piece.find("Polys")
    arrays = {array.get("Name"): reader.read(array) for array in cells.findall("DataArray")}
    offsets = np.concatenate([[0], arrays["offsets"]])
    return np.asarray(points, float).reshape(-1, 3), offsets, arrays["connectivity"], arrays.get("types")


@dataclass(frozen=True)
class _Arrays:
    """DataArray elements of one XML file. order: of bytes, "<" or ">"; header: type of the sizes before the data;
    appended: data that stand behind the XML, encoded as "base64" or "raw"."""

    order: str
    header: np.dtype
    packed: bool
    appended: bytes
    encoding: str

    def read(self, element) -> np.ndarray:
        dtype = np.dtype(self.order + _XML_TYPES[element.get("type")])
        kind, text = element.get("format", "ascii"), element.text or ""
        if kind == "ascii":
            return np.array(text.split(), dtype)
        if kind == "binary":
            return np.frombuffer(self._data(text.strip().encode(), "base64"), dtype)
        return np.frombuffer(self._data(self.appended[int(element.get("offset")) :], self.encoding), dtype)

    def _data(self, block: bytes, encoding: str) -> bytes:
        """The data behind their header: its one number is the size; of packed data blocks, block size, last block's
        size, and each block's packed size. Base64 has header and data one after the other, each filled up with = signs
        of its own, or in one go."""
        word, coded = self.header.itemsize, encoding == "base64"

        def first(size: int, start: int = 0) -> bytes:
            """So many bytes of the block, from a place where they begin."""
            if not coded:
                return block[start : start + size]
            return base64.b64decode(block[start : start + _encoded(size)])

        counts = 3 + int(np.frombuffer(first(word), self.header, 1)[0]) if self.packed else 1
        end = counts * word
        sizes = np.frombuffer(first(end), self.header, counts).tolist()
        end = _encoded(end) if coded else end
        if not self.packed:
            whole = coded and not block[:end].endswith(b"=")
            return first(word + sizes[0])[word:] if whole else first(sizes[0], end)
        places = [0, *itertools.accumulate(sizes[3:])]
        data = first(places[-1], end)
        return b"".join(zlib.decompress(data[a:b]) for a, b in itertools.pairwise(places))


def _encoded(size: int) -> int:
    """Characters that base64 makes of so many bytes."""
    return 4 * -(-size // 3)
