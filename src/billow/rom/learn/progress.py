"""Progress of long work: of one training, of several in a row, of named pieces."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

Progress = Callable[..., None]
"""Called as progress(epoch, epochs, loss) after every epoch; loss is the mean square of standardised errors: [-]. With
several trainings in a row, a fourth argument says which one the loss belongs to: it starts anew in each."""

Announcement = Callable[[int, int, str], None]
"""Called as announce(done, total, what) before each piece of work."""

EPOCHS_BETWEEN = 250
"""Epochs between two announcements from inside a piece: only the paper's recipe trains so long."""


def stages(progress: Progress | None, count: int) -> Iterator[Progress | None]:
    """What each of `count` trainings in a row reports to, so that together they look like one."""

    def inside(before: int, epoch: int, epochs: int, loss: float) -> None:
        progress(before * epochs + epoch, count * epochs, loss, f"training {before + 1} of {count}")

    return (progress and partial(inside, before) for before in range(count))


class Announcer:
    """Announces the next piece of work, and turns the progress inside that piece into announcements."""

    def __init__(self, announce: Announcement | None, total: int):
        self._announce, self._done, self._total = announce or (lambda done, total, what: None), 0, total

    def __call__(self, what: str) -> Progress:
        done, self._done = self._done, self._done + 1
        self._announce(done, self._total, what)

        def inside(epoch: int, epochs: int, loss: float, which: str = "") -> None:
            if epoch % EPOCHS_BETWEEN == 0:
                self._announce(done, self._total, f"{what}: epoch {epoch:,} of {epochs:,}")

        return inside
