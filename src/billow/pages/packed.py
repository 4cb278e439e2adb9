"""Arrays and a JSON record as the few bytes that a page holds: a safetensors file, packed by gzip."""

from __future__ import annotations

import gzip
import json

import numpy as np
from safetensors.numpy import save

KEY = "billow"
MOST_STEPS = 65535
"""Of the coordinates of a frame, across the box of all frames."""


def pack(tensors: dict[str, np.ndarray], record: dict) -> bytes:
    """Bytes that `tensors.js` reads. record: plain JSON; the same content gives the same bytes."""
    plain = {name: np.ascontiguousarray(array) for name, array in tensors.items()}
    return gzip.compress(save(plain, {KEY: json.dumps(record, allow_nan=False)}), 9, mtime=0)


def whole_numbers(array: np.ndarray) -> np.ndarray:
    """Indices in as few bytes as hold them: JavaScript has no fast numbers of eight."""
    largest = int(array.max(initial=0))
    return array.astype(np.uint8 if largest < 2**8 else np.uint16 if largest < 2**16 else np.uint32)


def in_planes(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m], (frames, points, 3), as steps of the box that holds all of them, and the box [m], (2, 3) float64.

    Each frame is the difference from the one before, modulo 2^16, low and high bytes apart, (2, frames, 3, points)
    uint8: what repeats lies together for gzip. The error is half a step, 1/131,070 of the box.
    """
    box = np.stack([positions.min(axis=(0, 1)), positions.max(axis=(0, 1))]).astype(float)
    span = np.where(box[1] > box[0], box[1] - box[0], 1.0)
    steps = np.rint((positions - box[0]) / span * MOST_STEPS).astype(np.uint16).transpose(0, 2, 1)
    steps = np.concatenate([steps[:1], steps[1:] - steps[:-1]])
    return np.stack([steps & 0xFF, steps >> 8]).astype(np.uint8), box


def in_bytes(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Values as uint8, 1 at `low` to 255 at `high`, 0 for what is no number; each frame after the first is the
    difference from the one before, modulo 2^8: (frames, n)."""
    span = high - low if high > low else 1.0
    part = np.clip((np.nan_to_num(values) - low) / span, 0.0, 1.0)
    steps = np.where(np.isfinite(values), 1.0 + np.rint(254.0 * part), 0.0).astype(np.uint8)
    return np.concatenate([steps[:1], steps[1:] - steps[:-1]])
