"""Arrays of .npy and .npz files, plain numbers only, never larger than they may be."""

from __future__ import annotations

import warnings
import zipfile
import zlib
from pathlib import Path
from tokenize import TokenError
from typing import BinaryIO

import numpy as np

from billow.base.input_file import LARGEST_DATA, require_file


def read_npy(path: Path) -> np.ndarray:
    """The array of a .npy file. OSError if it cannot be read; ValueError, with a sentence, if it is none of numbers."""
    size = require_file(path, LARGEST_DATA)
    with open(path, "rb") as file:
        return _array(file, size, path.name)


def read_npz(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a .npz file by name; errors as `read_npy`."""
    require_file(path, LARGEST_DATA)
    try:
        with zipfile.ZipFile(path) as archive:
            members = {m.filename.removesuffix(".npy"): m for m in archive.infolist() if m.filename.endswith(".npy")}
            total = sum(member.file_size for member in members.values())
            if total > LARGEST_DATA:
                raise ValueError(f"unpacked it has {total} bytes; at most {LARGEST_DATA} are read")
            found = {}
            for name, member in members.items():
                with archive.open(member) as file:
                    found[name] = _array(file, member.file_size, f"{path.name}, array {name}")
            return found
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, EOFError, RuntimeError, OSError):
        raise ValueError(f"{path.name} is damaged, or no .npz file") from None


def _array(file: BinaryIO, size: int, name: str) -> np.ndarray:
    """size: bytes from the beginning of the file to its end."""
    try:
        version = np.lib.format.read_magic(file)
        header = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}[version]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of files by Python 2
            shape, by_column, dtype = header(file)
    except (ValueError, KeyError, SyntaxError, TokenError, TypeError, RecursionError, MemoryError, OverflowError):
        raise ValueError(f"{name} does not begin like an array of NumPy") from None
    if dtype.kind not in "iufb" or any(length < 0 for length in shape):
        raise ValueError(f"{name} holds no numbers")
    count = 1
    for length in shape:
        count *= int(length)
    data = file.read(min(count * dtype.itemsize, size) + 1)
    if len(data) != count * dtype.itemsize:
        raise ValueError(f"{name} is cut short, or longer than its shape {shape}")
    array = np.frombuffer(data, dtype).reshape(shape[::-1] if by_column else shape)
    return array.T if by_column else array
