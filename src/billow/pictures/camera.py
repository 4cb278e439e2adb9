"""Where a picture is taken from: a parallel projection, so that lengths can be read off it.

Space is that of a case: z is up from the plate. In the picture x goes right, y down, and depth towards the viewer.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

VIEWS = {
    "iso": (-60.0, 20.0),
    "front": (-90.0, 0.0),
    "side": (0.0, 0.0),
    "top": (-90.0, 90.0),
    "below": (-90.0, -90.0),
}
"""Azimuth about z, from x towards y, and elevation of the viewer [deg]. From the front x goes right and z up, from the
side y goes right, from the top y goes up."""

MARGIN = 0.05
"""Part of the picture that stays empty on each side."""


def axes_of(view: str) -> np.ndarray:
    """Rows: right, up and towards the viewer, unit vectors in space, (3, 3)."""
    azimuth, elevation = (math.radians(angle) for angle in VIEWS[view])
    sa, ca, se, ce = math.sin(azimuth), math.cos(azimuth), math.sin(elevation), math.cos(elevation)
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


@dataclass(frozen=True)
class Camera:
    """axes: as `axes_of`. centre: what is in the middle of the picture [m], (3,). scale: pixels a metre.
    width, height: [pixels]."""

    axes: np.ndarray
    centre: np.ndarray
    scale: float
    width: int
    height: int

    @classmethod
    def around(cls, boxes: Iterable[np.ndarray], view: str, width: int, height: int) -> Camera:
        """Camera that sees all points [m], arrays (n, 3), as large as they fit."""
        axes = axes_of(view)
        seen = np.concatenate([np.asarray(points, float) @ axes.T for points in boxes])
        low, high = seen.min(axis=0), seen.max(axis=0)
        wide, tall = np.maximum(high - low, 1e-9)[:2]
        room = 1.0 - 2.0 * MARGIN
        return cls(axes, 0.5 * (low + high) @ axes, room * min(width / wide, height / tall), width, height)

    def larger(self, factor: int) -> Camera:
        """The same view with `factor` times the pixels a side."""
        return Camera(self.axes, self.centre, self.scale * factor, self.width * factor, self.height * factor)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Place in the picture and depth of points [m] (n, 3): pixels, (n, 3). The middle of the first pixel is at
        (0.5, 0.5)."""
        x, y, depth = self.scale * (self.axes @ (np.asarray(points, float) - self.centre).T)
        return np.stack([0.5 * self.width + x, 0.5 * self.height - y, depth], axis=1)
