"""Progress of a study: a bar on a terminal, plain lines in a log.

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
    """A function for `Study.run` to call. console: standard output by default."""
    console, pace = console or Console(highlight=False), _Pace()

    def line(event: ProgressEvent) -> None:
        pace.see(event)
        console.print(_text(event, pace), markup=False, soft_wrap=True)

    if not console.is_terminal:
        yield line
        return
    columns = (
        TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TextColumn("elapsed"), TimeElapsedColumn(),
        TextColumn("ETA {task.fields[eta]}"),
    )  # fmt: skip
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("runs", total=None, eta="-:--")

        def show(event: ProgressEvent) -> None:
            if event.status != "completed":  # lines above the bar for what is not routine
                line(event)
            bar.update(task, total=event.total, completed=event.done, eta=pace.eta(event))

        yield show


def clock(seconds: float) -> str:
    """Time for people: 75.0 s is "1:15", 3,700 s "1:01:40"."""
    minutes, second = divmod(round(seconds), 60)
    hour, minute = divmod(minutes, 60)
    return f"{hour}:{minute:02d}:{second:02d}" if hour else f"{minute}:{second:02d}"


class _Pace:
    """Elapsed time and the time still to go, from the runs of this call only: earlier ones took none of its time."""

    def __init__(self):
        self._started, self._first = time.monotonic(), 0

    def see(self, event: ProgressEvent) -> None:
        if event.status == "started":
            self._started, self._first = time.monotonic(), event.done

    def elapsed(self) -> float:
        return time.monotonic() - self._started

    def eta(self, event: ProgressEvent) -> str:
        made = event.done - self._first
        return clock(self.elapsed() / made * (event.total - event.done)) if made else "-:--"


def _text(event: ProgressEvent, pace: _Pace) -> str:
    if event.status in ("started", "finished"):
        took = f" in {clock(event.seconds)}" if event.status == "finished" else ""
        return f"study {event.status}: {event.message}{took}"
    message = f": {event.message}" if event.message else f" in {event.seconds:.1f} s"
    return (
        f"[{event.done}/{event.total}] run {event.run} {event.status}{message}; "
        f"elapsed {clock(pace.elapsed())}, ETA {pace.eta(event)}"
    )
