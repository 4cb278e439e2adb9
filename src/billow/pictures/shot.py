"""Pictures and films of deployments: the camera stands still, colours keep their meaning, every frame has its time."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from billow.pictures.camera import Camera, axes_of
from billow.pictures.deployment import Deployment, scene_of
from billow.pictures.light import paint
from billow.pictures.scene import Plane
from billow.pictures.sheet import Print, Sheet, printed

PICTURE, FILM = (1280, 960), (800, 600)
"""Width and height [pixels]."""
STRIP_WIDTH, STRIP_HEIGHTS = 1600, (240, 1600)
"""Width of a filmstrip, and least and largest height [pixels]."""
FILM_SAMPLES = 2
"""Samples a side of a pixel in films, which move."""


@dataclass(frozen=True)
class Shot:
    """What is shown, and how. deployments: drawn into one another, obstacles of all; the colours of the first are on
    the colour bar. frames: of each deployment, for each picture, (pictures, deployments). times: [s], (pictures,).
    size: width and height [pixels], None for what suits. units: to show values in, where they fit."""

    deployments: Sequence[Deployment]
    frames: Sequence[Sequence[int]]
    times: Sequence[float]
    view: str = "iso"
    plane: Plane | None = None
    size: tuple[int, int] | None = None
    title: str = ""
    units: Sequence[str] = ()

    @classmethod
    def at(cls, deployments: Sequence[Deployment], times: Sequence[float], **how) -> Shot:
        """Of the first deployment the frames nearest to times [s], each once; of the others those nearest to these."""
        first = deployments[0]
        chosen = list(dict.fromkeys(first.nearest_frame(time) for time in times))
        shown = [float(first.fabric.times[frame]) for frame in chosen]
        frames = [[d.nearest_frame(time) for d in deployments] for time in shown]
        return cls(deployments, frames, shown, **how)

    @cached_property
    def _seen(self) -> list[np.ndarray]:
        towards, found = axes_of(self.view)[2], []
        for k, deployment in enumerate(self.deployments):
            found += deployment.seen(sorted({frames[k] for frames in self.frames}), towards)
        return found

    def camera(self, width: int, height: int) -> Camera:
        """The camera that all pictures have in common."""
        return Camera.around(self._seen, self.view, width, height)

    def picture(self) -> Figure:
        """One picture, or a filmstrip of several, on a sheet. To be called and saved within `printed`."""
        wide, tall = self._extent
        aspect = wide / tall
        size = self.size or (PICTURE if len(self.frames) == 1 else self._strip(aspect))
        sheet = Sheet.fitting(*size, len(self.frames), self._colouring is not None, aspect)
        camera = self.camera(*sheet.panel)
        page = Print(sheet, camera, self.title, self._colouring, self.units)
        for panel, (frames, time) in enumerate(zip(self.frames, self.times, strict=True)):
            page.show(panel, paint(scene_of(self.deployments, frames, camera, self.plane), camera), time)
        return page.figure

    def film(self) -> Iterator[np.ndarray]:
        """The pictures one after the other: red, green, blue as bytes, (height, width, 3)."""
        with printed():
            sheet = Sheet.fitting(*(self.size or FILM), 1, self._colouring is not None, 1.0)
            camera = self.camera(*sheet.panel)
            page = Print(sheet, camera, self.title, self._colouring, self.units)
            canvas = FigureCanvasAgg(page.figure)
            for frames, time in zip(self.frames, self.times, strict=True):
                page.show(0, paint(scene_of(self.deployments, frames, camera, self.plane), camera, FILM_SAMPLES), time)
                canvas.draw()
                yield np.asarray(canvas.buffer_rgba())[..., :3].copy()

    @property
    def _colouring(self):
        return self.deployments[0].colouring

    @property
    def _extent(self) -> np.ndarray:
        """Width and height of what is seen [m]."""
        axes = axes_of(self.view)[:2]
        points = np.concatenate([points @ axes.T for points in self._seen])
        return np.maximum(np.ptp(points, axis=0), 1e-9)

    def _strip(self, aspect: float) -> tuple[int, int]:
        """Size of a sheet on which up to five pictures stand in a row."""
        columns = min(len(self.frames), 5)
        rows = -(-len(self.frames) // columns)
        tall = rows * (STRIP_WIDTH / columns / aspect + 50.0) + 110.0
        return STRIP_WIDTH, int(np.clip(tall, *STRIP_HEIGHTS))


def drawn(shot: Shot, kind: str) -> bytes:
    """A picture or a filmstrip as a file: "png", "svg" or "pdf"."""
    with printed():
        return saved(shot.picture(), kind)


def saved(figure: Figure, kind: str) -> bytes:
    """A figure as PNG, SVG or PDF; same numbers, same bytes."""
    buffer = io.BytesIO()
    metadata = {
        "png": {"Software": "Billow"},
        "svg": {"Creator": "Billow", "Date": None},
        "pdf": {"Creator": "Billow", "Producer": "Billow", "CreationDate": None},
    }
    engine = figure.get_layout_engine()
    if engine is not None:  # laid out by itself: `savefig` would draw all of it for that, and then again
        engine.execute(figure)
        figure.set_layout_engine("none")
    figure.savefig(buffer, format=kind, dpi=figure.dpi, metadata=metadata[kind])
    return named_in_order(buffer.getvalue()) if kind == "svg" else buffer.getvalue()


def named_in_order(svg: bytes) -> bytes:
    """SVG whose clip paths are numbered: matplotlib names them by all digits of their places, and the solver of its
    layout rounds the last ones as it likes."""
    names: dict[bytes, bytes] = {}

    def number(found: re.Match) -> bytes:
        return names.setdefault(found[0], b"clip%d" % len(names))

    return re.sub(rb'(?<=[#"])p[0-9a-f]{10}(?=[)"])', number, svg)
