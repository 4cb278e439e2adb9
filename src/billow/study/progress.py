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
    console = console or Console(highlight=False)
    started, earlier = time.monotonic(), 0  # runs of earlier calls took none of this one's time

    def time_to_go(event: ProgressEvent) -> str:
        made = event.done - earlier
        return clock((time.monotonic() - started) / made * (event.total - event.done)) if made else "-:--"

    def line(event: ProgressEvent) -> None:
        nonlocal started, earlier
        if event.status == "started":
            started, earlier = time.monotonic(), event.done
        if event.status in ("started", "finished"):
            took = f" in {clock(event.seconds)}" if event.status == "finished" else ""
            held = f"; a worker held at most {event.memory:.0f} MB" if event.memory else ""
            text = f"study {event.status}: {event.message}{took}{held}"
        else:
            message = f": {event.message}" if event.message else f" in {event.seconds:.1f} s"
            elapsed = f"elapsed {clock(time.monotonic() - started)}, ETA {time_to_go(event)}"
            text = f"[{event.done}/{event.total}] run {event.run} {event.status}{message}; {elapsed}"
        console.print(text, markup=False, soft_wrap=True)

    if not console.is_terminal:
        yield line
        return
    columns = (TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TextColumn("elapsed"), TimeElapsedColumn())
    with Progress(*columns, TextColumn("ETA {task.fields[eta]}"), console=console) as bar:
        task = bar.add_task("runs", total=None, eta="-:--")

        def show(event: ProgressEvent) -> None:
            if event.status != "completed":  # lines above the bar for what is not routine
                line(event)
            bar.update(task, total=event.total, completed=event.done, eta=time_to_go(event))

        yield show


def clock(seconds: float) -> str:
    """Time for people: 75.0 s is "1:15", 3,700 s "1:01:40"."""
    minutes, second = divmod(round(seconds), 60)
    hour, minute = divmod(minutes, 60)
    return f"{hour}:{minute:02d}:{second:02d}" if hour else f"{minute}:{second:02d}"
