"""The rim of a disc that is folded: nodes wherever a line ends, evenly spaced ones between."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from billow.base.errors import InputError
from billow.geometry.rectangle_mesh import ROUNDING

ALONG_THE_RIM = InputError.declare(
    "E-GEO-048",
    "a fold line at {place:.4g} m from the middle cannot be meshed at the rim",
    where="bag.folds",
    why="it meets the rim at ({x:.4g}, {y:.4g}) m, where another line ends or the line runs along the rim",
    cause="a panel that is as narrow as an element at the rim, or two lines that meet there",
    remedy="move the line, or reduce bag.element_size",
)
LEAST = 0.4
"""Shortest edge of the rim, in edges."""
CORNER = 0.35
"""Distance between the rim and the place where two lines meet up to which the rim goes through it, in edges."""

Line = tuple[int, float]
"""A line across an axis (0 is x, 1 is y), and its place on the axis [m]."""


@dataclass
class DiscRim:
    """The circle of `radius` [m], with a node wherever a line ends. strips: for each row that has to be exact, the
    places [m] of the line before it, of itself and of the line behind it on the axis `first`. points: of the rim [m].
    ends: the two of them where each line ends."""

    radius: float
    size: float
    first: int | None
    strips: list[tuple[float, float, float]]
    ends: dict[Line, list[int]] = field(default_factory=dict)
    points: list[np.ndarray] = field(default_factory=list)

    def in_strip(self, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
        """Whether points [m] (n, 2) lie in a strip, or up to a margin [m] beside it, and on none of its lines."""
        inside, on_line = np.zeros((2, len(points)), dtype=bool)
        for strip in self.strips:
            at = points[:, self.first]
            inside |= (at > strip[0] - margin) & (at < strip[2] + margin)
            on_line |= (np.abs(np.subtract.outer(at, strip)) < ROUNDING).any(axis=1)
        return inside & ~on_line

    def meet(self, line: Line, row: float | None = None) -> None:
        """Let a line end at nodes of the rim. row: place of the fold line that needs it [m], None for a line that may
        end before. Raises InputError E-GEO-048 if one that is needed cannot."""
        (axis, place), needed = line, row is not None
        if line in self.ends or not (needed or self.radius - abs(place) >= self.size):
            return
        if self.radius - abs(place) < LEAST * self.size:
            x, y = np.roll([place, 0.0], axis)
            raise ALONG_THE_RIM(place=row, x=x, y=y)
        half, meant = np.sqrt(self.radius**2 - place**2), []
        for there in (-half, half):
            end = np.roll([place, there], axis)
            corner = self._corner(line, end) if needed else None
            if corner is None and self._is_crowded(end):
                if needed:
                    raise ALONG_THE_RIM(place=row, x=end[0], y=end[1])
                return
            fresh = len(self.points) + sum(node >= len(self.points) for node, _ in meant)
            meant.append(corner or (fresh, end))
        self.ends[line] = [node for node, _ in meant]
        for node, point in meant:
            self.points[node : node + 1] = [point]

    def _is_crowded(self, end: np.ndarray) -> bool:
        away = np.linalg.norm(np.reshape(self.points, (-1, 2)) - end, axis=1)
        return away.min(initial=np.inf) < LEAST * self.size or bool(self.in_strip(end[None])[0])

    def _corner(self, line: Line, end: np.ndarray) -> tuple[int, np.ndarray] | None:
        """The node where a line of a strip ends that this one meets at the rim, and where they meet [m]."""
        for (axis, place), nodes in self.ends.items():
            if axis == line[0] or place * end[axis] < 0.0 or not any(place in strip for strip in self.strips):
                continue
            meeting = np.roll([line[1], place], line[0])
            off, slope = np.hypot(*meeting) - self.radius, abs(meeting[0] * meeting[1]) / self.radius**2
            if -CORNER * self.size < off < max(LEAST * slope, ROUNDING) * self.size:
                return min(nodes, key=lambda node: np.linalg.norm(self.points[node] - meeting)), meeting
        return None

    def closed(self) -> np.ndarray:
        """All its points in order [m], (n, 2), evenly spaced between the ends of lines; `ends` follow."""
        angle = np.arctan2(*np.reshape(self.points, (-1, 2)).T[::-1])
        order = np.argsort(angle)
        number, points = np.empty(len(order), dtype=int), []
        for k, node in enumerate(order):
            number[node] = len(points)
            a, b = angle[node], angle[order[(k + 1) % len(order)]]
            b += 2.0 * np.pi * (b <= a)
            middle = self.radius * np.array([[np.cos(0.5 * (a + b)), np.sin(0.5 * (a + b))]])
            count = 1 if self.in_strip(middle)[0] else max(1, round((b - a) * self.radius / self.size))
            between = np.linspace(a, b, count + 1)[1:-1]
            points += [self.points[node], *(self.radius * np.column_stack([np.cos(between), np.sin(between)]))]
        self.ends = {line: [int(number[node]) for node in nodes] for line, nodes in self.ends.items()}
        self.points = points
        return np.array(points)
