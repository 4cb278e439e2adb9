"""What a run costs: by the clock, and of the processor, before it was resumed too."""

from __future__ import annotations

import time
from typing import NamedTuple


class Spent(NamedTuple):
    """By the clock, and processor time of all threads [s]."""

    wall: float = 0.0
    processor: float = 0.0


NOTHING = Spent()


class Stopwatch:
    """Runs from when it is made. before: what was spent before that."""

    def __init__(self, before: Spent = NOTHING):
        self._begun = Spent(time.perf_counter() - before.wall, time.process_time() - before.processor)

    @property
    def spent(self) -> Spent:
        return Spent(time.perf_counter() - self._begun.wall, time.process_time() - self._begun.processor)
