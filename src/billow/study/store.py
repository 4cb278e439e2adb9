"""Run folders of a study, of which any process may die at any moment (docs/architecture.md, Study and dataset)."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import shutil
import socket
import uuid
from collections.abc import Iterator
from pathlib import Path

from billow.base.errors import BillowError, InputError
from billow.results.atomic import publish_folder, sync, write_atomically

ANOTHER_PROCESS = InputError.declare(
    "E-STU-013",
    "another process is running this study",
    where="{folder}",
    why="study.lock is held by {holder}",
    cause="the command was given twice",
    remedy="wait for it, or stop it; the study can then be continued",
)


class RunStore:
    """The run folders under one study folder."""

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
        self.runs, self.failed, self.work = (self.folder / name for name in ("runs", "failed", "work"))

    @contextlib.contextmanager
    def driving(self) -> Iterator[None]:
        """Be the only process that drives this study, and remove unfinished work of a dead one.

        InputError E-STU-013 if another process drives it. The lock ends with the process, however that ends.
        """
        with open(self.folder / "study.lock", "a+", encoding="utf-8") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                lock.seek(0)
                raise ANOTHER_PROCESS(folder=self.folder, holder=lock.read().strip() or "it") from error
            lock.truncate(0)
            lock.write(f"process {os.getpid()} on {socket.gethostname()}")
            lock.flush()
            for leftover in (self.work, *self.runs.glob("*.partial")):
                shutil.rmtree(leftover, ignore_errors=True)
            for folder in (self.runs, self.failed, self.work):
                folder.mkdir(exist_ok=True)
            yield

    def begin(self, run: str) -> Path:
        """A new folder for one attempt at `run`; it stays behind if the attempt dies."""
        attempt = self.work / f"{run}-{uuid.uuid4().hex[:12]}"
        attempt.mkdir()
        return attempt

    def dead_attempts(self, run: str) -> int:
        """How many attempts at `run` were begun and ended in neither a run nor an error."""
        return sum(1 for _ in self.work.glob(f"{run}-*"))

    def is_published(self, run: str) -> bool:
        """True if `run` has a folder in runs/, whether or not it verifies."""
        return (self.runs / run).is_dir()

    def publish(self, run: str, finished: Path) -> None:
        """Make `finished` the folder of `run`; if another attempt was faster, its folder stays."""
        with contextlib.suppress(InputError):
            publish_folder(finished, self.runs / run)

    def keep_stopped(self, run: str, stopped: Path) -> None:
        """Keep the folder of a stopped run, replacing that of an earlier one."""
        shutil.rmtree(self.failed / run, ignore_errors=True)
        with contextlib.suppress(InputError):
            publish_folder(stopped, self.failed / run)

    def set_aside(self, run: str) -> Path:
        """Move a published run that no longer verifies out of the way; returns where it went."""
        shelf = self.folder / "set_aside"
        shelf.mkdir(exist_ok=True)
        number = 1
        while (place := shelf / f"{run}-{number}").exists():
            number += 1
        os.rename(self.runs / run, place)
        sync(shelf)
        return place

    def record_failure(self, run: str, error: BillowError, attempts: int) -> None:
        """Write failed/<run>.json, atomically."""
        parts = {name: getattr(error, name) for name in ("code", "what", "where", "why", "remedy")}
        text = json.dumps({"run": run, **parts, "attempts": attempts}, indent=2)
        write_atomically(self.failed / f"{run}.json", text + "\n")

    def forget_failure(self, run: str) -> None:
        """Remove the record of a failure once the run is completed."""
        (self.failed / f"{run}.json").unlink(missing_ok=True)
        shutil.rmtree(self.failed / run, ignore_errors=True)
