"""Memory that is kept from step to step."""

from __future__ import annotations

import math

import numpy as np

LINE = 64
"""Bytes of a line of the processor's cache, at one of which arrays begin: so rows of eight numbers lie in one."""


class Scratch:
    """Arrays that every step needs anew and whose memory is kept: fresh memory costs as much as filling it."""

    def __init__(self):
        self._kept: dict[str, np.ndarray] = {}
        self.turn = self.kept = 0

    def pass_on(self) -> None:
        """Let the next array take its turn: neither the last one nor the one that is kept."""
        self.turn = 3 - self.turn - self.kept if self.turn != self.kept else (self.turn + 1) % 3

    def keep(self) -> None:
        """Keep the present ones until the next call."""
        self.kept = self.turn

    def takes_turns(self, name: str, *shape: int) -> np.ndarray:
        """The array whose turn it is."""
        return self.take(f"{name}{self.turn}", *shape)

    def take(self, name: str, *shape: int, kind: type = np.float64) -> np.ndarray:
        """An array of any content, until the next one of this name."""
        size, kept = math.prod(shape), self._kept.get(name)
        if kept is None or len(kept) < size:
            fresh = np.empty(size + size // 64 + LINE // np.dtype(kind).itemsize, kind)
            kept = self._kept[name] = fresh[-fresh.ctypes.data % LINE // fresh.itemsize :]
        return kept[:size].reshape(shape)

    def zeros(self, name: str, *shape: int) -> np.ndarray:
        array = self.take(name, *shape)
        array.fill(0.0)
        return array
