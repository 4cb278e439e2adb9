"""Arrays as a Zarr store, a folder that other programs read: groups and arrays of the Zarr storage specification,
version 2 (https://zarr-specs.readthedocs.io/en/latest/v2/v2.0.html), little-endian, packed with zlib.

Only what a published dataset needs: chunks go along the first axis alone, and an array that has one value everywhere
has no chunks at all but that value as its fill value.
"""

from __future__ import annotations

import json
import zlib
from pathlib import Path

import numpy as np

CHUNK = 2**24
"""[byte] An unpacked chunk is at most so large, or one row."""
PACKED = 6
"""Level of zlib; 9 saves 1 % more and takes three times as long."""


def write_group(folder: Path, arrays: dict[str, np.ndarray], attributes: dict) -> None:
    """Make the store `folder` of named arrays, with attributes that JSON can say. The folder must not exist."""
    folder.mkdir()
    _write_json(folder / ".zgroup", {"zarr_format": 2})
    _write_json(folder / ".zattrs", attributes)
    for name, array in arrays.items():
        _write_array(folder / name, array)


def _write_array(folder: Path, array: np.ndarray) -> None:
    array = np.ascontiguousarray(array, np.asarray(array).dtype.newbyteorder("<"))
    folder.mkdir()
    constant = array.size > 0 and bool((array == array.flat[0]).all())
    row = max(array.nbytes // max(len(array), 1), 1)
    rows = min(max(CHUNK // row, 1), max(len(array), 1))
    size = array.dtype.itemsize
    meta = {
        "zarr_format": 2, "shape": list(array.shape), "chunks": [rows, *array.shape[1:]], "dtype": array.dtype.str,
        "order": "C", "fill_value": array.flat[0].item() if constant else 0,
        "compressor": {"id": "zlib", "level": PACKED}, "filters": [{"id": "shuffle", "elementsize": size}],
    }  # fmt: skip
    _write_json(folder / ".zarray", meta)
    for first in range(0, 0 if constant else len(array), rows):
        whole = np.full((rows, *array.shape[1:]), meta["fill_value"], array.dtype)  # the last one is filled up
        part = array[first : first + rows]
        whole[: len(part)] = part
        key = ".".join([str(first // rows), *"0" * (array.ndim - 1)])
        shuffled = whole.view(np.uint8).reshape(-1, size).T.tobytes()  # bytes of one rank together pack better
        (folder / key).write_bytes(zlib.compress(shuffled, PACKED))


def _write_json(path: Path, content: dict) -> None:
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
