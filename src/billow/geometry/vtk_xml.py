"""Reading VTK's XML files (.vtu and .vtp) without VTK: arrays in ascii, binary or appended, uncompressed or zlib
("VTK File Formats", docs.vtk.org, version 9). Nothing in a file is executed, and entities are refused.
"""

from __future__ import annotations

import base64
import binascii
import itertools
import re
import zlib
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from billow.base.table_file import whole_numbers
from billow.geometry.vtk_legacy import GHOSTS, POLYGON, QUAD, TRIANGLE, Grid

LARGEST_ARRAY = 200_000_000
"""Bytes of an unpacked array: eight million nodes."""
_XML_TYPES = {f"{kind}{bits}": f"{kind[0].lower()}{bits // 8}" for kind in ("Int", "UInt") for bits in (8, 32, 64)}
_XML_TYPES |= {"Float32": "f4", "Float64": "f8"}


def read_xml(content: bytes) -> Grid:
    """The grid in a file, with its numeric cell fields. ValueError, with a sentence, for anything else."""
    try:
        return _read(content)
    except (IndexError, KeyError, AttributeError, TypeError, OverflowError, zlib.error, binascii.Error):
        raise ValueError("it is cut short or not the VTK file that its name says") from None


def _read(content: bytes) -> Grid:
    # Raw appended data are no XML; what stands before them is closed by hand.
    start = content.find(b"<AppendedData")
    appended, encoding = b"", "base64"
    if start >= 0:
        head, mark, body = content[start:].partition(b"_")
        if not mark:
            raise ValueError("its appended data do not begin")
        encoding = "raw" if b"raw" in head else "base64"
        appended, content = body, content[:start] + b"</VTKFile>"
    if b"\0" in content or b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise ValueError("it is UTF-16, or declares entities, which no VTK file does")
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise ValueError(f"it is no XML ({error})") from error
    compressor = root.get("compressor")
    if compressor not in (None, "vtkZLibDataCompressor"):
        raise ValueError(f"it is packed with {compressor[:40]}; zlib or none can be read")
    order = "<" if root.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
    header = np.dtype(order + _XML_TYPES[root.get("header_type", "UInt32")])
    reader = _Arrays(order, header, compressor is not None, appended, encoding)
    pieces = root.findall(".//Piece")
    if len(pieces) != 1:
        raise ValueError(f"it has {len(pieces)} pieces; one can be read")
    (piece,) = pieces
    for name in ("NumberOfVerts", "NumberOfLines", "NumberOfStrips"):
        if piece.get(name, "0").strip() != "0":
            raise ValueError(f"its {name} is {piece.get(name)[:20]}; save its polygons alone, strips as triangles")
    for ghosts in piece.findall("*/DataArray"):
        if ghosts.get("Name") == GHOSTS and reader.read(ghosts).any():
            raise ValueError("it has ghost points or cells, copies of another piece's; save the whole fabric in one")
    points = reader.read(piece.find("Points/DataArray")).astype(float)
    cells = piece.find("Cells") if piece.find("Cells") is not None else piece.find("Polys")
    arrays = {array.get("Name"): reader.read(array) for array in cells.findall("DataArray")}
    offsets = np.concatenate([[0], whole_numbers(arrays["offsets"], "offset")])
    corners = np.diff(offsets)
    types = np.select([corners == 3, corners == 4], [TRIANGLE, QUAD], POLYGON)
    if "types" in arrays:
        types = whole_numbers(arrays["types"], "kind of cell")
    announced = _count(piece, "NumberOfPoints", len(points) // 3)
    if points.size != 3 * announced:
        raise ValueError(f"it announces {announced} points and holds {points.size} coordinates")
    fields = {
        array.get("Name", ""): reader.read(array).reshape(len(types), -1)
        for array in piece.findall("CellData/DataArray")
        if array.get("type") in _XML_TYPES and len(types)
    }
    nodes = whole_numbers(arrays["connectivity"], "node")
    return Grid(points.reshape(-1, 3), offsets, nodes, types, fields)


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
            try:
                return np.array(text.split(), dtype)
            except (ValueError, OverflowError):
                raise ValueError(
                    f"its array {element.get('Name', '')[:40]!r} holds something else than numbers"
                ) from None
        if kind == "binary":
            return np.frombuffer(self._data(text.strip().encode(), "base64"), dtype)
        return np.frombuffer(self._data(self.appended[_count(element, "offset") :], self.encoding), dtype)

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
        if (len(places) - 1) * sizes[1] > LARGEST_ARRAY:
            raise ValueError(f"unpacked it has arrays of more than {LARGEST_ARRAY} bytes")
        return b"".join(_unpacked(data[a:b], sizes[1]) for a, b in itertools.pairwise(places))


def _count(element, name: str, default: int | None = None) -> int:
    text = element.get(name, default)
    if not re.fullmatch(r"\d{1,15}", str(text).strip(), re.ASCII):
        raise ValueError(f"its {name} is {str(text)[:40]!r}, not a count")
    return int(text)


def _unpacked(block: bytes, size: int) -> bytes:
    """A block that has at most so many bytes unpacked; a small one could hold gigabytes."""
    unpacking = zlib.decompressobj()
    data = unpacking.decompress(block, size)
    if not unpacking.eof and (unpacking.unconsumed_tail or unpacking.decompress(b"", 1)):
        raise ValueError("it unpacks to more than it announces")
    return data


def _encoded(size: int) -> int:
    """Characters that base64 makes of so many bytes."""
    return 4 * -(-size // 3)
