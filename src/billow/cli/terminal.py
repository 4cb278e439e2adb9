"""Progress of long work: a bar on a terminal, plain lines in a log."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

QUIET_SECONDS = 5.0
"""Least time [s] between two plain lines."""


@contextlib.contextmanager
def epochs(console: Console, title: str) -> Iterator[Callable[[int, int, float], None]]:
    """A function (epoch, epochs, loss) for training to call."""
    if console.is_terminal:
        columns = (TextColumn(title), BarColumn(), MofNCompleteColumn(), TextColumn("loss {task.fields[loss]:.2e}"))
        with Progress(*columns, TimeElapsedColumn(), TimeRemainingColumn(), console=console) as bar:
            task = bar.add_task(title, total=None, loss=float("nan"))
            yield lambda epoch, total, loss: bar.update(task, completed=epoch, total=total, loss=loss)
        return
    spoken = time.monotonic() - QUIET_SECONDS

    def line(epoch: int, total: int, loss: float) -> None:
        nonlocal spoken
        if epoch == total or time.monotonic() - spoken >= QUIET_SECONDS:
            spoken = time.monotonic()
            console.print(f"{title}: epoch {epoch} of {total}, loss {loss:.2e}", markup=False, highlight=False)

    yield line


@contextlib.contextmanager
def steps(console: Console) -> Iterator[Callable[[int, int, str], None]]:
    """A function (done, total, what) for evaluation to call."""
    if not console.is_terminal:
        yield lambda done, total, what: console.print(f"[{done}/{total}] {what}", markup=False, highlight=False)
        return
    with Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), console=console) as bar:
        task = bar.add_task("evaluation", total=None)
        yield lambda done, total, what: bar.update(task, completed=done, total=total, description=what)
