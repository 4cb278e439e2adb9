"""Whose a folder is: the mark that Billow made it, and the lock of the process that writes to it.

A folder that Billow made holds a file billow.lock. Whoever writes to the folder keeps it locked (flock), and the file
says who that is. The operating system ends the lock with its process, however that ends: what a killed process leaves
behind blocks nobody. Nothing is removed or replaced in a folder without the mark.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import shlex
import shutil
import socket
import stat
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from billow.base.errors import Concern, InputError

IN_USE = InputError.declare(
    "E-RES-023",
    "another process is writing there",
    where="{path}",
    why="it belongs to {owner}",
    cause="a command that was given twice",
    remedy="wait for it to end, or stop it; or choose another place with --out",
)
NOT_OURS = InputError.declare(
    "E-RES-024",
    "what lies there was not made by Billow",
    where="{path}",
    cause="a folder or file of yours has the name that a result, or the work on one, would have",
    remedy="choose another place with --out, or move what is there away",
)
NO_LOCKS = Concern.declare(
    "W-RES-001",
    "this folder cannot be locked",
    where="{path}",
    why="{problem}; a second command that writes to it would not be noticed",
    cause="a network file system that is mounted without locks",
    remedy="give each command its own --out; ask the administrator for flock, or write to a local disk",
)

LONGEST_END = 20_000
"""Bytes at the end of a file that may say who made it: PDF and MP4 say so there."""
LOCK = "billow.lock"
MARK = "Made by Billow.\n"
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
"""What file systems without locks answer."""


@contextlib.contextmanager
def owned(folder: str | Path, *known: str) -> Iterator[None]:
    """Be the only process that writes to a folder, which is made if need be, and marked.

    known: files that tell a folder of Billow's without a mark, made by an earlier version. A folder that is empty may
    be marked too. InputError E-RES-023: another process writes to it; -024: it is somebody else's. OSError.
    """
    folder = Path(folder)
    was_there = folder.exists() and not is_ours(folder, *known)
    while True:
        folder.mkdir(parents=True, exist_ok=True)
        # In this order: another process may mark an empty folder at this moment, and then write to it.
        if any(name != LOCK for name in os.listdir(folder)) and not is_ours(folder, *known):
            raise NOT_OURS(path=folder, why=f"it is not empty, and {LOCK}, the mark of Billow's folders, is missing")
        with contextlib.suppress(FileNotFoundError):  # its owner ended at this moment and removed it
            handle = _locked(folder / LOCK, folder)
            break
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            os.ftruncate(handle, len(MARK))
            if os.listdir(folder) == [LOCK]:  # nothing came of it
                (folder / LOCK).unlink()
                if not was_there:
                    folder.rmdir()
        os.close(handle)


@contextlib.contextmanager
def owned_file(path: str | Path, sign: bytes) -> Iterator[None]:
    """The same for a single file that is to be written: the lock lies beside it while the block lasts.

    sign: what a file of this kind holds near its beginning or its end if Billow made it; only such a file may be
    replaced.
    """
    path = Path(path)
    lock = path.parent / f".{path.name}.lock"
    if os.path.lexists(path):
        if path.is_symlink() or not path.is_file():
            raise NOT_OURS(path=path, why="it is a link, a folder or a device")
        with open(path, "rb") as file:
            head = file.read(1000)
            file.seek(max(0, path.stat().st_size - LONGEST_END))
            if sign not in head and sign not in file.read(LONGEST_END):
                raise NOT_OURS(path=path, why="it is no earlier output of this command, and would be replaced")
    handle = _locked(lock, path)
    try:
        yield
    finally:
        lock.unlink(missing_ok=True)
        os.close(handle)


def in_use(folder: Path) -> bool:
    """Whether a process writes to a folder now; False where that cannot be known."""
    try:
        handle = os.open(folder / LOCK, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return False
    except BlockingIOError:
        return True
    except OSError:  # a disk without locks
        return False
    finally:
        os.close(handle)


def is_ours(folder: Path, *known: str) -> bool:
    """Whether Billow made a folder: it has the mark, or one of the files `known`, and is no link."""
    return any((folder / name).is_file() for name in (LOCK, *known))


def mark(folder: Path) -> None:
    """Mark a folder that Billow just made."""
    (folder / LOCK).write_text(MARK, encoding="utf-8")


def clear(folder: Path) -> None:
    """Remove all that is in a folder of Billow's but its mark."""
    for path in folder.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif path.name != LOCK:
            path.unlink()


def discard(folder: Path, *known: str) -> None:
    """Remove a folder if it is Billow's; anything else, also a link to one, stays as it is.

    The mark goes last, so that a removal that is cut short can be continued. A folder that cannot be removed stays.
    """
    if folder.is_symlink() or not is_ours(folder, *known):
        return
    with contextlib.suppress(OSError):
        (folder / LOCK).touch()
        clear(folder)
        (folder / LOCK).unlink(missing_ok=True)
        folder.rmdir()


def _locked(path: Path, what: Path) -> int:
    """A handle of the lock file, locked, with a note of who holds it. what: the folder or file it is for."""
    tries = 0
    while True:
        tries += 1
        try:
            handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
        except OSError as error:
            if error.errno in (errno.ELOOP, errno.EISDIR, errno.ENXIO):
                raise NOT_OURS(path=path, why="it is a link, a folder or a device, and no lock of Billow's") from error
            raise
        try:
            _take(handle, path, what)
            # The file may have been removed, or its folder renamed, since it was opened: then the lock means nothing.
            # Some network disks give a file another number each time it is asked for.
            if tries > 100 or (os.path.lexists(path) and os.path.samestat(os.fstat(handle), os.lstat(path))):
                os.ftruncate(handle, 0)
                os.pwrite(handle, f"{MARK}{_whoami()}\n".encode("utf-8", "replace"), 0)
                return handle
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)


def _take(handle: int, path: Path, what: Path) -> None:
    """Lock the file behind a handle. InputError E-RES-023, -024."""
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        raise NOT_OURS(path=path, why="it is no plain file, and no lock of Billow's")
    if not (said := _note(handle)).startswith(MARK[: len(said)]):
        raise NOT_OURS(path=path, why="its content is not that of a lock of Billow's")
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        for _ in range(100):  # its owner may not have written who it is yet
            if len(said := _note(handle)) > len(MARK):
                break
            time.sleep(0.01)
        raise IN_USE(path=what, owner=said[len(MARK) :].strip() or "a process that does not say who it is") from error
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise
        print(NO_LOCKS(path=what, problem=error.strerror), file=sys.stderr)


def _note(handle: int) -> str:
    return os.pread(handle, 1000, 0).decode("utf-8", "replace")


def _whoami() -> str:
    """Number, computer, start and command of this process."""
    command = shlex.join([Path(sys.argv[0]).name or "python", *sys.argv[1:]])[:300]
    return f"process {os.getpid()} on {socket.gethostname()} since {time.strftime('%Y-%m-%d %H:%M:%S')}: {command}"
