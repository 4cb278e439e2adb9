"""The file behind HDF5 while it is written: on disk, whole or not at all, and patient when the disk is full.

HDF5 cannot be told that a write failed: objects that it could not flush are flushed again when the process ends, which
crashes it. So it writes to a file of ours, which keeps in memory what the disk refuses and remembers why. The writer
asks for that after every step, and closes HDF5 in order.
"""

from __future__ import annotations

import contextlib
import io
import os
import uuid
from pathlib import Path


class PatientFile:
    """A new file for `h5py.File(..., "w")`; it gets the name `path` when `publish` is called.

    FileExistsError if `path` exists. problem: why a write failed, if one did.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        if os.path.lexists(self.path):
            raise FileExistsError(17, os.strerror(17), str(self.path))
        self._temporary = self.path.with_name(f".{self.path.name}.{uuid.uuid4().hex[:12]}.partial")
        self._file = open(self._temporary, "x+b", buffering=0)  # noqa: SIM115 - lives as long as the writer
        self._place = self._end = 0
        self._refused: list[tuple[int, bytes]] = []
        self.problem: OSError | None = None

    def check(self) -> None:
        """Raises the OSError of the first write that failed."""
        if self.problem is not None:
            raise self.problem

    def publish(self) -> None:
        """Everything is on disk under the file's own name on return. OSError."""
        if self.problem is None:
            self._file.truncate(self._end)
        self.check()
        os.fsync(self._file.fileno())
        self._file.close()
        os.replace(self._temporary, self.path)

    def abandon(self) -> None:
        """Remove what was written, unless it was published."""
        self._file.close()
        with contextlib.suppress(OSError):
            self._temporary.unlink()

    # --- what h5py asks for ----------------------------------------------------------------------------------------

    def write(self, data) -> int:
        data = memoryview(data).cast("B")
        if self.problem is None:
            try:
                self._file.seek(self._place)
                done = 0
                while done < len(data):
                    done += self._file.write(data[done:])
            except OSError as error:
                self.problem = OSError(error.errno, error.strerror, str(self.path))
        if self.problem is not None:
            self._refused.append((self._place, bytes(data)))
        self._place += len(data)
        self._end = max(self._end, self._place)
        return len(data)

    def readinto(self, buffer) -> int:
        found = memoryview(buffer).cast("B")
        first, end = self._place, self._place + len(found)
        self._file.seek(first)
        read = self._file.readinto(found)
        found[read:] = bytes(len(found) - read)
        for place, data in self._refused:
            low, high = max(place, first), min(place + len(data), end)
            if low < high:
                found[low - first : high - first] = data[low - place : high - place]
        self._place = end
        return len(found)

    def read(self, size: int = -1) -> bytes:
        """By which h5py knows a file; it reads with `readinto`."""
        raise io.UnsupportedOperation("read")

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        self._place = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._end}[whence]
        return self._place

    def tell(self) -> int:
        return self._place

    def truncate(self, size: int | None = None) -> int:
        """The end moves; what lies behind it is cut off when the file is published."""
        self._end = self._place if size is None else size
        return self._end

    def flush(self) -> None:
        """Nothing: nothing is kept back."""
