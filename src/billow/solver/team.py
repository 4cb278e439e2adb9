"""How many threads a run uses: all it may, or one, whichever is right just now. Results do not depend on it.

On 20,000 triangles two threads take two thirds of the time of one, for a third more processor time. Beside two busy
programs they take longer than one and twice its processor time: each waits for the other to get a core.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numba
import numpy as np

TRIAL, PERIOD = 32, 512
"""Steps that are timed with all threads, and then with one; and steps from one trial to the next. While all are used,
every so many steps as a trial has are held against those with one."""

BEGIN, STAY = (0.9, 1.6), (1.0, 1.8)
"""All threads are used if they take less than this of the time, and of the processor time, of one; and go on being used
as long as they take less than that."""


def _clocks() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()


class Team:
    """clocks: give the time and the processor time of all threads [s]."""

    def __init__(self, clocks: Callable[[], tuple[float, float]] = _clocks):
        self._clocks, self._most = clocks, numba.get_num_threads()
        self._steps, self._begun = 0, (0.0, 0.0)
        self._together, self._alone = np.zeros(2), np.ones(2)

    def take(self, step: Callable[[], None]) -> None:
        """Take a step, with the number of threads that is right for it."""
        if self._most > 1:
            self._choose(self._steps % PERIOD)
        step()
        self._steps += 1

    def _choose(self, place: int) -> None:
        """Before a step at a place in its period."""
        if place % TRIAL or (place > 2 * TRIAL and numba.get_num_threads() == 1):
            return
        lap, self._begun = np.subtract(self._clocks(), self._begun), self._clocks()
        if place == 0:
            numba.set_num_threads(self._most)
        elif place == TRIAL:
            self._together = lap
            numba.set_num_threads(1)
        else:  # the end of the trial, and now and then whether it still holds
            if place == 2 * TRIAL:
                self._alone = np.maximum(lap, 1e-9)
            else:
                self._together = lap
            worth = self._together < np.multiply(BEGIN if place == 2 * TRIAL else STAY, self._alone)
            numba.set_num_threads(self._most if worth.all() else 1)

    def __enter__(self) -> Team:
        return self

    def __exit__(self, *_) -> None:
        numba.set_num_threads(self._most)
