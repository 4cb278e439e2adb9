"""Sections of bags over one another, with the obstacles that the plane cuts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from billow.pictures.scene import Plane
from billow.pictures.section import across, cut
from billow.results.obstacles import outline

OBSTACLE = "#c9d2d9"
MILLI = 1e3
FINENESS = 300
"""Points a side at which it is asked whether they lie in an obstacle."""
MARGIN = 0.08
"""Part of its width that a window is wider than what it shows, on each side."""


def window_of(plane: Plane, bags: Iterable[np.ndarray]) -> np.ndarray:
    """Limits [mm], (2, 2), right and up, of a window that shows all these points [m], (nodes, 3) each."""
    right, up = across(plane)
    limits = [(p[:, [right, up]].min(axis=0), p[:, [right, up]].max(axis=0)) for p in bags]
    low, high = np.min([low for low, _ in limits], axis=0), np.max([high for _, high in limits], axis=0)
    margin = MARGIN * max(float((high - low)[0]), 1e-9)
    return MILLI * np.stack([low - margin, high + margin], axis=1)


def draw_obstacles(axes: Axes, plane: Plane, obstacles: Sequence[dict], window: np.ndarray) -> None:
    """Fill what the plane cuts of obstacles, as run.json describes them. window: as `window_of`."""
    right, up = across(plane)
    x, y = np.meshgrid(*(np.linspace(*limits, FINENESS) for limits in window))
    places = np.empty((*x.shape, 3))
    places[..., right], places[..., up] = x / MILLI, y / MILLI
    places[..., 3 - right - up] = plane.offset * plane.normal[3 - right - up]
    for obstacle in obstacles:
        level = outline(obstacle, places)
        if level.min() < 0.0:
            axes.contourf(x, y, level, levels=[level.min() - 1.0, 0.0], colors=[OBSTACLE])


def draw_bag(axes: Axes, plane: Plane, points: np.ndarray, triangles: np.ndarray, **style) -> None:
    """Draw where a plane cuts a bag. points: [m], (nodes, 3); style: of `LineCollection`."""
    segments, _ = cut(points, triangles, plane)
    lines = MILLI * segments[..., list(across(plane))]
    axes.add_collection(LineCollection(lines, **{"capstyle": "round"} | style))
