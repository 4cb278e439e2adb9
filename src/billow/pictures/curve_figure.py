"""Curves over one another, a panel for each quantity."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from billow.pictures.curves import Curve
from billow.pictures.sheet import one_line
from billow.pictures.shown_units import factor_of, shown_unit

LINES = ("#22303c", "#0f9d76", "#d55e00", "#0072b2", "#8e5ea2", "#b8860b", "#c2185b", "#4f9fd1")
"""Of runs, one after the other: distinguishable with any colour vision, also by their dashes from the ninth on."""
DASHES = ("-", "--", ":", "-.")
WIDTH, PANEL_HEIGHT, HEAD, LEGEND_LINE = 9.2, 2.9, 0.4, 0.25
"""[inches]"""
LONGEST_LABEL, LONGEST_TITLE = 44, 90
RESOLUTION = 140


def curve_figure(panels: Sequence[Mapping[str, Curve]], title: str = "", units: Sequence[str] = ()) -> Figure:
    """A panel for each mapping from labels to curves of one quantity; a label has one colour in all of them. To be used
    within `sheet.printed`."""
    labels = list(dict.fromkeys(label for panel in panels for label in panel))
    columns = 1 if len(panels) == 1 else 2
    rows = math.ceil(len(panels) / columns)
    legend_columns = legend_width(labels)
    height = HEAD + rows * PANEL_HEIGHT + LEGEND_LINE * math.ceil(len(labels) / legend_columns)
    figure = Figure(figsize=(WIDTH if columns > 1 else 0.75 * WIDTH, height), dpi=RESOLUTION, layout="constrained")
    grid = np.ravel(figure.subplots(rows, columns, squeeze=False))
    for axes, panel in zip(grid, panels, strict=False):
        draw_curves(axes, panel, labels, units)
    for axes in grid[len(panels) :]:
        axes.set_axis_off()
    if title:
        figure.suptitle(one_line(title, LONGEST_TITLE), x=0.01, ha="left", weight="bold", fontsize=10.5)
    put_legend(figure, labels)
    return figure


def draw_curves(axes: Axes, curves: Mapping[str, Curve], labels: Sequence[str], units: Sequence[str] = ()) -> None:
    """Curves of one quantity in their colours, by their place among all labels."""
    any_curve = next(iter(curves.values()))
    largest = max((abs(curve.peak[0]) for curve in curves.values()), default=0.0)
    unit = shown_unit(any_curve.unit, largest, units)
    time_unit = shown_unit("s", 0.0, units)
    for label, curve in curves.items():
        values = curve.values / factor_of(curve.unit, unit)
        axes.plot(curve.times / factor_of("s", time_unit), values, **line_style(labels.index(label)))
    axes.set_title(one_line(any_curve.title, 60))
    axes.set(xlabel=f"time [{time_unit}]", ylabel=f"[{unit}]")
    axes.grid(True)
    axes.margins(x=0.0)
    if not any(np.isfinite(curve.values).any() for curve in curves.values()):
        axes.text(0.5, 0.5, "no numbers", transform=axes.transAxes, ha="center", va="center")


def line_style(place: int) -> dict:
    """Colour, dashes and width of a line, by its place among the labels."""
    first = {"color": LINES[place % len(LINES)], "ls": DASHES[place // len(LINES) % len(DASHES)]}
    return first | {"lw": 2.2 if place == 0 else 1.4, "zorder": 2.0 + 0.01 * place}


def legend_width(labels: Sequence[str]) -> int:
    """Columns of a legend."""
    longest = max((min(len(label), LONGEST_LABEL) for label in labels), default=1)
    return max(1, min(len(labels), int(110 / (longest + 8))))


def put_legend(figure: Figure, labels: Sequence[str]) -> None:
    """Under all panels: names of runs may be long. One label needs none, for then it stands in the title."""
    if len(labels) < 2:
        return
    handles = [Line2D([], [], **line_style(k)) for k in range(len(labels))]
    names = [shortened(one_line(label)) for label in labels]
    # A leading underscore would hide a name from a legend that finds its own.
    figure.legend(handles, names, loc="outside lower center", ncols=legend_width(labels))


def shortened(label: str) -> str:
    """A label without its middle, if it is long: ends tell runs apart."""
    if len(label) <= LONGEST_LABEL:
        return label
    return f"{label[: LONGEST_LABEL // 3]}…{label[-(LONGEST_LABEL - LONGEST_LABEL // 3 - 1) :]}"
