"""Rows of arrays in HDF5 files, never more than were asked for: a small file can announce, or unpack to, anything."""

from __future__ import annotations

import h5py
import numpy as np

LARGEST_CHUNK = 256_000_000
"""Bytes that are unpacked together; Billow packs a frame at a time, and a million nodes take 12 MB."""


def take(data: h5py.Dataset, begin: int, count: int, row: tuple[int, ...] | None = ()) -> np.ndarray:
    """Rows begin to begin + count of an array of numbers. row: the shape of each; None: whatever it is.

    ValueError, with a sentence, if there are fewer, rows of another shape, or no numbers.
    """
    name = getattr(data, "name", "it").removeprefix("/VTKHDF/")
    if not isinstance(data, h5py.Dataset) or data.dtype.kind not in "iuf":
        raise ValueError(f"{name} is no array of numbers")
    if not data.shape or (row is not None and data.shape[1:] != row):
        raise ValueError(f"{name} has shape {data.shape}; expected rows{f' of {row[0]}' if row else ''}")
    if data.chunks and np.prod(data.chunks, dtype=float) * data.dtype.itemsize > LARGEST_CHUNK:
        raise ValueError(f"{name} is packed in pieces of more than {LARGEST_CHUNK} bytes")
    if row is None and np.prod(data.shape[1:], dtype=float) > 100:
        raise ValueError(f"{name} has shape {data.shape}; expected one column")
    if not 0 <= begin <= len(data) - count:
        raise ValueError(f"{name} has {len(data)} rows; {begin} to {begin + count} are needed")
    return data[begin : begin + count]
