"""How a run is asked to save itself or to stop: signals and a STOP file.

    Ctrl-C, SIGTERM, SIGHUP (the terminal was closed), SIGXCPU (the processor time that a queue allows is used up), or a
    file named STOP in the run's .partial folder: save a checkpoint and stop
    SIGUSR2: save a checkpoint and go on

Signals only set a flag; the run acts on it between two steps, when its state is whole. A signal that is ignored, as
SIGHUP is under nohup, stays so.
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
            stop = dict.fromkeys(("SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU"), "stop")
            for name, flag in {**stop, "SIGUSR2": "save"}.items():
                number = getattr(signal, name, None)  # not every system has all of them
                if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
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
