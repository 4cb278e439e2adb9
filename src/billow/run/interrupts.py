"""How a run is asked to save itself or to stop: signals and a STOP file.

    SIGTERM, Ctrl-C, or a file named STOP in the run's .partial folder: save a checkpoint and stop
    SIGUSR2: save a checkpoint and go on

Signals only set a flag; the run acts on it between two steps, when its state is whole.
"""

from __future__ import annotations

import signal
import threading
from pathlib import Path

STOP_FILE = "STOP"


class RunInterrupted(KeyboardInterrupt):
    """The run was asked to stop; a checkpoint has been written."""


class Interrupts:
    """Listens while used as a context manager; in threads other than the main one only to the STOP file."""

    def __init__(self, folder: Path):
        self._stop_file = folder / STOP_FILE
        self.stop = self.save = False
        self._before: dict[int, object] = {}

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is threading.main_thread():
            flags = {"SIGINT": "stop", "SIGTERM": "stop", "SIGUSR2": "save"}
            for name, flag in flags.items():
                if number := getattr(signal, name, None):  # not every system has SIGUSR2
                    self._before[number] = signal.signal(number, lambda *_, flag=flag: setattr(self, flag, True))
        return self

    def __exit__(self, *_) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def look_for_stop_file(self) -> None:
        """Take notice of a STOP file, and remove it so that a resumed run goes on."""
        if self._stop_file.exists():
            self._stop_file.unlink(missing_ok=True)
            self.stop = True
