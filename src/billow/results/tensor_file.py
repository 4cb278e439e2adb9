"""Arrays and a JSON record in one safetensors file that vouches for itself.

No pickle: nothing in the file can run. The record carries the SHA-256 of the whole file, taken with the 64 digits of
the sum itself as zeros, so that a change of any byte is noticed, in arrays, record or header. The sum finds damage;
it is no signature, whoever rewrites a file can rewrite the sum.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load as from_bytes
from safetensors.numpy import save as to_bytes

from billow.base.errors import IntegrityError
from billow.base.input_file import LARGEST_DATA, read_bytes
from billow.results.atomic import write_atomically

KEY = "billow"
SIGN = b'{"__metadata__":{"billow":'
"""What such a file has near its beginning."""
_ZEROS = "0" * 64
_SUM = re.compile(rb'\\"sha256\\": ?\\"([0-9a-f]{64})\\"')  # JSON inside a JSON string: quotes are escaped

Damaged = Callable[[str], IntegrityError]
"""Makes the error for a file that cannot be trusted, from a sentence that says why."""


def write_tensors(path: str | Path, tensors: dict[str, np.ndarray], record: dict) -> Path:
    """Write arrays and record to `path`, atomically. `record` must be plain JSON and have no "sha256"."""
    path = Path(path)
    text = json.dumps({**record, "sha256": _ZEROS}, allow_nan=False)
    data = to_bytes({name: np.ascontiguousarray(array) for name, array in tensors.items()}, {KEY: text})
    start, end = _SUM.search(data).span(1)
    write_atomically(path, data[:start] + _digest(data, start, end).encode() + data[end:])
    return path


def read_tensors(path: str | Path, damaged: Damaged) -> tuple[dict[str, np.ndarray], dict]:
    """Arrays and record of a file by `write_tensors`.

    Raises what `damaged` makes if the file is damaged or cut short, OSError if it cannot be read.
    """
    data = read_bytes(path, LARGEST_DATA)
    end = 8 + int.from_bytes(data[:8], "little")
    if not 8 <= end <= len(data):
        raise damaged(f"it has {len(data)} bytes, fewer than its own header announces")
    sums = list(_SUM.finditer(data, 8, end))
    if len(sums) != 1:
        raise damaged("its header holds no SHA-256 by Billow")
    found, said = _digest(data, *sums[0].span(1)), sums[0][1].decode()
    if found != said:
        raise damaged(f"its bytes have SHA-256 {found[:8]}..., it says {said[:8]}...")
    try:
        record = json.loads(json.loads(data[8:end])["__metadata__"][KEY])
        if not isinstance(record, dict):
            raise ValueError("its record is no table")
        return from_bytes(data), record
    except RecursionError as error:
        raise damaged("its record is nested too deeply") from error
    except (SafetensorError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise damaged(f"it is not a tensor file of Billow ({error})") from error


def _digest(data: bytes, start: int, end: int) -> str:
    digest = hashlib.sha256(memoryview(data)[:start])
    digest.update(_ZEROS.encode())
    digest.update(memoryview(data)[end:])
    return digest.hexdigest()
