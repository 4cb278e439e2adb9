"""Files and folders that appear whole or not at all.

A reader never sees a half-written file: data go to a temporary name beside the target, reach the disk (`fsync`), and
only then take the target's name, which the operating system does in one step.
"""

from __future__ import annotations

import contextlib
import os
import shlex
import uuid
from collections.abc import Iterator
from pathlib import Path

from billow.base.errors import InputError, ResourceError
from billow.results.ownership import LOCK, NOT_OURS, clear, owned

FOLDER_EXISTS = InputError.declare(
    "E-RES-009",
    "the result folder exists already",
    where="{folder}",
    cause="it holds an earlier result, or is the working folder, a mount point or a link",
    remedy="choose another folder with --out; it is made, and must not exist yet",
)
INTERRUPTED_RUN_EXISTS = InputError.declare(
    "E-RES-022",
    "the folder belongs to an interrupted run",
    where="{folder}",
    why="it has {kept}; starting over would lose it",
    cause="the command of an interrupted run was given again",
    remedy="continue it: billow resume {final}; or delete {name}",
)
UNUSABLE_NAME = InputError.declare(
    "E-RES-025",
    "no result can have this place",
    where="{folder}",
    cause="a path that ends in .., or one inside a folder that Billow is still writing",
    remedy="choose another folder with --out",
)
NOT_WRITTEN = ResourceError.declare(
    "E-RES-020",
    "the results could not be written",
    where="{folder}",
    cause="a full disk, or a folder without permission to write",
    remedy="check permissions and free space, then give the same command again",
)

PARTIAL = ".partial"
"""What the name of a folder ends in while its result is being made."""
CHECKPOINTS = ("checkpoint_a.safetensors", "checkpoint_b.safetensors")
KEPT = (*CHECKPOINTS, "run.json")
"""Files of an unfinished run that no other command may remove."""


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
    temporary = path.parent / f".{path.name}.{uuid.uuid4().hex[:12]}.partial"
    try:
        with open(temporary, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            temporary.unlink()
        if isinstance(error, OSError):  # a full disk does not say which file it was
            error.filename = str(path)
        raise
    sync(path.parent)


def new_place(final: str | Path) -> Path:
    """The full path of a folder that is to be made, settled before hours are spent on what will be in it.

    InputError E-RES-009 if something is there, other than an empty folder; -025 if nothing can be. OSError.
    """
    final = Path(final)
    if os.path.lexists(final):
        if why := _why_taken(final):
            raise FOLDER_EXISTS(folder=final.absolute(), why=why)
        final = Path(os.path.realpath(final))
    if final.name in ("", ".."):
        raise UNUSABLE_NAME(folder=final, why="its last part is no name")
    final = Path(os.path.realpath(final.parent), final.name)
    for above in final.parents:
        if above.name.endswith(PARTIAL) and (above / LOCK).is_file():
            raise UNUSABLE_NAME(folder=final, why=f"{above} is a result that is not finished")
    return final


def _why_taken(final: Path) -> str:
    """Why a result cannot take the place of what is there; empty for a plain, empty folder, which a rename replaces."""
    if final.is_symlink():
        return "it is a link"
    if not final.is_dir():
        return "it is no folder"
    if any(final.iterdir()):
        return "it is not empty; a published result is never overwritten"
    if os.path.ismount(final):
        return "a disk is mounted there; a folder on that disk can be used"
    here = Path.cwd()
    if any(final.samefile(folder) for folder in (here, *here.parents)):
        return "it is the folder that you are in, which would be replaced"
    return ""


@contextlib.contextmanager
def unfinished(final: Path) -> Iterator[Path]:
    """`final`.partial, the folder for work on a result, locked while the block lasts; what is in it then stays.

    final: from `new_place`. InputError E-RES-009 if `final` is there by now; E-RES-023 and -024 as `owned`.
    """
    partial = final.with_name(final.name + PARTIAL)
    if partial.is_symlink() or (partial.exists() and not partial.is_dir()):
        raise NOT_OURS(path=partial, why="it is a link or a file, and the work on the result needs a folder there")
    with owned(partial, *KEPT):
        if os.path.lexists(final) and (why := _why_taken(final)):
            raise FOLDER_EXISTS(folder=final, why=why)
        yield partial


def require_nothing_kept(partial: Path, final: Path) -> None:
    """InputError E-RES-022 if `partial` holds something of an interrupted run that cannot be made again at once."""
    there = [name for name in KEPT if (partial / name).exists()]
    if there:
        kept = "a checkpoint" if there[0] in CHECKPOINTS else "finished results"
        raise INTERRUPTED_RUN_EXISTS(folder=partial, kept=kept, final=shlex.quote(str(final)), name=partial.name)


@contextlib.contextmanager
def new_folder(final: str | Path) -> Iterator[Path]:
    """A folder to fill, which gets the name `final` at the end of the block and is emptied if that fails.

    Errors as `new_place`, `unfinished`, `require_nothing_kept` and `publish_folder`.
    """
    final = new_place(final)
    with unfinished(final) as partial:
        require_nothing_kept(partial, final)
        clear(partial)  # of an earlier try that was killed
        try:
            yield partial
        except BaseException:
            clear(partial)
            raise
        publish_folder(partial, final)


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
        if not os.path.lexists(final):
            raise
        why, remedy = "it was made while the result was being written", f"the result is whole: rename {partial}"
        raise FOLDER_EXISTS(folder=final, why=why, remedy=remedy) from error
    (final / LOCK).unlink(missing_ok=True)
    sync(final.parent)
