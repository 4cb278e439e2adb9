"""Files of users: opened only if they are regular files of a bounded size, and read as text in a few encodings.

Text is UTF-8, UTF-16 or UTF-32 where a byte order mark says so, else Windows-1252 (which contains Latin-1). Lines end
in LF, CRLF or CR. docs/input_files.md states the rules for users.
"""

from __future__ import annotations

import codecs
import os
import re
import stat
from pathlib import Path

LARGEST_TEXT = 1_000_000
"""Bytes of a case, study or tank case; they are a few kilobytes."""
LARGEST_TABLE = 50_000_000
"""Bytes of a CSV file: a million nodes, or a trace of 10 s at 100 kHz."""
LARGEST_DATA = 2_000_000_000
"""Bytes of a mesh or of the frames of a run; a frame of a million triangles takes 50 MB."""

_BLOCK = 2**20

_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32"),  # before UTF-16, whose mark begins alike
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (codecs.BOM_UTF8, "utf-8"),
)
_NO_TEXT = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")
_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (lambda mode: stat.S_ISCHR(mode) or stat.S_ISBLK(mode), "a device"),
)


def require_file(path: str | Path, largest: int) -> int:
    """The size of a regular file, in bytes. OSError, with a sentence, if it is something else or larger than that."""
    try:
        found = os.stat(path)
    except ValueError:
        raise OSError("no file can have this path") from None
    if not stat.S_ISREG(found.st_mode):
        kind = next((name for is_kind, name in _KINDS if is_kind(found.st_mode)), "something else")
        raise OSError(f"it is {kind}, not a file")
    if found.st_size > largest:
        raise OSError(f"it has {found.st_size} bytes; at most {largest} are read")
    return found.st_size


def read_bytes(path: str | Path, largest: int) -> bytes:
    """The content of a regular file. OSError, with a sentence, if it cannot be read or is larger than `largest`."""
    require_file(path, largest)
    content = bytearray()
    with open(path, "rb") as file:
        while block := file.read(_BLOCK):  # the size of a file may be said wrongly, as in /proc
            content += block
            if len(content) > largest:
                raise OSError(f"it has more than {largest} bytes, the most that are read")
    return bytes(content)


def read_text(path: str | Path, largest: int = LARGEST_TEXT) -> str:
    """The text of a regular file, its lines ending in LF. OSError as `read_bytes`; ValueError if it is no text."""
    return decoded(read_bytes(path, largest))


def decoded(content: bytes) -> str:
    """Text of bytes, its lines ending in LF. ValueError, with a sentence that names the line, if they are no text."""
    encoding = next((name for mark, name in _MARKS if content.startswith(mark)), None)
    content = content.removeprefix(codecs.BOM_UTF8)
    try:
        text = content.decode(encoding or "utf-8")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        if encoding is not None:
            raise ValueError(
                f"line {line} is not {encoding.upper()}, as its first bytes say; save it as UTF-8"
            ) from None
        try:
            text = content.decode("cp1252")
        except UnicodeDecodeError:
            raise ValueError(f"it is not a text file: line {line} holds bytes that stand for no letter") from None
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    odd = _NO_TEXT.search(text)
    if odd is not None:
        line = text.count("\n", 0, odd.start()) + 1
        if odd[0] == "\0" and encoding is None and text.count("\0") > len(text) // 4:
            raise ValueError("it looks like UTF-16 without a byte order mark; save it as UTF-8")
        raise ValueError(f"it is not a text file: line {line} holds the control character {ord(odd[0]):#04x}")
    return text
