"""Files and folders that appear whole or not at all.

A reader never sees a half-written file: data go to a temporary name beside the target, reach the disk (`fsync`), and
only then take the target's name, which the operating system does in one step.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import uuid
from collections.abc import Iterator
from pathlib import Path

from billow.base.errors import InputError

FOLDER_EXISTS = InputError.declare(
    "E-RES-009",
    "the result folder exists already",
    where="{folder}",
    why="a published result is never overwritten",
    remedy="choose another folder, with --out at the command line, or delete this one",
)


def sync(path: Path) -> None:
    """Make the contents of a file, or the names in a folder, survive a power cut."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_atomically(path: str | Path, data: str | bytes) -> None:
    """Write `data` (text as UTF-8) to `path`; on any error the old contents of `path`, if any, are untouched."""
    path = Path(path)
    if isinstance(data, str):
        data = data.encode("utf-8")
    # Two writers of one path must not share a temporary file: the name is unique.
    temporary = path.with_name(f".{path.name}.{uuid.uuid4().hex[:12]}.partial")
    try:
        with open(temporary, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise
    sync(path.parent)


@contextlib.contextmanager
def whole_folder(final: str | Path) -> Iterator[Path]:
    """A folder to fill, which gets the name `final` at the end of the block and vanishes if that fails.

    Errors as `publish_folder`.
    """
    final = Path(final)
    partial = final.with_name(f"{final.name}.{uuid.uuid4().hex[:12]}.partial")
    partial.mkdir(parents=True)
    try:
        yield partial
        publish_folder(partial, final)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def publish_folder(partial: str | Path, final: str | Path) -> None:
    """Give the finished folder `partial` its final name, everything in it safely on disk.

    Both must lie on one file system. InputError E-RES-009 if `final` exists and is not empty; `partial` then stays.
    """
    partial, final = Path(partial), Path(final)
    for folder, _, files in os.walk(partial, topdown=False):
        for name in files:
            sync(Path(folder, name))
        sync(Path(folder))
    try:
        os.rename(partial, final)
    except OSError as error:
        if not final.exists():
            raise
        raise FOLDER_EXISTS(folder=final) from error
    sync(final.parent)
