"""Run folders of a study, of which any process may die at any moment (docs/architecture.md, Study and dataset)."""

from __future__ import annotations

import contextlib
import json
import os
import uuid
from collections.abc import Iterator
from pathlib import Path

from billow.base.errors import BillowError, InputError
from billow.results.atomic import publish_folder, sync, write_atomically
from billow.results.ownership import NOT_OURS, discard, is_ours, mark, owned
from billow.results.run_file import RUN_FILE


class RunStore:
    """The run folders under one study folder."""

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
        names = ("runs", "failed", "work", "set_aside")
        self.runs, self.failed, self.work, self.shelf = (self.folder / name for name in names)

    @contextlib.contextmanager
    def driving(self) -> Iterator[None]:
        """Be the only process that drives this study, and remove unfinished work of a dead one.

        InputError E-RES-023 if another process drives it, E-RES-024 if one of its folders is a link: what lies behind
        one may be somebody else's, and on another disk, where no finished run can be moved in one step.
        """
        with owned(self.folder, "study.toml"):
            for folder in (self.runs, self.failed, self.work, self.shelf):
                if folder.is_symlink():
                    why, remedy = "it is a link", "move the whole study, and make a link to its folder instead"
                    raise NOT_OURS(path=folder, why=why, remedy=remedy)
            for folder in (self.runs, self.failed, self.work):
                folder.mkdir(exist_ok=True)
            for leftover in self.work.iterdir():
                discard(leftover)
            yield

    def begin(self, run: str) -> Path:
        """A new folder for one attempt at `run`; it stays behind if the attempt dies."""
        attempt = self.work / f"{run}-{uuid.uuid4().hex[:12]}"
        attempt.mkdir()
        mark(attempt)
        return attempt

    def dead_attempts(self, run: str) -> int:
        """How many attempts at `run` were begun and ended in neither a run nor an error."""
        return sum(is_ours(attempt) for attempt in self.work.glob(f"{run}-*"))

    def is_published(self, run: str) -> bool:
        """True if `run` has a folder in runs/, whether or not it verifies."""
        return (self.runs / run).is_dir()

    def publish(self, run: str, finished: Path) -> None:
        """Make `finished` the folder of `run`; if another attempt was faster, its folder stays."""
        with contextlib.suppress(InputError):
            publish_folder(finished, self.runs / run)

    def keep_stopped(self, run: str, stopped: Path) -> None:
        """Keep the folder of a stopped run, replacing that of an earlier one."""
        discard(self.failed / run, RUN_FILE)
        with contextlib.suppress(InputError):
            publish_folder(stopped, self.failed / run)

    def set_aside(self, run: str) -> Path:
        """Move a published run that no longer verifies out of the way; returns where it went."""
        self.shelf.mkdir(exist_ok=True)
        number = 1
        while os.path.lexists(place := self.shelf / f"{run}-{number}"):
            number += 1
        os.rename(self.runs / run, place)
        sync(self.shelf)
        return place

    def record_failure(self, run: str, error: BillowError, attempts: int) -> None:
        """Write failed/<run>.json, atomically."""
        parts = {name: getattr(error, name) for name in ("code", "what", "where", "why", "remedy")}
        text = json.dumps({"run": run, **parts, "attempts": attempts}, indent=2)
        write_atomically(self.failed / f"{run}.json", text + "\n")

    def forget_failure(self, run: str) -> None:
        """Remove the record of a failure once the run is completed."""
        (self.failed / f"{run}.json").unlink(missing_ok=True)
        discard(self.failed / run, RUN_FILE)
