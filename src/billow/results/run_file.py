"""run.json: what a run was, how it ended, and the SHA-256 of every file beside it.

A run exists only when its run.json verifies: each file listed is there with the contents it had when the run was
published, and run.json itself is unchanged (`record_sha256`, over its other entries).
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np

from billow.base.errors import InputError, IntegrityError, shown
from billow.base.input_file import LARGEST_TABLE, read_bytes
from billow.results.atomic import write_atomically
from billow.results.ownership import LOCK

COPY_AGAIN = "copy the folder again from its source, or run the case again: billow run CASE.toml --out RUN"
"""What helps against a damaged run."""

NO_SUCH_RUN = InputError.declare(
    "E-RES-001",
    "there is no such run",
    where="{folder}",
    why="the folder does not exist",
    remedy="give the folder that `billow run` wrote",
)
NOT_A_FINISHED_RUN = IntegrityError.declare(
    "E-RES-002",
    "the folder holds no finished run",
    where="{folder}",
    why="run.json, written when a run ends, is missing",
    cause="it is another folder, or the .partial folder of a run that was interrupted",
    remedy="give the folder of a finished run; continue an interrupted one: billow resume RUN",
)
RUN_FILE_DAMAGED = IntegrityError.declare(
    "E-RES-003",
    "run.json is damaged",
    where="{path}",
    cause="a copy that was cut short, or an edit by hand",
    remedy=COPY_AGAIN,
)
FILE_CHANGED = IntegrityError.declare(
    "E-RES-004",
    "a file of the run was changed after the run ended",
    where="{path}",
    why="its SHA-256 begins {measured}, run.json says {expected}",
    cause="a copy that was cut short, a bad disk, or an edit by hand",
    remedy=COPY_AGAIN,
)
FILE_MISSING = IntegrityError.declare(
    "E-RES-005",
    "a file of the run is missing",
    where="{path}",
    why="run.json lists it",
    cause="it was deleted, or not copied",
    remedy=COPY_AGAIN,
)
UNKNOWN_FORMAT = IntegrityError.declare(
    "E-RES-006",
    "run format {format} is not known",
    where="{path}",
    why="this version of Billow reads formats up to {known}",
    cause="the run was made with a newer version of Billow",
    remedy="use the version of Billow that the file names as billow_version",
)

FORMAT = 2
READABLE = (1, 2)
"""Frames of format 1 call the gauge pressure `pressure`."""
RUN_FILE = "run.json"
STATUSES = ("completed", "stopped", "interrupted")
FILES = ("case.toml", "fabric.vtkhdf", "histories.csv")
"""Files that every run has."""


def file_sha256(path: Path) -> str:
    """SHA-256 of a file's contents, hexadecimal."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _plain(value):
    """JSON's own types; a number that is not finite becomes null, which JSON can say."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value


def _record_sha256(record: dict) -> str:
    text = json.dumps({k: v for k, v in record.items() if k != "record_sha256"}, sort_keys=True, ensure_ascii=True)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def write_run_file(folder: str | Path, record: dict, without: Collection[str] = ()) -> None:
    """Write `folder`/run.json, atomically, as the last file of a run.

    record: at least "status" ("completed", "stopped", "interrupted"), "reason" (text or None), "case_digest" (SHA-256,
    hexadecimal), "wall_seconds" [s] and "ledger" (name -> float). Added are "format", "files" (name -> SHA-256 of every
    file now in the folder, except those named in `without`) and "record_sha256".
    FileNotFoundError if one of `FILES` is missing.
    """
    folder = Path(folder)
    present = {path.name for path in folder.iterdir() if path.is_file()}
    names = sorted((present | set(FILES)) - {RUN_FILE, LOCK, *without})
    record = _plain({"format": FORMAT, **record, "files": {name: file_sha256(folder / name) for name in names}})
    record["record_sha256"] = _record_sha256(record)
    write_atomically(folder / RUN_FILE, json.dumps(record, indent=2, allow_nan=False) + "\n")


def read_run_file(folder: str | Path, verify: bool = True) -> dict:
    """The record of a run.

    verify: also hash every file listed (reads the whole run; False leaves only run.json itself checked).
    InputError E-RES-001: no such folder. IntegrityError E-RES-002: no run.json; -003: run.json is damaged;
    -004: a file changed since the run was published; -005: a file is missing; -006: written by a newer Billow.
    """
    folder = Path(folder)
    path = folder / RUN_FILE
    if not folder.is_dir():
        raise NO_SUCH_RUN(folder=folder)
    if not path.is_file():
        raise NOT_A_FINISHED_RUN(folder=folder)
    try:
        record = json.loads(read_bytes(path, LARGEST_TABLE))
        intact = record["record_sha256"] == _record_sha256(record)
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        intact = False
    if not intact:
        raise RUN_FILE_DAMAGED(path=path, why="its contents do not match the checksum it carries")
    if record.get("format") not in READABLE:
        raise UNKNOWN_FORMAT(format=shown(record.get("format")), path=path, known=FORMAT)
    if not _is_record(record):
        raise RUN_FILE_DAMAGED(path=path, why="an entry is missing or has the wrong type")
    if verify:
        for name, expected in record["files"].items():
            if not (folder / name).is_file():
                raise FILE_MISSING(path=folder / name)
            measured = file_sha256(folder / name)
            if measured != expected:
                raise FILE_CHANGED(path=folder / name, measured=measured[:8], expected=expected[:8])
    return record


def _is_record(record: dict) -> bool:
    files, seconds, obstacles = record.get("files"), record.get("wall_seconds"), record.get("obstacles", [])
    of_processors = record.get("processor_seconds", seconds)
    return (
        record.get("status") in STATUSES
        and isinstance(record.get("case_digest"), str)
        and isinstance(record.get("ledger"), dict)
        and isinstance(obstacles, list)
        and all(isinstance(shape, dict) and isinstance(shape.get("name"), str) for shape in obstacles)
        and all(isinstance(shape.get("locked"), bool) for shape in obstacles)
        and isinstance(seconds, int | float)
        and isinstance(of_processors, int | float)
        and isinstance(files, dict)
        and set(FILES) <= set(files)
        # Names of files in the folder itself: a record cannot point elsewhere.
        and all(name == Path(name).name and isinstance(sha256, str) for name, sha256 in files.items())
    )
