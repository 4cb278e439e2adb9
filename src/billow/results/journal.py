"""What a run has told so far: appended, each piece with its own checksum, cut back when a run resumes.

HDF5 is only written from finished data: a process that is killed while it writes an HDF5 file can lose all of it. A
journal loses at most the piece being written. It holds one row of histories or one frame per piece:

    kind (1 byte: C columns, R row, F frame)   length (8 bytes)   SHA-256 (32 bytes)   payload
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load as from_bytes
from safetensors.numpy import save as to_bytes

from billow.base.errors import IntegrityError
from billow.results.histories import History

DAMAGED_JOURNAL = IntegrityError.declare(
    "E-RES-030",
    "the journal of a run is damaged",
    where="{path}",
    cause="a disk that was full or failed during the run",
    remedy="run the case again from the start: billow run CASE.toml --out RUN",
)

JOURNAL = "journal.bin"
"""Its name in the folder of a run."""
STATUS = "status.json"
"""What lies beside it while a run goes on."""
_HEAD = 1 + 8 + 32


class Journal:
    """An open journal. `offset`: bytes written so far; a checkpoint notes it."""

    def __init__(self, path: str | Path, offset: int = 0):
        """Start a journal, or go on with one after its first `offset` bytes; what lies behind is dropped.

        IntegrityError E-RES-030 unless those bytes are whole pieces: better told now than when the run ends.
        """
        self.path = Path(path)
        if offset:
            _require_pieces(self.path, offset)
        self._file = open(self.path, "r+b" if offset else "wb")  # noqa: SIM115 - lives as long as the run
        self._file.truncate(offset)
        self._file.seek(offset)
        self.offset = offset

    def columns(self, names: list[str]) -> None:
        """Names of the columns of all rows to come."""
        self._append(b"C", json.dumps(names).encode())

    def row(self, values: np.ndarray) -> None:
        """One row of histories, (columns,) float64."""
        self._append(b"R", np.asarray(values, dtype="<f8").tobytes())

    def frame(self, arrays: dict[str, np.ndarray]) -> None:
        """One frame: named arrays."""
        self._append(b"F", to_bytes({name: np.ascontiguousarray(array) for name, array in arrays.items()}))

    def flush(self) -> None:
        """Everything appended can be read by others on return."""
        self._file.flush()

    def sync(self) -> None:
        """Everything appended is on disk on return."""
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        self._file.close()

    def _append(self, kind: bytes, payload: bytes) -> None:
        piece = kind + len(payload).to_bytes(8, "little") + hashlib.sha256(payload).digest() + payload
        self._file.write(piece)
        self.offset += len(piece)


def read_history(path: str | Path) -> History:
    """All rows of a journal. Errors as `pieces`."""
    return _history(pieces(path))


def history_so_far(path: str | Path) -> History:
    """The rows of a journal that is still being written, up to the first piece that is not whole; frames, which are
    most of it, are passed over."""
    return _history(_rows_so_far(Path(path)))


def _rows_so_far(path: Path) -> Iterator[tuple[bytes, bytes]]:
    with open(path, "rb") as file:
        while len(head := file.read(_HEAD)) == _HEAD:
            length = int.from_bytes(head[1:9], "little")
            if head[:1] == b"F":
                file.seek(length, os.SEEK_CUR)
                continue
            payload = file.read(length)
            if len(payload) < length or hashlib.sha256(payload).digest() != head[9:]:
                return
            yield head[:1], payload


def _history(found: Iterator[tuple[bytes, bytes]]) -> History:
    names, rows = [], []
    for kind, payload in found:
        if kind == b"C":
            names = json.loads(payload)
        elif kind == b"R":
            rows.append(np.frombuffer(payload, dtype="<f8"))
    table = np.array(rows).reshape(len(rows), len(names))
    return History({name: table[:, k] for k, name in enumerate(names)})


def frames(path: str | Path) -> Iterator[dict[str, np.ndarray]]:
    """The frames of a journal in order. Errors as `pieces`."""
    for kind, payload in pieces(path):
        if kind == b"F":
            try:
                yield from_bytes(payload)
            except SafetensorError as error:
                raise DAMAGED_JOURNAL(path=path, why=f"a frame cannot be read ({error})") from error


def pieces(path: str | Path) -> Iterator[tuple[bytes, bytes]]:
    """Kind and payload of every piece. Raises IntegrityError E-RES-030 at the first that is damaged or cut short."""
    path = Path(path)
    with open(path, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        while head := file.read(_HEAD):
            length = int.from_bytes(head[1:9], "little")
            if len(head) < _HEAD or length > size - file.tell():
                raise DAMAGED_JOURNAL(path=path, why=f"it ends in the middle of a piece, at byte {size}")
            payload = file.read(length)
            if hashlib.sha256(payload).digest() != head[9:]:
                raise DAMAGED_JOURNAL(path=path, why=f"a piece before byte {file.tell()} does not match its checksum")
            yield head[:1], payload


def _require_pieces(path: Path, offset: int) -> None:
    found = 0
    try:
        for _, payload in pieces(path):
            found += _HEAD + len(payload)
            if found >= offset:
                break
    except OSError as error:
        raise DAMAGED_JOURNAL(path=path, why=error) from error
    if found != offset:
        why = f"the checkpoint needs a piece that ends at byte {offset}; the nearest ends at {found}"
        raise DAMAGED_JOURNAL(path=path, why=why)
