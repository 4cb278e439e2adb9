"""A tuck: the rim of a flat bag is pushed in between its panels, and four layers lie where two were.

Both panels part, go out to the crease and come back between themselves, as the sleeve of a jacket that is turned in:
outer panels at three times the height of the inner ones. Across the crease the map keeps lengths. Beside it the rims
of both sleeves would lie in one line: the inner one is drawn in by a slope.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SLOPE, FARTHEST = 0.04, 8.0
"""Of the inner sleeve's rims, away from the outer ones: at first, and how far they get, in heights of a panel. Yarns
beside the crease grow by half the square of the slope."""
ASIDE = 1.0 / 64.0
"""Height of the inner sleeve's middle over that of the bag, in heights of a panel: by it the two are told apart."""


@dataclass(frozen=True)
class Tuck:
    """across: the axis (0 is x, 1 is y) along which the rim is pushed in. rims: of the flat bag at its low and high
    end [m]; depths: by how much each is pushed in [m], 0 for not at all. half: height [m] of a panel over the middle
    of the flat bag, and radius of the crease. sides: places of the other two rims of the flat bag [m]; still: between
    which places the inner sleeve is not drawn in [m], where creases across it will be. number: of the user's table."""

    across: int
    rims: tuple[float, float]
    depths: tuple[float, float]
    half: float
    sides: tuple[float, float]
    still: tuple[float, float]
    number: int

    @property
    def thick(self) -> float:
        """From the middle to an outer panel [m]."""
        return 3.0 * self.half

    @property
    def lines(self) -> tuple[float, ...]:
        """Places [m] of the creases on the flat bag."""
        ends = zip((-1.0, 1.0), self.rims, self.depths, strict=True)
        return tuple(rim - sign * depth for sign, rim, depth in ends if depth)

    @property
    def inner(self) -> tuple[float, float]:
        """Where the inner sleeves end [m], low and high; the flat bag's own rims where there is none."""
        low, high = (sign * (sign * rim - 2.0 * depth) for sign, rim, depth in self._ends)
        return low, high

    @property
    def outline(self) -> tuple[float, float]:
        """Least and greatest place [m] of the bag along the axis."""
        low, high = (
            rim if not depth else sign * (self._bend(sign, rim, depth) + self.half) for sign, rim, depth in self._ends
        )
        return low, high

    @property
    def _ends(self) -> tuple[tuple[float, float, float], ...]:
        return tuple(zip((-1.0, 1.0), self.rims, self.depths, strict=True))

    def _bend(self, sign: float, rim: float, depth: float) -> float:
        """Where the crease begins [m], towards its end of the bag."""
        return sign * rim - depth - 0.5 * np.pi * self.half

    def section(self, s: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where points at the places s [m], at the height h [m] over the flat bag's middle, (n,) each, go in the plane
        across the creases."""
        points = np.zeros((len(s), 3))
        points[:, self.across], points[:, 1 - self.across], points[:, 2] = s, self.still[0], h
        placed = self.place(points)
        return placed[:, self.across], placed[:, 2]

    def place(self, points: np.ndarray) -> np.ndarray:
        """Where points of the flat bag [m], (n, 3), z from its middle, go."""
        placed, x, z = points.copy(), points[:, self.across], points[:, 2]
        placed[:, 2] = 3.0 * z
        for sign, rim, depth in self._ends:
            if not depth:
                continue
            bend = self._bend(sign, rim, depth)
            beyond = sign * x - bend
            on = beyond > 0.0
            angle = np.minimum(beyond[on] / self.half, np.pi)
            back = np.maximum(beyond[on] - np.pi * self.half, 0.0)
            placed[on, self.across] = sign * (bend + self.half * np.sin(angle) - back)
            placed[on, 2] = (2.0 + np.cos(angle)) * z[on] + 0.5 * (1.0 - np.cos(angle)) * ASIDE * self.half
            placed[on, 1 - self.across] = self._drawn_in(points[on, 1 - self.across], self._slip(back))
        return placed

    def unfold(self, placed: np.ndarray) -> np.ndarray:
        """The inverse of `place` for points of panels and rims, (n, 3) [m], knowing only where they are."""
        points, z = placed.copy(), placed[:, 2]
        points[:, 2] = z / 3.0
        aside = ASIDE * self.half
        levels = np.abs(np.abs(z[:, None]) - [0.0, self.thick]).min(axis=1)
        inner = np.abs(np.abs(z[:, None] - aside) - [0.0, self.half]).min(axis=1) < levels
        for sign, rim, depth in self._ends:
            if not depth:
                continue
            bend, x = self._bend(sign, rim, depth), sign * placed[:, self.across]
            turning = x > bend + 1e-3 * self.half
            back = inner & ~turning & (x > 0.0)  # no sleeve reaches the mouth
            points[back, self.across] = sign * (2.0 * bend + np.pi * self.half - x[back])
            points[back, 2] = z[back] - aside
            points[back, 1 - self.across] = self._let_out(placed[back, 1 - self.across], self._slip(bend - x[back]))
            # In the turn lies its row alone: a quarter of a circle on, half as far aside.
            points[turning, self.across] = sign * (bend + 0.5 * np.pi * self.half)
            points[turning, 2] = 0.5 * (z[turning] - 0.5 * aside)
        return points

    def _slip(self, back: np.ndarray) -> np.ndarray:
        """How far the rims are drawn in at a way [m] behind the crease [m]."""
        return np.minimum(SLOPE * back, FARTHEST * self.half)

    def _drawn_in(self, y: np.ndarray, slip: np.ndarray) -> np.ndarray:
        low, high = (np.clip(s, 0.0, 1.0) for s in self._shares(y, 0.0))
        return y + slip * (low - high)

    def _let_out(self, y: np.ndarray, slip: np.ndarray) -> np.ndarray:
        low, high = (np.maximum(s, 0.0) for s in self._shares(y, slip))
        return y - slip * (low - high)

    def _shares(self, y: np.ndarray, slip: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        """How far a place is on its way from where nothing is drawn in to the rims, which are drawn in by slip [m]."""
        low = (self.still[0] - y) / (self.still[0] - self.sides[0] - slip)
        high = (y - self.still[1]) / (self.sides[1] - self.still[1] - slip)
        return low, high
