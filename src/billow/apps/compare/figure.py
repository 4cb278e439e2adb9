"""A comparison as one figure: curves over one another, sections over one another, and the bag coloured by distance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from billow.apps.compare.differences import CurveDifference, distances, frames_in_common, same_mesh
from billow.apps.compare.side import Side
from billow.pictures.camera import Camera, axes_of
from billow.pictures.curve_figure import RESOLUTION, WIDTH, draw_curves, line_style, put_legend
from billow.pictures.deployment import COLOURS, Colouring, Deployment, scene_of
from billow.pictures.fields import Field
from billow.pictures.light import paint
from billow.pictures.scene import Plane
from billow.pictures.section import AXES, across
from billow.pictures.section_figure import draw_bag, draw_obstacles, window_of
from billow.pictures.sheet import on_white
from billow.results.obstacles import has_end, obstacles_at

CURVE_HEIGHT, SECTION_HEIGHT, PICTURE_HEIGHT, LEGEND_HEIGHT = 2.7, (1.2, 3.2), 3.4, 0.5
"""[inches]; of sections the least and the largest."""
SECTIONS = 6
COLUMNS = 3
PICTURE = (900, 620)
"""Pixels of each of the two pictures."""


def comparison_figure(
    first: Side, second: Side, curves: Sequence[CurveDifference], plane: Plane, view: str, units: Sequence[str] = ()
) -> Figure:
    """The figure. To be used within `sheet.printed`."""
    labels = [first.label, second.label]
    common = frames_in_common(first, second)
    chosen = _some(common)
    window = _window(first, second, chosen, plane) if chosen else None
    rows = []
    if curves:
        rows.append(CURVE_HEIGHT * math.ceil(len(curves) / 2))
    if chosen:
        aspect = float(np.ptp(window[1]) / np.ptp(window[0]))
        one = float(np.clip(WIDTH / COLUMNS * aspect + 0.35, *SECTION_HEIGHT))
        rows += [one * math.ceil(len(chosen) / COLUMNS) + 0.3, PICTURE_HEIGHT]
    figure = Figure(figsize=(WIDTH, sum(rows) + LEGEND_HEIGHT), dpi=RESOLUTION, layout="constrained")
    put_legend(figure, labels)
    parts = iter(np.atleast_1d(figure.subfigures(len(rows), 1, height_ratios=rows)))
    if curves:
        grid = np.ravel(next(parts).subplots(math.ceil(len(curves) / 2), 2, squeeze=False))
        for axes, found in zip(grid, curves, strict=False):
            draw_curves(axes, dict(zip(labels, (found.first, found.second), strict=True)), labels, units)
            if found.rating is not None:
                rating = f"ISO/TS 18571: {found.rating.overall:.2f}, {found.rating.grade}"
                axes.set_xlabel(f"{axes.get_xlabel()}      {rating}")
        for axes in grid[len(curves) :]:
            axes.set_axis_off()
    if chosen:
        _sections(next(parts), first, second, chosen, plane, window)
        _pictures(next(parts), first, second, chosen, view)
    return figure


def _some(common: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Up to six of the frames, the last among them, and not the first, which is the flat bag, if there are others."""
    places = np.linspace(0, len(common) - 1, SECTIONS + 1).round().astype(int)
    return [common[k] for k in np.unique(places[1:])] if common else []


def _window(first: Side, second: Side, chosen, plane: Plane) -> np.ndarray:
    bags = [side.fabric.points(frames[k]) for frames in chosen for k, side in enumerate((first, second))]
    return window_of(plane, bags)


def _sections(part, first: Side, second: Side, chosen, plane: Plane, window: np.ndarray) -> None:
    rows = math.ceil(len(chosen) / COLUMNS)
    grid = np.ravel(part.subplots(rows, COLUMNS, squeeze=False, sharex=True, sharey=True))
    run = next((side.source.result for side in (second, first) if side.source.result is not None), None)
    for axes, frames in zip(grid, chosen, strict=False):
        time = float(first.fabric.times[frames[0]])
        if run is not None:
            draw_obstacles(axes, plane, [o for o in obstacles_at(run, time) if has_end(o)], window)
        for place, (side, frame) in enumerate(zip((first, second), frames, strict=True)):
            style = line_style(place)
            draw_bag(
                axes,
                plane,
                side.fabric.points(frame),
                side.fabric.triangles,
                colors=style["color"],
                linewidths=style["lw"],
            )
        title = f"{1e3 * time:.1f} ms"
        if same_mesh(first, second):
            title += f"   RMS distance {1e3 * np.sqrt(np.mean(distances(first, second, *frames) ** 2)):.1f} mm"
        axes.set_title(title, size=9)
        axes.set(aspect="equal", xlim=window[0], ylim=window[1])
    for axes in grid[len(chosen) :]:
        axes.set_axis_off()
    right, up = across(plane)
    part.supxlabel(f"{AXES[right]} [mm]", size=9.5)
    part.supylabel(f"{AXES[up]} [mm]", size=9.5)


def _pictures(part, first: Side, second: Side, chosen, view: str) -> None:
    """The bags of the last time: coloured by the distance where the meshes agree, side by side where they do not."""
    one, other = chosen[-1]
    towards = axes_of(view)[2]
    deployments = [Deployment(first.fabric, first.source.result), Deployment(second.fabric, second.source.result)]
    frames = [one, other]
    if same_mesh(first, second):
        away = np.zeros((len(first.fabric.times), len(first.fabric.reference)))
        away[one] = distances(first, second, one, other)
        colouring = Colouring(Field("distance", "m", True, away), 0.0, max(float(away[one].max()), 1e-9))
        deployments[0] = Deployment(first.fabric, first.source.result, colouring)
    seen = [points for d, frame in zip(deployments, frames, strict=True) for points in d.seen([frame], towards)]
    camera = Camera.around(seen, view, *PICTURE)
    panels = part.subplots(1, 2, width_ratios=[1.0, 1.0])
    titles = [f"{first.label}, coloured by the distance" if same_mesh(first, second) else first.label, second.label]
    for axes, deployment, frame, title in zip(panels, deployments, frames, titles, strict=True):
        axes.imshow(
            on_white(paint(scene_of([deployment], [frame], camera, None), camera, 2)), interpolation="antialiased"
        )
        axes.set_axis_off()
        axes.set_title(f"{title}, {1e3 * float(first.fabric.times[one]):.1f} ms", size=9)
    if same_mesh(first, second):
        high = 1e3 * deployments[0].colouring.high
        bar = part.colorbar(ScalarMappable(Normalize(0.0, high), COLOURS), ax=panels, fraction=0.03, pad=0.01)
        bar.outline.set_visible(False)
        bar.set_label("distance [mm]")
