"""Showing how a study gets on: a bar on a terminal, plain lines in a log.

with study_progress() as report:
    study.run(progress=report)
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from billow.study.drive import ProgressEvent


@contextlib.contextmanager
def study_progress(console: Console | None = None) -> Iterator[Callable[[ProgressEvent], None]]:
    """A function to hand to `Study.run`. console: standard output by default."""
    console = console or Console(highlight=False)
    if not console.is_terminal:
        yield _Lines(console)
        return
    columns = (
        TextColumn("runs"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("elapsed"),
        TimeElapsedColumn(),
        TextColumn("ETA {task.fields[eta]}"),
    )
    with Progress(*columns, console=console) as bar:
        yield _Bar(bar)


def clock(seconds: float) -> str:
    """Time for people: 75.0 s is "1:15", 3,700 s "1:01:40"."""
    minutes, second = divmod(round(seconds), 60)
    hour, minute = divmod(minutes, 60)
    return f"{hour}:{minute:02d}:{second:02d}" if hour else f"{minute}:{second:02d}"


class _Pace:
    """Elapsed time and the time still to go, from the runs of this call alone: earlier ones took no time of it."""

    def __init__(self):
        self._started, self._first = time.monotonic(), 0

    def start(self, done: int) -> None:
        self._started, self._first = time.monotonic(), done

    def elapsed(self) -> str:
        return clock(time.monotonic() - self._started)

    def eta(self, done: int, total: int) -> str:
        made = done - self._first
        return clock((time.monotonic() - self._started) / made * (total - done)) if made else "-:--"


class _Lines:
    """One line an event: what a batch log wants."""

    def __init__(self, console: Console):
        self._console, self._pace = console, _Pace()

    def __call__(self, event: ProgressEvent) -> None:
        if event.status == "started":
            self._pace.start(event.done)
        self._console.print(self._line(event), markup=False, soft_wrap=True)

    def _line(self, event: ProgressEvent) -> str:
        if event.status in ("started", "finished"):
            took = f" in {clock(event.seconds)}" if event.status == "finished" else ""
            return f"study {event.status}: {event.message}{took}"
        message = f": {event.message}" if event.message else f" in {event.seconds:.1f} s"
        pace = f"elapsed {self._pace.elapsed()}, ETA {self._pace.eta(event.done, event.total)}"
        return f"[{event.done}/{event.total}] run {event.run} {event.status}{message}; {pace}"


class _Bar:
    """One bar for the study; lines above it for what is not routine."""

    def __init__(self, bar: Progress):
        self._bar, self._pace, self._lines = bar, _Pace(), _Lines(bar.console)
        self._task = None

    def __call__(self, event: ProgressEvent) -> None:
        if event.status == "started":
            self._pace.start(event.done)
            self._task = self._bar.add_task("runs", total=event.total, eta="-:--")
        if event.status != "completed":
            self._lines(event)
        if self._task is not None:
            eta = self._pace.eta(event.done, event.total)
            self._bar.update(self._task, completed=event.done, eta=eta)
