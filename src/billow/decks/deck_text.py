"""A deck that is being written: `*KEYWORD LONG=Y`, all columns 20 wide, numbers in the units of the deck."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from billow.decks.exact_lengths import written
from billow.decks.units import Units

WIDTH = 20
MOST_DIGITS = 17
"""Significant digits of a number; fewer where a column is too narrow."""


class DeckText:
    """The text, keyword by keyword, and numbers that it gives away: ids of curves and nodes."""

    def __init__(self, units: Units, title: str):
        self.units = units
        self.lines = ["*KEYWORD LONG=Y", "*TITLE", title]
        self.curves = 0
        self.nodes = 0

    def keyword(self, name: str) -> None:
        self.lines.append(f"*{name}")

    def comment(self, text: str) -> None:
        self.lines.append(f"$ {text}")

    def text(self, text: str) -> None:
        self.lines.append(text)

    def card(self, *values: float | int | str | None) -> None:
        self.lines.append("".join(_column(value) for value in values).rstrip() or " ")

    def of(self, value: float, dimension: str) -> float:
        """An SI value in the units of the deck."""
        return self.units.of_si(float(value), dimension)

    def curve(self, x: Iterable[float], y: Iterable[float], of_x: str, of_y: str, title: str) -> int:
        """Write a *DEFINE_CURVE of SI values; its id."""
        self.curves += 1
        self.keyword("DEFINE_CURVE_TITLE")
        self.text(title)
        self.card(self.curves, 0, 1.0, 1.0, 0.0, 0.0)
        for a, b in zip(x, y, strict=True):
            self.card(self.of(a, of_x), self.of(b, of_y))
        return self.curves

    def course(self, motion, name: str) -> int:
        """Write the curve of a motion that is prescribed, a `travel` or `speed` table of a case; its id."""
        of, value = ("length", motion.travel) if motion.kind == "travel" else ("velocity", motion.speed)
        time, values = ([0.0, 1.0], [value, value]) if isinstance(value, float) else (value.time, value.value)
        return self.curve(time, values, "time", of, f"{name} {motion.kind}")

    def node_block(self, points: np.ndarray, held: np.ndarray | None = None) -> int:
        """Write nodes at points [m], (n, 3); the id before the first of them. Coordinates keep all their bits."""
        first = self.nodes
        self.keyword("NODE")
        for k, point in enumerate(points.tolist(), 1):
            texts = [written(value, self.units, WIDTH) for value in point]
            code = 7 if held is not None and held[k - 1] else 0
            if any(len(text) >= WIDTH for text in texts):
                self.lines.append(",".join([str(first + k), *texts, str(code), "0"]))  # columns would cut digits off
            else:
                self.lines.append("".join(t.rjust(WIDTH) for t in [str(first + k), *texts, str(code), "0"]))
        self.nodes += len(points)
        return first

    def __str__(self) -> str:
        return "\n".join([*self.lines, "*END"]) + "\n"


def _column(value: float | int | str | None) -> str:
    if value is None:
        return " " * WIDTH
    text = str(value)
    digits = MOST_DIGITS
    while len(text) > WIDTH:
        text, digits = f"{value:.{digits}g}", digits - 1
    return text.rjust(WIDTH)
