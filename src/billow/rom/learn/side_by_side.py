"""Trainings that do not depend on each other, in as many threads as there are cores: PyTorch lets go of Python while it
computes. Each has bits of its own, whatever trains beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from threading import Event, Lock
from typing import TypeVar

from billow.base.cores import available_cores
from billow.rom.learn.progress import Progress

Result = TypeVar("Result")


class _Stopped(Exception):
    """Somebody else failed, or the user had enough."""


def side_by_side(
    trainings: Iterable[Callable[[Progress], Result]], before: int, count: int, progress: Progress | None
) -> Iterator[Result]:
    """Results of trainings, in their order. Each is given what it reports its epochs to, in whatever thread it runs.

    before, count: trainings that were over before, and all, so that together they look like one, as `stages`.
    Raises what a training raises, after the others have ended their epoch.
    """
    stopped, lock, done = Event(), Lock(), 0

    def reporter(which: int) -> Progress:
        def report(_: int, epochs: int, loss: float) -> None:
            nonlocal done
            if stopped.is_set():
                raise _Stopped
            with lock:
                done += 1
                if progress is not None:
                    name = f"training {before + which + 1} of {count}"
                    progress(before * epochs + done, count * epochs, loss, name)

        return report

    with ThreadPoolExecutor(min(available_cores(), count - before)) as pool:
        try:
            waiting = [pool.submit(training, reporter(which)) for which, training in enumerate(trainings)]
            for one in waiting:
                yield one.result()
        finally:
            stopped.set()
            pool.shutdown(cancel_futures=True)
