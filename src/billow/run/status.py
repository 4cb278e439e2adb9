"""How far a run is, for whoever looks at it while it goes on: status.json in the folder of the run, and whatever screen
there is. It goes with the run; what remains is run.json."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Mapping
from pathlib import Path

from billow.results.atomic import write_atomically
from billow.results.journal import STATUS, Journal

EVERY = 1.0
"""[s] of wall time between two statuses."""


class Status:
    """The latest status of a run. what: about the run, which stays; journal: written out with each status, so that
    histories can be read too."""

    def __init__(self, folder: Path, what: Mapping[str, object], end: float, journal: Journal):
        self.path, self.what, self.end, self.journal = folder / STATUS, dict(what), end, journal
        self.begun = time.perf_counter()
        self.start: float | None = None
        self.told = float("-inf")

    @property
    def due(self) -> bool:
        return time.perf_counter() - self.told >= EVERY

    def tell(self, now: float, step: int, values: Mapping[str, float]) -> dict:
        """Write the status and return it. now: time of the run [s]; values: the latest row of histories, by column."""
        self.told = time.perf_counter()
        if self.start is None:
            self.start = now  # a resumed run has made the rest before
        spent, made = self.told - self.begun, now - self.start
        status = {
            "status": "running",
            **self.what,
            "time_s": now,
            "end_s": self.end,
            "step": step,
            "wall_seconds": spent,
            "seconds_to_go": spent * (self.end - now) / made if made > 0.0 else None,
            "values": dict(values),
        }
        self.journal.flush()
        with contextlib.suppress(OSError):  # of a full disk the journal says more; a run needs no status
            write_atomically(self.path, json.dumps(_plain(status), allow_nan=False) + "\n")
        return status

    def end_it(self) -> None:
        self.path.unlink(missing_ok=True)


def _plain(value):
    """Without numbers that JSON does not have."""
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    return None if isinstance(value, float) and value - value != 0.0 else value
