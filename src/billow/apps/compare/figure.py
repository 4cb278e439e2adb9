"""A comparison as one figure: curves over one another, sections over one another, and the bag coloured by distance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from billow.apps.compare.differences import Comparison, distances, frames_in_common, same_mesh
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


def comparison_figure(comparisons: Sequence[Comparison], plane: Plane, view: str, units: Sequence[str] = ()) -> Figure:
    """The figure. To be used within `sheet.printed`."""
    sides = [*(comparison.side for comparison in comparisons), comparisons[-1].reference]
    labels = [side.label for side in sides]
    names = list(dict.fromkeys(found.name for comparison in comparisons for found in comparison.curves))
    bags = [place for place, side in enumerate(sides) if side.fabric is not None]
    chosen = _some(frames_in_common(*(sides[place] for place in bags))) if len(bags) > 1 else []
    window = _window([sides[place] for place in bags], chosen, plane) if chosen else None
    rows = []
    if names:
        rows.append(CURVE_HEIGHT * math.ceil(len(names) / 2))
    if chosen:
        aspect = float(np.ptp(window[1]) / np.ptp(window[0]))
        one = float(np.clip(WIDTH / COLUMNS * aspect + 0.35, *SECTION_HEIGHT))
        rows += [one * math.ceil(len(chosen) / COLUMNS) + 0.3, PICTURE_HEIGHT * math.ceil(len(bags) / 2)]
    figure = Figure(figsize=(WIDTH, sum(rows) + LEGEND_HEIGHT), dpi=RESOLUTION, layout="constrained")
    put_legend(figure, labels)
    parts = iter(np.atleast_1d(figure.subfigures(len(rows), 1, height_ratios=rows)))
    if names:
        grid = np.ravel(next(parts).subplots(math.ceil(len(names) / 2), 2, squeeze=False))
        for axes, name in zip(grid, names, strict=False):
            _curves(axes, name, comparisons, labels, units)
        for axes in grid[len(names) :]:
            axes.set_axis_off()
    if chosen:
        _sections(next(parts), sides, bags, chosen, plane, window)
        _pictures(next(parts), [sides[place] for place in bags], chosen, view)
    return figure


def _curves(axes, name: str, comparisons: Sequence[Comparison], labels: Sequence[str], units: Sequence[str]) -> None:
    drawn, ratings = {}, []
    for label, comparison in zip(labels, comparisons, strict=False):
        found = next((found for found in comparison.curves if found.name == name), None)
        if found is not None:
            drawn |= {label: found.first, labels[-1]: found.second}
            ratings.append("not rated" if found.rating is None else f"{found.rating.overall:.2f}, {found.rating.grade}")
    draw_curves(axes, {label: drawn[label] for label in labels if label in drawn}, labels, units)
    if any(rating != "not rated" for rating in ratings):
        axes.set_xlabel(f"{axes.get_xlabel()}      ISO/TS 18571: {'; '.join(ratings)}")


def _some(common: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """Up to six of the frames, the last among them, and not the first, which is the flat bag, if there are others."""
    places = np.linspace(0, len(common) - 1, SECTIONS + 1).round().astype(int)
    return [common[k] for k in np.unique(places[1:])] if common else []


def _window(bags: Sequence[Side], chosen, plane: Plane) -> np.ndarray:
    return window_of(plane, [bag.fabric.points(k) for frames in chosen for bag, k in zip(bags, frames, strict=True)])


def _sections(part, sides: Sequence[Side], bags: Sequence[int], chosen, plane: Plane, window: np.ndarray) -> None:
    """bags: the places of the sides that have one."""
    rows = math.ceil(len(chosen) / COLUMNS)
    grid = np.ravel(part.subplots(rows, COLUMNS, squeeze=False, sharex=True, sharey=True))
    run = next((side.source.result for side in reversed(sides) if side.source.result is not None), None)
    for axes, frames in zip(grid, chosen, strict=False):
        time = float(sides[bags[0]].fabric.times[frames[0]])
        if run is not None:
            draw_obstacles(axes, plane, [o for o in obstacles_at(run, time) if has_end(o)], window)
        for place, frame in zip(bags, frames, strict=True):
            style, fabric = line_style(place), sides[place].fabric
            draw_bag(axes, plane, fabric.points(frame), fabric.triangles, colors=style["color"], linewidths=style["lw"])
        title = f"{1e3 * time:.1f} ms"
        if len(bags) == 2 and same_mesh(*(sides[place] for place in bags)):
            away = distances(*(sides[place] for place in bags), *frames)
            title += f"   RMS distance {1e3 * np.sqrt(np.mean(away**2)):.1f} mm"
        axes.set_title(title, size=9)
        axes.set(aspect="equal", xlim=window[0], ylim=window[1])
    for axes in grid[len(chosen) :]:
        axes.set_axis_off()
    right, up = across(plane)
    part.supxlabel(f"{AXES[right]} [mm]", size=9.5)
    part.supylabel(f"{AXES[up]} [mm]", size=9.5)


def _pictures(part, bags: Sequence[Side], chosen, view: str) -> None:
    """The bags of the last time: coloured by the distance from the last where the meshes agree."""
    frames, towards, reference = chosen[-1], axes_of(view)[2], bags[-1]
    away = {
        place: distances(bag, reference, frames[place], frames[-1])
        for place, bag in enumerate(bags[:-1])
        if same_mesh(bag, reference)
    }
    high = max((float(of.max()) for of in away.values()), default=0.0) or 1e-9
    deployments = []
    for place, bag in enumerate(bags):
        colouring = None
        if place in away:
            values = np.zeros((len(bag.fabric.times), len(bag.fabric.reference)))
            values[frames[place]] = away[place]
            colouring = Colouring(Field("distance", "m", True, values), 0.0, high)
        deployments.append(Deployment(bag.fabric, bag.source.result, colouring))
    seen = [points for d, frame in zip(deployments, frames, strict=True) for points in d.seen([frame], towards)]
    camera = Camera.around(seen, view, *PICTURE)
    panels = part.subplots(math.ceil(len(bags) / 2), 2, squeeze=False)
    for axes in np.ravel(panels):
        axes.set_axis_off()
    for place, (axes, deployment, frame) in enumerate(zip(np.ravel(panels), deployments, frames, strict=False)):
        axes.imshow(
            on_white(paint(scene_of([deployment], [frame], camera, None), camera, 2)), interpolation="antialiased"
        )
        title = f"{bags[place].label}{', coloured by the distance' if place in away else ''}"
        axes.set_title(f"{title}, {1e3 * float(bags[0].fabric.times[frames[0]]):.1f} ms", size=9)
    if away:
        bar = part.colorbar(ScalarMappable(Normalize(0.0, 1e3 * high), COLOURS), ax=panels, fraction=0.03, pad=0.01)
        bar.outline.set_visible(False)
        bar.set_label(f"distance from {reference.label} [mm]")
