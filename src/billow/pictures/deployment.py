"""A deployment as a picture shows it: the bag of one frame in its colours, obstacles, straps and plates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import ListedColormap

from billow.pictures.camera import Camera
from billow.pictures.fields import Field
from billow.pictures.scene import Body, Plane, Scene, tubes
from billow.pictures.section import cut
from billow.results.obstacles import has_end, obstacles_at, surface
from billow.results.result import Result
from billow.results.vtkhdf import FabricFile

CLOTH, OTHER_CLOTH = (0.93, 0.91, 0.87), (0.45, 0.72, 0.62)
HOLE, UNKNOWN = (0.25, 0.28, 0.31), (0.80, 0.80, 0.80)
"""Vents and mouths; fabric whose value is no number."""
OBSTACLE, CUT_OBSTACLE = (0.44, 0.55, 0.66), (0.62, 0.70, 0.78)
PLATE = (0.86, 0.88, 0.90)
STRAP, SECTION = (0.80, 0.33, 0.10), (0.13, 0.19, 0.24)
COLOURS = ListedColormap(0.92 * colormaps["viridis"](np.linspace(0.0, 1.0, 256))[:, :3] + 0.08, "billow")
"""Viridis, a little lighter, so that light on its dark end is seen."""
HOLES = ("vent", "mouth", "opening")
"""How the names of parts begin that are no fabric."""

PLATE_SIZE, PLATE_DEPTH, PLATE_GAP, PLATE_CORNERS = 1.2, 0.02, 0.003, 96
"""Of the piece of a plate that is drawn: its radius over that of the bag, and over the size of the bag its depth and
how far it is drawn below its place, so that fabric that lies on it is seen."""
STRAP_WIDTH, SECTION_WIDTH = 2.2, 1.6
"""Radius of a strap, and of the line where a plane cuts fabric, in thousandths of the size of the bag."""
REACH = 0.6
"""How far around the bag, over its size, obstacles decide what the camera sees."""


@dataclass(frozen=True)
class Colouring:
    """A field with its colours. low, high: values at the ends of the colour bar."""

    field: Field
    low: float
    high: float

    def colours(self, frame: int) -> np.ndarray:
        """Red, green, blue from 0 to 1, (n, 3)."""
        values = self.field.values[frame].astype(float)
        span = self.high - self.low
        part = np.clip((values - self.low) / span, 0.0, 1.0) if span > 0.0 else np.zeros_like(values)
        found = COLOURS(np.nan_to_num(part))[:, :3]
        return np.where(np.isfinite(values)[:, None], found, UNKNOWN)


def colouring_of(field: Field, limits: tuple[float, float] | None = None) -> Colouring:
    """Colours of a field from limits, by default its usual ones in all frames."""
    return Colouring(field, *(field.usual_limits if limits is None else limits))


@dataclass(frozen=True)
class Deployment:
    """Frames of one bag. result: the run they belong to, whose obstacles are drawn; None for a predicted bag."""

    fabric: FabricFile
    result: Result | None = None
    colouring: Colouring | None = None
    cloth: tuple[float, float, float] = CLOTH

    @cached_property
    def size(self) -> float:
        """Across the bag in its largest frame, [m]."""
        low, high = self._box
        return max(float(np.linalg.norm(high - low)), 1e-9)

    @cached_property
    def _box(self) -> np.ndarray:
        """Corners of the box that holds the bag in all frames, [m], (2, 3)."""
        points = [self.fabric.points(k) for k in range(len(self.fabric.times))]
        return np.array(
            [np.min([p.min(axis=0) for p in points], axis=0), np.max([p.max(axis=0) for p in points], axis=0)]
        )

    @property
    def _corners(self) -> np.ndarray:
        """Of the box, (8, 3)."""
        return np.stack(np.meshgrid(*self._box.T, indexing="ij"), axis=-1).reshape(-1, 3)

    def nearest_frame(self, time: float) -> int:
        """The frame whose time is nearest to `time` [s]."""
        return int(np.abs(self.fabric.times - time).argmin())

    def bodies(self, frame: int, towards: np.ndarray, plane: Plane | None = None) -> list[Body]:
        """What is drawn of a frame. towards: the viewer, (3,); plates seen from behind are left out. plane: cuts."""
        points, time = self.fabric.points(frame), float(self.fabric.times[frame])
        found = [self._bag(points, frame)]
        if plane is not None:
            lines, _ = cut(points, self.fabric.triangles, plane)
            if len(lines):
                radius = 1e-3 * SECTION_WIDTH * self.size
                found.append(tubes(lines[:, 0], lines[:, 1], radius, SECTION, cut=False))
        straps = None if self.result is None else self.result.straps
        if straps is not None:
            ends = straps.points(frame)[straps.lines]
            found.append(tubes(ends[:, 0], ends[:, 1], 1e-3 * STRAP_WIDTH * self.size, STRAP))
        for obstacle in [] if self.result is None else obstacles_at(self.result, time):
            if has_end(obstacle):
                found.append(_solid(*surface(obstacle), OBSTACLE, CUT_OBSTACLE))
            elif _is_seen(obstacle, towards):
                found.append(self._plate(obstacle))
        return found

    def seen(self, frames: Sequence[int], towards: np.ndarray) -> list[np.ndarray]:
        """Points [m] that a camera should see in all these frames: the bag of all frames, and what is near it."""
        low, high = self._box
        around = low - REACH * self.size, high + REACH * self.size
        found = [self._corners]
        for time in self.fabric.times[list(frames)] if self.result is not None else ():
            for obstacle in obstacles_at(self.result, float(time)):
                if has_end(obstacle):
                    found.append(np.clip(surface(obstacle)[0], *around))
                elif _is_seen(obstacle, towards):
                    found.append(self._plate(obstacle).points)
        return found

    def _bag(self, points: np.ndarray, frame: int) -> Body:
        holes = [name.startswith(HOLES) for name in self.fabric.part_names]
        is_hole = np.array(holes)[self.fabric.part]
        triangles = self.fabric.triangles
        if self.colouring is None:
            colours = np.tile(self.cloth, (len(triangles), 1))
        else:
            colours = self.colouring.colours(frame)
            if self.colouring.field.at_nodes:
                colours = colours[triangles]
        if colours.ndim == 2:
            colours = np.repeat(colours[:, None], 3, axis=1)
        colours = np.where(is_hole[:, None, None], HOLE, colours)
        return Body(points, triangles, colours, self.fabric.part.astype(np.int64))

    def _plate(self, obstacle: dict) -> Body:
        """A round piece of a plate under the bag."""
        rotation, centre = np.asarray(obstacle["rotation"], float), np.asarray(obstacle["center"], float)
        corners = (self._corners - centre) @ rotation
        middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        wide = PLATE_SIZE * 0.5 * float(np.ptp(corners[:, :2], axis=0).max())
        angle = 2.0 * np.pi * np.arange(PLATE_CORNERS) / PLATE_CORNERS
        ring = np.stack([middle[0] + wide * np.cos(angle), middle[1] + wide * np.sin(angle), 0.0 * angle], axis=1)
        ring -= [0.0, 0.0, PLATE_GAP * self.size]
        below = ring - [0.0, 0.0, PLATE_DEPTH * self.size]
        k = np.arange(PLATE_CORNERS)
        after, n = (k + 1) % PLATE_CORNERS, PLATE_CORNERS
        top, bottom = 2 * n + 0 * k, 2 * n + 1 + 0 * k
        triangles = np.concatenate([
            np.stack(t, axis=1)
            for t in ((top, k, after), (k, k + n, after + n), (k, after + n, after), (bottom, after + n, k + n))
        ])  # fmt: skip
        points = np.concatenate([ring, below, [ring.mean(axis=0), below.mean(axis=0)]])
        patch = np.repeat([0, 1, 1, 2], n)
        colours = np.tile(PLATE, (len(triangles), 3, 1))
        return Body(points @ rotation.T + centre, triangles, colours, patch, PLATE)


def _is_seen(plate: dict, towards: np.ndarray) -> bool:
    """Whether a plate is seen from the side it is on, or from its edge."""
    return bool(np.asarray(plate["rotation"], float)[:, 2] @ towards > -1e-9)


def _solid(points: np.ndarray, triangles: np.ndarray, colour, cut_colour) -> Body:
    colours = np.tile(np.asarray(colour, float), (len(triangles), 3, 1))
    return Body(points, triangles, colours, np.zeros(len(triangles), np.int64), cut_colour)


def scene_of(deployments: Sequence[Deployment], frames: Sequence[int], camera: Camera, plane: Plane | None) -> Scene:
    """A frame of each deployment together; obstacles of the first."""
    towards = camera.axes[2]
    facing = None if plane is None else plane.facing(towards)
    bodies = [
        body for deployment, frame in zip(deployments, frames, strict=True)
        for body in deployment.bodies(frame, towards, facing)
    ]  # fmt: skip
    return Scene.of(bodies, facing)
