"""The line that a flat sheet takes across its fold lines, in a plane: straights, half circles and spirals, end to end.

A point of the sheet at arc length s along the line and at height h over its middle goes to C(s) + h n(s); n is the
unit normal to the left of travel. The map of a piece and its inverse are closed forms (docs/folding.md).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

NO_PLACE = np.inf
"""Height over a piece of a point that is not on it."""


@dataclass(frozen=True)
class Straight:
    """From s = `begin` to `end` [m], along x in direction 1 or -1, from x = `x` at the height z [m]."""

    begin: float
    end: float
    x: float
    z: float
    direction: int

    @property
    def length(self) -> float:
        return self.end - self.begin

    @property
    def ends(self) -> tuple[float, float]:
        """x [m] where it begins and ends."""
        return self.x, self.x + self.direction * self.length

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Least and greatest x, least and greatest z [m]."""
        return min(self.ends), max(self.ends), self.z, self.z

    def place(self, s: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.x + self.direction * (s - self.begin), self.z + self.direction * h

    def unfold(self, x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """s and h [m] of points; NO_PLACE for those beyond its ends."""
        s = self.begin + self.direction * (x - self.x)
        return s, _within(s, self.direction * (z - self.z), self.begin, self.end)

    def mirrored(self) -> Straight:
        """The other way round and at -x, so that the sheet runs from -end to -begin."""
        return replace(self, begin=-self.end, end=-self.begin, x=-self.ends[1])

    def upside_down(self) -> Straight:
        return replace(self, z=-self.z)

    def moved(self, s: float, x: float) -> Straight:
        """Shifted along the sheet and in x [m]."""
        return replace(self, begin=self.begin + s, end=self.end + s, x=self.x + x)

    def turned_over(self, x: float, z: float) -> Straight:
        """Turned by half a turn about (x, z) [m]."""
        return replace(self, x=2.0 * x - self.x, z=2.0 * z - self.z, direction=-self.direction)


@dataclass(frozen=True)
class Turn:
    """Half a circle from s = `begin` [m] about (x, z) [m] with a radius [m], from the `angle` [rad] on that its first
    point is seen at, to the left (turn = 1) or to the right (-1)."""

    begin: float
    x: float
    z: float
    radius: float
    angle: float
    turn: int

    @property
    def end(self) -> float:
        return self.begin + np.pi * self.radius

    @property
    def middle(self) -> float:
        """s of the crease's row of nodes [m]."""
        return 0.5 * (self.begin + self.end)

    @property
    def box(self) -> tuple[float, float, float, float]:
        side = np.cos(self.angle + 0.5 * np.pi * self.turn)
        reach = sorted((self.x, self.x + self.radius * np.sign(side)))
        return reach[0], reach[1], self.z - self.radius, self.z + self.radius

    def place(self, s: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        angle = self.angle + self.turn * (s - self.begin) / self.radius
        reach = self.radius - self.turn * h
        return self.x + reach * np.cos(angle), self.z + reach * np.sin(angle)

    def unfold(self, x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """s and h [m] of points; NO_PLACE for those beyond its ends."""
        dx, dz = x - self.x, z - self.z
        middle = self.angle + 0.5 * np.pi * self.turn
        across, along = dx * np.cos(middle) + dz * np.sin(middle), dz * np.cos(middle) - dx * np.sin(middle)
        passed = 0.5 * np.pi + self.turn * np.arctan2(along, across)
        s = self.begin + self.radius * passed
        return s, _within(s, self.turn * (self.radius - np.hypot(dx, dz)), self.begin, self.end)

    def mirrored(self) -> Turn:
        return replace(self, begin=-self.end, x=-self.x, angle=np.pi - (self.angle + np.pi * self.turn))

    def upside_down(self) -> Turn:
        return replace(self, z=-self.z, angle=-self.angle, turn=-self.turn)

    def moved(self, s: float, x: float) -> Turn:
        return replace(self, begin=self.begin + s, x=self.x + x)

    def turned_over(self, x: float, z: float) -> Turn:
        return replace(self, x=2.0 * x - self.x, z=2.0 * z - self.z, angle=self.angle + np.pi)


@dataclass(frozen=True)
class Spiral:
    """From s = `begin` to `end` [m] about (x, z) [m], as `Turn`, its radius falling from `radius` [m] by `pitch` [m] a
    turn (growing, if negative); with dr much below r its arc length is r t - pitch t^2 / 4 pi."""

    begin: float
    end: float
    x: float
    z: float
    radius: float
    pitch: float
    angle: float
    turn: int

    @property
    def _fall(self) -> float:
        """Of the radius, per radian [m]."""
        return self.pitch / (2.0 * np.pi)

    def _radius(self, s: np.ndarray | float) -> np.ndarray | float:
        return np.sqrt(np.maximum(self.radius**2 - 2.0 * self._fall * (s - self.begin), 0.0))

    def _angle(self, radius: np.ndarray | float) -> np.ndarray | float:
        return self.angle + self.turn * (self.radius - radius) / self._fall

    @property
    def box(self) -> tuple[float, float, float, float]:
        reach = max(self.radius, float(self._radius(self.end)))
        return self.x - reach, self.x + reach, self.z - reach, self.z + reach

    def place(self, s: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        radius = self._radius(s)
        angle, reach = self._angle(radius), radius - self.turn * h
        return self.x + reach * np.cos(angle), self.z + reach * np.sin(angle)

    def unfold(self, x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """s and h [m] of points, on the lap that is nearest; NO_PLACE for those beyond its ends."""
        reach = np.hypot(x - self.x, z - self.z)
        angle = np.mod(self.turn * (np.arctan2(z - self.z, x - self.x) - self.angle), 2.0 * np.pi)
        angle = angle + 2.0 * np.pi * np.round((self.radius - reach - self._fall * angle) / self.pitch)
        radius = self.radius - self._fall * angle
        s = self.begin + (self.radius**2 - radius**2) / (2.0 * self._fall)
        return s, _within(s, self.turn * (radius - reach), self.begin, self.end)

    def mirrored(self) -> Spiral:
        radius = float(self._radius(self.end))
        return replace(
            self, begin=-self.end, end=-self.begin, x=-self.x, radius=radius, pitch=-self.pitch,
            angle=np.pi - float(self._angle(radius)),
        )  # fmt: skip

    def upside_down(self) -> Spiral:
        return replace(self, z=-self.z, angle=-self.angle, turn=-self.turn)

    def moved(self, s: float, x: float) -> Spiral:
        return replace(self, begin=self.begin + s, end=self.end + s, x=self.x + x)

    def turned_over(self, x: float, z: float) -> Spiral:
        return replace(self, x=2.0 * x - self.x, z=2.0 * z - self.z, angle=self.angle + np.pi)


Piece = Straight | Turn | Spiral


def _within(s: np.ndarray, h: np.ndarray, begin: float, end: float) -> np.ndarray:
    """h where s lies on the piece, up to rounding; NO_PLACE elsewhere."""
    rounding = 1e-9 * (end - begin)
    return np.where((s >= begin - rounding) & (s <= end + rounding), h, NO_PLACE)


@dataclass(frozen=True)
class FoldCurve:
    """Pieces end to end. The sheet, `half` [m] thick to either side of its middle, lies with `gap` [m] to the next."""

    pieces: tuple[Piece, ...]
    half: float
    gap: float

    @classmethod
    def flat(cls, low: float, high: float, half: float, gap: float) -> FoldCurve:
        """A sheet that lies flat from x = low to high [m]."""
        return cls((Straight(low, high, low, 0.0, 1),), half, gap)

    @property
    def radius(self) -> float:
        """Least radius of a turn [m]: what lies inside keeps its gap, and with 0.6 of the thickness nothing cuts."""
        return self.half + max(0.5 * self.gap, 0.2 * self.half)

    @property
    def pitch(self) -> float:
        """Height that one more sheet adds [m]."""
        return 2.0 * self.radius

    @property
    def turns(self) -> tuple[Turn, ...]:
        return tuple(piece for piece in self.pieces if isinstance(piece, Turn))

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Least and greatest x, least and greatest z of the sheet's middle [m]."""
        boxes = np.array([piece.box for piece in self.pieces])
        return boxes[:, 0].min(), boxes[:, 1].max(), boxes[:, 2].min(), boxes[:, 3].max()

    @property
    def height(self) -> tuple[float, float]:
        """Lowest and highest z of the sheet's skins [m]."""
        _, _, low, high = self.box
        return low - self.half, high + self.half

    @property
    def sheets(self) -> int:
        """How many sheets lie over each other at most."""
        ends = sorted({x for piece in self._straights for x in piece.ends})
        middles = [0.5 * (a + b) for a, b in itertools.pairwise(ends)]
        return max(sum(piece.box[0] < x < piece.box[1] for piece in self._straights) for x in middles)

    @property
    def _straights(self) -> list[Straight]:
        return [piece for piece in self.pieces if isinstance(piece, Straight)]

    def place(self, s: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """x and z [m] of points of the sheet at s and h [m], (n,) each; beyond its ends it goes on as it ends."""
        starts = np.array([piece.begin for piece in self.pieces[1:]])
        which = np.searchsorted(starts, s, side="right")
        x, z = np.empty_like(s), np.empty_like(s)
        for k, piece in enumerate(self.pieces):
            mine = which == k
            x[mine], z[mine] = piece.place(s[mine], h[mine])
        return x, z

    def unfold(self, x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """s and h [m] of points at x and z [m], (n,) each, knowing only where they are: of all pieces the one whose
        middle is nearest."""
        s, h = np.full_like(x, np.nan), np.full_like(x, NO_PLACE)
        for piece in self.pieces:
            own_s, own_h = piece.unfold(x, z)
            nearer = np.abs(own_h) < np.abs(h)
            s[nearer], h[nearer] = own_s[nearer], own_h[nearer]
        return s, h

    def mirrored(self) -> FoldCurve:
        """At -x, the sheet from its other end on."""
        return replace(self, pieces=tuple(piece.mirrored() for piece in reversed(self.pieces)))

    def upside_down(self) -> FoldCurve:
        """At -z."""
        return replace(self, pieces=tuple(piece.upside_down() for piece in self.pieces))

    def top(self, low: float, high: float, pieces: Iterable[Piece] | None = None) -> float:
        """Greatest z [m] of the sheet's middle between low and high [m] in x; -inf where there is none."""
        boxes = [piece.box for piece in (self.pieces if pieces is None else pieces)]
        return max((box[3] for box in boxes if box[1] > low and box[0] < high), default=-np.inf)
