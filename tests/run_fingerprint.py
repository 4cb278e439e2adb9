"""One number for everything a run computed: equal numbers, equal bits.

HDF5 arranges the inside of a file as it likes, so two files with the same contents may differ byte for byte; the
fingerprint is taken over the contents.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from billow.results.result import Result


def fingerprint(folder: str | Path) -> str:
    """SHA-256, hexadecimal, over all histories and all frames of a published run; errors as `Result.open`."""
    result = Result.open(folder)
    digest = hashlib.sha256()
    for name, column in result.histories.items():
        digest.update(name.encode() + np.ascontiguousarray(column, dtype="<f8").tobytes())
    fabric = result.fabric
    digest.update(np.ascontiguousarray(fabric.times, dtype="<f8").tobytes())
    for step in range(len(fabric.times)):
        digest.update(np.ascontiguousarray(fabric.points(step)).tobytes())
    for name in sorted(fabric.point_fields):
        digest.update(name.encode() + fabric.point_data(name).tobytes())
    for name in sorted(fabric.cell_fields):
        digest.update(name.encode() + fabric.cell_data(name).tobytes())
    return digest.hexdigest()
